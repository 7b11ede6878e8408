//! Maps of BRDFs, and the constants of turning functions, as plain numbers for shaders.
//!
//! There the terms of a function are *paired*: the cosine and the sine term of (l, m) stand at l(l + 1)/2 + m.

use super::basis::{BANDS, MAX_ORDER, row};
use super::brdf::HarmonicBrdf;
use super::conversion::product;
use super::read::cosines;
use super::rotation::quarter_turn;
use glam::Vec3A;

/// Pairs of a function of so many bands.
pub const fn pairs(bands: usize) -> usize {
    bands * (bands + 1) / 2
}

/// Bands of a function that is turned, at most.
pub const MAX_BANDS: usize = BANDS;

/// Products of hemispherical with spherical functions: those of band k, band l and m at (k · [`MAX_ORDER`] + l) · [`MAX_ORDER`] + m.
pub const PRODUCTS: usize = 0;

/// The quarter turn about y of cosine terms, then of sine terms: its element from m to m′ of band l at
/// l(l + 1)(2l + 1)/6 + m(l + 1) + m′.
pub const QUARTERS: [usize; 2] = {
    let first = PRODUCTS + BANDS * MAX_ORDER * MAX_ORDER;
    [first, first + QUARTER]
};
const QUARTER: usize = BANDS * (BANDS + 1) * (2 * BANDS + 1) / 6;

/// The cosine of the Lambertian part by band (its terms of m = 0, which are all): in hemispherical functions, in spherical ones, and in
/// those that a hemispherical function is turned by.
pub const COSINES: [usize; 3] = {
    let first = QUARTERS[1] + QUARTER;
    [first, first + BANDS, first + 2 * BANDS]
};

/// All constants.
pub fn constants() -> Vec<f32> {
    let mut out = Vec::with_capacity(COSINES[2] + BANDS);
    for k in 0..BANDS {
        for l in 0..MAX_ORDER {
            out.extend((0..MAX_ORDER).map(|m| if m <= k.min(l) { product(m, k, l) } else { 0.0 }));
        }
    }
    for sine in [false, true] {
        for l in 0..BANDS {
            for from in 0..=l {
                out.extend((0..=l).map(|to| quarter_turn(sine, l, from, to)));
            }
        }
    }
    for cosine in cosines() {
        out.extend((0..BANDS).map(|l| cosine[0][row(l)]));
    }
    out
}

/// A texel of a map.
#[derive(Clone, Copy, Debug, Default)]
pub struct FlatTexel {
    /// Where its cosine terms begin; the sine terms follow where there are any.
    pub first: u32,
    /// Its order.
    pub order: u32,
    /// Whether it has sine terms.
    pub sines: bool,
}

impl HarmonicBrdf {
    /// Appends the functions of the map, and says where they are.
    pub fn flatten(&self, numbers: &mut Vec<f32>) -> Vec<FlatTexel> {
        let flat = |(order, packed): (usize, &[f32])| {
            let first = numbers.len() as u32;
            let parts = packed.chunks_exact(row(order));
            let sines = parts.len() > 1;
            for part in parts {
                (0..order).for_each(|l| numbers.extend(&part[row(l)..=row(l) + l]));
            }
            FlatTexel { first, order: order as u32, sines }
        };
        self.functions().map(flat).collect()
    }

    /// Texels about a local direction and their shares of the lobe; those that are not cached have none.
    pub fn blend(&self, wo: Vec3A) -> [(usize, f32); 4] {
        let cached = 1.0 - self.outgoing(wo).traced;
        self.places(wo).map(|(i, share)| (i, if share > 0.0 && self.is_cached(i) { share / cached } else { 0.0 }))
    }

    /// Signs of x and y of a direction, where the lobe is that of the first quadrant with x and y turned round.
    pub fn signs(&self, wo: Vec3A) -> [bool; 2] {
        [wo.x, wo.y].map(|x| !self.is_isotropic() && x.is_sign_negative())
    }
}
