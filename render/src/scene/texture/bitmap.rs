//! Images as textures.

use super::super::Rgb;
use super::stored::Stored;
use crate::simd::prefetch;
use glam::{Affine2, Vec2};
use serde::{Deserialize, Serialize};

/// Texels, row by row from the top of the image.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Texels {
    /// Three channels, linear.
    Rgb(Vec<[f32; 3]>),
    /// One channel, linear, shown in all three.
    Gray(Vec<f32>),
    /// As they stand in a file.
    Stored(Stored),
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
            Self::Stored(t) => t.raster().len(),
        }
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Memory that the texels take; other textures may share it.
    pub fn bytes(&self) -> usize {
        match self {
            Self::Rgb(t) => size_of_val(&t[..]),
            Self::Gray(t) => size_of_val(&t[..]),
            Self::Stored(t) => t.raster().samples.bytes(),
        }
    }

    /// Texel `i`.
    #[inline]
    pub fn get(&self, i: usize) -> Rgb {
        match self {
            Self::Rgb(t) => Rgb::from_array(t[i]),
            Self::Gray(t) => Rgb::splat(t[i]),
            Self::Stored(t) => t.get(i),
        }
    }

    /// Reads a number of texel `i`, so that it comes to the cache.
    #[inline(always)]
    fn touch(&self, i: usize) {
        match self {
            Self::Rgb(t) => prefetch(&t[i][0]),
            Self::Gray(t) => prefetch(&t[i]),
            Self::Stored(t) => t.touch(i),
        }
    }

    /// Smallest and largest first channel of all texels; 0 without any.
    pub fn bounds(&self) -> [f32; 2] {
        let first = (0..self.len()).map(|i| self.get(i).x);
        first.map(|x| [x, x]).reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])]).unwrap_or_default()
    }

    /// Whether every texel is.
    pub fn is_finite(&self) -> bool {
        match self {
            Self::Rgb(t) => t.iter().flatten().all(|x| x.is_finite()),
            Self::Gray(t) => t.iter().all(|x| x.is_finite()),
            Self::Stored(t) => t.is_finite(),
        }
    }
}

impl Wrap {
    /// Texel index `i` of an axis of `n` texels, brought inside.
    #[inline]
    fn index(self, i: i32, n: i32) -> usize {
        (match self {
            // Divisions are slow, and most points lie inside.
            Self::Repeat if (0..n).contains(&i) => i,
            Self::Repeat => i.rem_euclid(n),
            Self::Clamp => i.clamp(0, n - 1),
            Self::Mirror => {
                let j = i.rem_euclid(2 * n);
                if j < n { j } else { 2 * n - 1 - j }
            }
        }) as usize
    }
}

/// The texels around a point.
pub(super) enum Taps {
    /// The one that contains it.
    One(usize),
    /// Four around it, row by row, and how far it is from the first to the last.
    Four([usize; 4], Vec2),
}

impl Taps {
    #[inline(always)]
    pub(super) fn blend(&self, texel: impl Fn(usize) -> Rgb) -> Rgb {
        match *self {
            Self::One(i) => texel(i),
            Self::Four([a, b, c, d], f) => {
                let (top, bottom) = (texel(a).lerp(texel(b), f.x), texel(c).lerp(texel(d), f.x));
                top.lerp(bottom, f.y)
            }
        }
    }
}

impl Bitmap {
    /// Value at surface coordinates `uv`.
    pub fn eval(&self, uv: Vec2) -> Rgb {
        let taps = self.taps(uv);
        match &self.texels {
            Texels::Rgb(t) => taps.blend(|i| Rgb::from_array(t[i])),
            Texels::Gray(t) => taps.blend(|i| Rgb::splat(t[i])),
            Texels::Stored(t) => t.blend(&taps),
        }
    }

    /// Reads a texel of each row that [`Bitmap::eval`] will ask for: whoever has many values to look up waits for the memory once.
    #[inline(always)]
    pub fn touch(&self, uv: Vec2) {
        match self.taps(uv) {
            Taps::One(i) => self.texels.touch(i),
            Taps::Four([top, _, bottom, _], _) => {
                self.texels.touch(top);
                self.texels.touch(bottom);
            }
        }
    }

    #[inline(always)]
    fn taps(&self, uv: Vec2) -> Taps {
        let (w, h) = (self.width as i32, self.height as i32);
        let [wrap_u, wrap_v] = self.wrap;
        let (column, row) = (|x| wrap_u.index(x, w), |y| wrap_v.index(y, h) * w as usize);
        // Far outside, f32 has no fraction left to look up: the limit keeps the integer arithmetic exact.
        let p = (self.to_uv.transform_point2(uv) * Vec2::new(w as f32, h as f32))
            .clamp(Vec2::splat(-1e9), Vec2::splat(1e9));
        match self.interpolation {
            Interpolation::Nearest => Taps::One(row(p.y.floor() as i32) + column(p.x.floor() as i32)),
            Interpolation::Bilinear => {
                let p = p - 0.5;
                let (x, y) = (p.x.floor() as i32, p.y.floor() as i32);
                let (left, right, top, bottom) = (column(x), column(x + 1), row(y), row(y + 1));
                Taps::Four([top + left, top + right, bottom + left, bottom + right], p - p.floor())
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
