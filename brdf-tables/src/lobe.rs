//! The generalized cosine lobe, used by the fit and by the look-up.

use crate::real::Real;
use glam::DVec3;

/// a max(0, axis · w)ⁿ. The axis is a unit vector; amplitude (sr⁻¹, signed) and exponent are kept apart from it, because
/// a rounding error ε in the paper's C = |a|^(1/n) axis grows to nε in the value.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Lobe {
    /// Unit axis.
    pub axis: DVec3,
    /// Value on the axis, sr⁻¹.
    pub amplitude: f64,
    /// Exponent n > 0.
    pub exponent: f64,
}

impl Lobe {
    /// Value towards the unit vector `w`.
    pub fn value(&self, w: DVec3) -> f64 {
        self.amplitude * Real::powf(self.axis.dot(w), self.exponent)
    }

    /// (Cx, Cy, Cz) of the paper's (C·w)ⁿ (eq. 10); the amplitude must not be negative.
    pub fn raw(&self) -> [f64; 3] {
        (self.axis * self.amplitude.max(0.0).powf(1.0 / self.exponent)).to_array()
    }
}
