//! Indirect light of a pixel while it is summed.

use crate::bsdf::Split;
use crate::scene::Rgb;
use core::ops::AddAssign;

/// Indirect light, summed over samples.
#[derive(Clone, Copy, Debug, Default)]
pub struct Indirect {
    /// All of it.
    pub light: Split,
    /// What it would be by the first half of the paths alone: records say the same twice.
    pub half: Rgb,
}

impl Indirect {
    /// All of it from records, for all samples of a pixel.
    #[inline]
    pub(super) fn held(light: Split) -> Self {
        Self { light, half: light.sum() }
    }
}

impl AddAssign for Indirect {
    #[inline]
    fn add_assign(&mut self, other: Self) {
        self.light = self.light + other.light;
        self.half += other.half;
    }
}
