//! One signature for every way to evaluate the mean BRDF.

use crate::batch::CapBatch;
use crate::brdf::Specular;
use crate::cap::Cap;
use crate::quadrature::mean_brdf;
use glam::{DVec3, Vec3};

/// The mean BRDF F(cap; wo) of eq. 9 for the specular part of a material at unit strength, in sr⁻¹.
///
/// Implementations differ in cost and error only, so that they can be charted one against the other.
pub trait MeanBrdf: Sync {
    /// Short name for reports.
    fn name(&self) -> &'static str;

    /// F for one cap, in f64: the readable twin of [`MeanBrdf::values`]. Zero for `wo` below the horizon.
    fn value(&self, cap: &Cap, wo: DVec3) -> f64;

    /// F for many caps seen from one direction (unit, z > 0), into `out[..caps.len()]`. Does not allocate.
    ///
    /// # Panics
    /// If `out` is shorter than the batch.
    fn values(&self, caps: &CapBatch, wo: Vec3, out: &mut [f32]);
}

/// The mean BRDF by deterministic quadrature to a relative tolerance: the reference.
#[derive(Clone, Copy, Debug)]
pub struct Exact {
    /// The model.
    pub specular: Specular,
    /// Relative tolerance of every value.
    pub tolerance: f64,
}

impl MeanBrdf for Exact {
    fn name(&self) -> &'static str {
        "exact"
    }

    fn value(&self, cap: &Cap, wo: DVec3) -> f64 {
        mean_brdf(&self.specular, cap, wo, self.tolerance, 0.0)
    }

    fn values(&self, caps: &CapBatch, wo: Vec3, out: &mut [f32]) {
        for (i, out) in out[..caps.len()].iter_mut().enumerate() {
            *out = self.value(&caps.cap(i), wo.as_dvec3()) as f32;
        }
    }
}
