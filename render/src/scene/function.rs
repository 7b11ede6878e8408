//! Scattering by a function that somebody else has: of data for which there is no formula.

use super::Rgb;
use glam::{Vec2, Vec3A};
use serde::{Deserialize, Serialize};
use std::fmt::Debug;
use std::sync::Arc;

/// f_r of a surface that only reflects, in the local frame (x along u, z the normal). Both directions are above the horizon.
pub trait Reflection: Debug + Send + Sync {
    /// f_r in sr⁻¹ without the cosine, and the density of [`Reflection::sample`] at `wi` in sr⁻¹.
    fn eval(&self, wi: Vec3A, wo: Vec3A) -> (Rgb, f32);
    /// A direction to the light for a point of the unit square; `None` where the sample is lost.
    fn sample(&self, wo: Vec3A, u: Vec2) -> Option<Vec3A>;
}

/// A shared [`Reflection`], as materials have it.
///
/// Its encoding tells functions apart and does not hold them: a scene that was encoded and read back is refused by
/// [`Scene::validate`](super::Scene::validate).
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Function {
    /// Of what the function was made of.
    checksum: u64,
    /// Rough share of light that is reflected, for denoisers.
    albedo: Rgb,
    #[serde(skip)]
    function: Option<Arc<dyn Reflection>>,
}

impl Function {
    /// A function with the checksum of what it was made of. Its albedo is measured by some of its samples.
    pub fn new(checksum: u64, function: Arc<dyn Reflection>) -> Self {
        const SAMPLES: usize = 1024;
        let mut albedo = Rgb::ZERO;
        for i in 0..SAMPLES {
            // The sequences of Roberts 2018, for the view and for the sample.
            let at = |a: f64| (0.5 + i as f64 * a).fract() as f32;
            let wo = crate::frame::cosine_hemisphere(Vec2::new(at(0.754_877_666), at(0.569_840_291)));
            let sample = function.sample(wo, Vec2::new(at(0.819_172_513), at(0.671_043_607)));
            if let Some(wi) = sample.filter(|wi| wi.z > 0.0 && wo.z > 0.0) {
                let (f, pdf) = function.eval(wi, wo);
                let weight = f * (wi.z / pdf);
                albedo += if weight.is_finite() { weight } else { Rgb::ZERO };
            }
        }
        Self { checksum, albedo: (albedo / SAMPLES as f32).clamp(Rgb::ZERO, Rgb::ONE), function: Some(function) }
    }

    /// Rough share of light that is reflected.
    pub fn albedo(&self) -> Rgb {
        self.albedo
    }

    /// The function; `None` after it was encoded and read back.
    #[inline]
    pub fn get(&self) -> Option<&dyn Reflection> {
        self.function.as_deref()
    }
}

impl PartialEq for Function {
    fn eq(&self, other: &Self) -> bool {
        self.checksum == other.checksum && self.albedo == other.albedo
    }
}
