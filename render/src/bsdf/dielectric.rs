//! Smooth interfaces that reflect and transmit.

use super::{Scatter, fresnel, mirror};
use crate::scene::Rgb;
use glam::Vec3A;

/// An interface of two dielectrics.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Dielectric {
    /// Index inside over outside.
    pub eta: f32,
    pub reflectance: Rgb,
    pub transmittance: Rgb,
}

impl Dielectric {
    /// Reflects with the Fresnel share as probability, refracts otherwise; transmitted radiance changes with the
    /// square of the index.
    #[inline]
    pub fn sample(&self, wo: Vec3A, choice: f32) -> Option<Scatter> {
        let interface = fresnel::dielectric(wo.z, self.eta);
        if choice < interface.reflectance {
            return Some(Scatter::Delta { wi: mirror(wo), weight: self.reflectance, eta: 1.0 });
        }
        let wi = Vec3A::new(-wo.x / interface.eta, -wo.y / interface.eta, interface.cos_t);
        let weight = self.transmittance / (interface.eta * interface.eta);
        Some(Scatter::Delta { wi, weight, eta: interface.eta })
    }
}

/// A slab without thickness.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ThinDielectric {
    /// Index inside over outside.
    pub eta: f32,
    pub reflectance: Rgb,
    pub transmittance: Rgb,
}

impl ThinDielectric {
    /// As [`Dielectric::sample`], with all reflections between the two interfaces summed: R' = 2R/(1 + R).
    #[inline]
    pub fn sample(&self, wo: Vec3A, choice: f32) -> Option<Scatter> {
        let r = fresnel::dielectric(wo.z.abs(), self.eta).reflectance;
        if choice < 2.0 * r / (1.0 + r) {
            return Some(Scatter::Delta { wi: mirror(wo), weight: self.reflectance, eta: 1.0 });
        }
        Some(Scatter::Delta { wi: -wo, weight: self.transmittance, eta: 1.0 })
    }
}
