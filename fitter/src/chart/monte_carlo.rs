//! Monte Carlo as one more way to evaluate the mean BRDF.

use brdf_tables::batch::CapBatch;
use brdf_tables::brdf::Specular;
use brdf_tables::cap::Cap;
use brdf_tables::mean::MeanBrdf;
use core::f64::consts::{FRAC_PI_2, TAU};
use fitter::integrate::mean_brdf_mc;
use glam::{DVec3, Vec3};

/// The Monte Carlo integration of the fitter at a fixed number of samples.
pub struct MonteCarlo {
    /// The model.
    pub specular: Specular,
    /// Samples per value.
    pub samples: usize,
    /// Seed of the sequences.
    pub seed: u64,
}

impl MeanBrdf for MonteCarlo {
    fn name(&self) -> &'static str {
        "Monte Carlo"
    }

    fn value(&self, cap: &Cap, wo: DVec3) -> f64 {
        // Values at different directions must not share their noise.
        let seed = self.seed ^ wo.x.to_bits() ^ wo.y.to_bits().rotate_left(21);
        mean_brdf_mc(&self.specular, cap, wo, self.samples, seed).value
    }

    fn values(&self, caps: &CapBatch, wo: Vec3, out: &mut [f32]) {
        for (i, out) in out[..caps.len()].iter_mut().enumerate() {
            let (axis, solid_angle) = caps.get(i);
            let theta = f64::from(axis.truncate().length().atan2(axis.z)).min(FRAC_PI_2);
            let cap = Cap::new(theta, f64::from(axis.y.atan2(axis.x)), f64::from(solid_angle).min(TAU));
            *out = cap.map_or(0.0, |cap| self.value(&cap, wo.as_dvec3()) as f32);
        }
    }
}
