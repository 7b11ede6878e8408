//! Values that vary over a surface.

use super::Rgb;
use core::ops::{Add, Mul};
use glam::{Affine2, Vec2, Vec4};
use serde::{Deserialize, Serialize};

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

/// Decoded linear texels, row by row from the top of the image.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Texels {
    /// Three channels.
    Rgb(Vec<[f32; 3]>),
    /// One channel, shown in all three.
    Gray(Vec<f32>),
}

/// What lies outside [0, 1)².
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Wrap {
    /// The image again.
    #[default]
    Repeat,
    /// The image mirrored at every border.
    Mirror,
    /// The border texel.
    Clamp,
}

/// How texels become a function.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Interpolation {
    /// The texel that contains the point.
    Nearest,
    /// Linear between the four nearest texel centres.
    #[default]
    Bilinear,
}

/// An image as a texture. (u, v) = (0, 0) is the outer corner of the first texel of the first (top) row and v grows
/// downwards: a loader whose format counts v from the bottom flips it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Bitmap {
    /// Texels per row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// `width · height` finite values.
    pub texels: Texels,
    /// What lies outside along u and along v.
    pub wrap: [Wrap; 2],
    /// How texels become a function.
    pub interpolation: Interpolation,
    /// Whether the second set of texture coordinates is meant.
    pub second_uv: bool,
    /// Surface coordinates to texture coordinates.
    pub to_uv: Affine2,
}

impl Texels {
    /// Number of texels.
    pub fn len(&self) -> usize {
        match self {
            Self::Rgb(t) => t.len(),
            Self::Gray(t) => t.len(),
        }
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Memory that the texels take.
    pub fn bytes(&self) -> usize {
        match self {
            Self::Rgb(t) => size_of_val(&t[..]),
            Self::Gray(t) => size_of_val(&t[..]),
        }
    }

    /// Texel `i`.
    #[inline]
    pub fn get(&self, i: usize) -> Rgb {
        match self {
            Self::Rgb(t) => Rgb::from_array(t[i]),
            Self::Gray(t) => Rgb::splat(t[i]),
        }
    }
}

impl Wrap {
    /// Texel index `i` of an axis of `n` texels, brought inside.
    #[inline]
    fn index(self, i: i32, n: i32) -> usize {
        (match self {
            Self::Repeat => i.rem_euclid(n),
            Self::Clamp => i.clamp(0, n - 1),
            Self::Mirror => {
                let j = i.rem_euclid(2 * n);
                if j < n { j } else { 2 * n - 1 - j }
            }
        }) as usize
    }
}

impl Bitmap {
    /// Value at surface coordinates `uv`.
    pub fn eval(&self, uv: Vec2) -> Rgb {
        let (w, h) = (self.width as i32, self.height as i32);
        let [wrap_u, wrap_v] = self.wrap;
        let texel = |x: i32, y: i32| self.texels.get(wrap_v.index(y, h) * w as usize + wrap_u.index(x, w));
        // Far outside, f32 has no fraction left to look up: the limit keeps the integer arithmetic exact.
        let p = (self.to_uv.transform_point2(uv) * Vec2::new(w as f32, h as f32))
            .clamp(Vec2::splat(-1e9), Vec2::splat(1e9));
        match self.interpolation {
            Interpolation::Nearest => texel(p.x.floor() as i32, p.y.floor() as i32),
            Interpolation::Bilinear => {
                let p = p - 0.5;
                let (x, y) = (p.x.floor() as i32, p.y.floor() as i32);
                let f = p - p.floor();
                let top = texel(x, y).lerp(texel(x + 1, y), f.x);
                let bottom = texel(x, y + 1).lerp(texel(x + 1, y + 1), f.x);
                top.lerp(bottom, f.y)
            }
        }
    }

    /// Mean of all texels.
    pub fn mean(&self) -> Rgb {
        let n = self.texels.len();
        let sum = (0..n).fold(glam::DVec3::ZERO, |s, i| s + self.texels.get(i).as_dvec3());
        (sum / n.max(1) as f64).as_vec3a()
    }
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
