//! Values that vary over a surface.

mod bitmap;
mod stored;

use super::Rgb;
pub use bitmap::{Bitmap, Interpolation, Texels, Wrap};
use core::ops::{Add, Mul};
use glam::{Affine2, Vec2, Vec4};
use serde::{Deserialize, Serialize};
#[cfg(feature = "formats")]
pub(crate) use stored::luminance;
pub use stored::{Reading, Stored, Transfer};

/// Index into [`super::Scene::textures`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct TextureId(pub u32);

/// Where values are looked up at a point of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coordinates {
    /// Two sets of texture coordinates.
    pub uv: [Vec2; 2],
    /// Colour and opacity of the vertices, interpolated; 1 where a mesh has none.
    pub paint: Vec4,
}

impl From<Vec2> for Coordinates {
    fn from(uv: Vec2) -> Self {
        Self { uv: [uv; 2], paint: Vec4::ONE }
    }
}

impl Add for Coordinates {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self { uv: [self.uv[0] + other.uv[0], self.uv[1] + other.uv[1]], paint: self.paint + other.paint }
    }
}

impl Mul<f32> for Coordinates {
    type Output = Self;
    fn mul(self, s: f32) -> Self {
        Self { uv: self.uv.map(|uv| uv * s), paint: self.paint * s }
    }
}

/// A colour, constant or from a texture.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum ColorTexture {
    /// The same everywhere.
    Constant(Rgb),
    /// Looked up.
    Texture(TextureId),
    /// A texture times a constant (glTF factors, Mitsuba `scale`).
    Scaled(TextureId, Rgb),
    /// A constant times the colour of the vertices, and times a texture if there is one.
    Painted(Option<TextureId>, Rgb),
}

/// A number, constant or from a texture (its first channel).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum FloatTexture {
    /// The same everywhere.
    Constant(f32),
    /// First channel of a texture.
    Texture(TextureId),
    /// The same, times a constant.
    Scaled(TextureId, f32),
    /// A constant times the opacity of the vertices, and times a texture if there is one.
    Painted(Option<TextureId>, f32),
    /// 1 where the opacity of the vertices, times a texture if there is one, reaches a threshold; 0 elsewhere.
    PaintedStep(Option<TextureId>, f32),
}

/// Something looked up by texture coordinates.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Texture {
    /// An image.
    Bitmap(Bitmap),
    /// Squares of two colours: `color0` where ⌊2u⌋ + ⌊2v⌋ is even after `to_uv`, so a period is 1 as in Mitsuba.
    Checkerboard {
        /// Colour of the square at the origin.
        color0: Rgb,
        /// The other colour.
        color1: Rgb,
        /// Surface coordinates to texture coordinates.
        to_uv: Affine2,
    },
}

impl Texture {
    /// Value at a point of a surface.
    pub fn eval(&self, at: &Coordinates) -> Rgb {
        match self {
            Self::Bitmap(b) => b.eval(at.uv[usize::from(b.second_uv)]),
            Self::Checkerboard { color0, color1, to_uv } => {
                let p = to_uv.transform_point2(at.uv[0]);
                let p = p - p.floor();
                if (p.x >= 0.5) == (p.y >= 0.5) { *color0 } else { *color1 }
            }
        }
    }

    /// Mean over the unit square of texture space.
    pub fn mean(&self) -> Rgb {
        match self {
            Self::Bitmap(b) => b.mean(),
            Self::Checkerboard { color0, color1, .. } => 0.5 * (*color0 + *color1),
        }
    }
}

impl ColorTexture {
    /// Value at a point of a surface.
    #[inline]
    pub fn eval(&self, textures: &[Texture], at: &Coordinates) -> Rgb {
        match *self {
            Self::Constant(c) => c,
            Self::Texture(t) => textures[t.0 as usize].eval(at),
            Self::Scaled(t, c) => textures[t.0 as usize].eval(at) * c,
            Self::Painted(t, c) => {
                t.map_or(Rgb::ONE, |t| textures[t.0 as usize].eval(at)) * c * Rgb::from_vec4(at.paint)
            }
        }
    }

    /// The same times `factor`.
    pub fn times(self, factor: Rgb) -> Self {
        match self {
            _ if factor == Rgb::ONE => self,
            Self::Constant(c) => Self::Constant(c * factor),
            Self::Texture(t) => Self::Scaled(t, factor),
            Self::Scaled(t, c) => Self::Scaled(t, c * factor),
            Self::Painted(t, c) => Self::Painted(t, c * factor),
        }
    }

    /// The texture, if there is one.
    pub fn texture(&self) -> Option<TextureId> {
        match *self {
            Self::Constant(_) => None,
            Self::Texture(t) | Self::Scaled(t, _) => Some(t),
            Self::Painted(t, _) => t,
        }
    }

    /// The constant factor.
    pub fn factor(&self) -> Rgb {
        match *self {
            Self::Texture(_) => Rgb::ONE,
            Self::Constant(c) | Self::Scaled(_, c) | Self::Painted(_, c) => c,
        }
    }

    /// Mean over texture space; the vertices count as white.
    pub fn mean(&self, textures: &[Texture]) -> Rgb {
        match *self {
            Self::Constant(c) => c,
            Self::Texture(t) => textures[t.0 as usize].mean(),
            Self::Scaled(t, c) => textures[t.0 as usize].mean() * c,
            Self::Painted(t, c) => t.map_or(Rgb::ONE, |t| textures[t.0 as usize].mean()) * c,
        }
    }
}

impl FloatTexture {
    /// Value at a point of a surface.
    #[inline]
    pub fn eval(&self, textures: &[Texture], at: &Coordinates) -> f32 {
        match *self {
            Self::Constant(c) => c,
            Self::Texture(t) => textures[t.0 as usize].eval(at).x,
            Self::Scaled(t, c) => textures[t.0 as usize].eval(at).x * c,
            Self::Painted(t, c) => t.map_or(1.0, |t| textures[t.0 as usize].eval(at).x) * c * at.paint.w,
            Self::PaintedStep(t, threshold) => {
                let opacity = t.map_or(1.0, |t| textures[t.0 as usize].eval(at).x) * at.paint.w;
                if opacity >= threshold { 1.0 } else { 0.0 }
            }
        }
    }

    /// The same times `factor`; a step keeps its height.
    pub fn times(self, factor: f32) -> Self {
        match self {
            Self::Constant(c) => Self::Constant(c * factor),
            Self::Texture(t) => Self::Scaled(t, factor),
            Self::Scaled(t, c) => Self::Scaled(t, c * factor),
            Self::Painted(t, c) => Self::Painted(t, c * factor),
            Self::PaintedStep(..) => self,
        }
    }

    /// The texture, if there is one.
    pub fn texture(&self) -> Option<TextureId> {
        match *self {
            Self::Constant(_) => None,
            Self::Texture(t) | Self::Scaled(t, _) => Some(t),
            Self::Painted(t, _) | Self::PaintedStep(t, _) => t,
        }
    }

    /// Mean over texture space; the vertices count as opaque.
    pub fn mean(&self, textures: &[Texture]) -> f32 {
        match *self {
            Self::Constant(c) => c,
            Self::Texture(t) => textures[t.0 as usize].mean().x,
            Self::Scaled(t, c) => textures[t.0 as usize].mean().x * c,
            Self::Painted(t, c) => t.map_or(1.0, |t| textures[t.0 as usize].mean().x) * c,
            Self::PaintedStep(..) => 1.0,
        }
    }
}
