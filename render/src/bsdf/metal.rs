//! Metals, smooth and rough, and glTF's mixture of metal and plastic.

use super::{Facets, Scatter, Split, Value, fresnel, mirror};
use crate::frame::cosine_hemisphere;
use crate::scene::Rgb;
use core::f32::consts::FRAC_1_PI;
use glam::{Vec2, Vec3A};

/// A smooth conductor.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Mirror {
    pub eta: Rgb,
    pub k: Rgb,
    pub specular: Rgb,
}

impl Mirror {
    #[inline]
    pub fn reflectance(&self, cos: f32) -> Rgb {
        fresnel::conductor(cos, self.eta, self.k) * self.specular
    }

    #[inline]
    pub fn sample(&self, wo: Vec3A) -> Option<Scatter> {
        Some(Scatter::Delta { wi: mirror(wo), weight: self.reflectance(wo.z), eta: 1.0 })
    }
}

/// A conductor with microfacets.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RoughMetal {
    pub facets: Facets,
    pub smooth: Mirror,
}

impl RoughMetal {
    #[inline]
    pub fn reflectance(&self, cos: f32) -> Rgb {
        self.smooth.reflectance(cos)
    }

    #[inline]
    pub fn value(&self, wo: Vec3A, wi: Vec3A) -> Value {
        let cos = (0.5 * (wo + wi).length()).min(1.0);
        let glossy = self.reflectance(cos) * self.facets.reflection(wo, wi);
        Value { f: Split { diffuse: Rgb::ZERO, glossy }, pdf: self.facets.reflection_pdf(wo, wi) }
    }

    #[inline]
    pub fn sample(&self, wo: Vec3A, u: Vec2) -> Option<Scatter> {
        self.facets.sample_reflection(wo, u).map(Scatter::Direction)
    }
}

/// The material of glTF 2.0, appendix B: GGX with Schlick's F over a Lambertian base that metal lacks.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MetallicRoughness {
    pub base_color: Rgb,
    pub facets: Facets,
    /// Reflectance at normal incidence.
    pub f0: Rgb,
    /// Albedo of the base.
    pub diffuse: Rgb,
    /// Probability of sampling the base.
    pub p_diffuse: f32,
}

impl MetallicRoughness {
    pub fn new(base_color: Rgb, metallic: f32, facets: Facets, f0: f32, cos: f32) -> Self {
        let metallic = metallic.clamp(0.0, 1.0);
        let f0 = Rgb::splat(f0).lerp(base_color, metallic);
        let diffuse = base_color * (1.0 - metallic);
        let reflected = super::mean(schlick(f0, cos.abs()));
        let p_diffuse = super::share(super::mean(diffuse) * (1.0 - reflected), reflected).clamp(0.0, 0.95);
        Self { base_color, facets, f0, diffuse, p_diffuse }
    }

    #[inline]
    pub fn value(&self, wo: Vec3A, wi: Vec3A) -> Value {
        let f = schlick(self.f0, (0.5 * (wo + wi).length()).min(1.0));
        let glossy = f * self.facets.reflection(wo, wi);
        let diffuse = (Rgb::ONE - f) * self.diffuse * FRAC_1_PI;
        let pdf = self.p_diffuse * wi.z * FRAC_1_PI + (1.0 - self.p_diffuse) * self.facets.reflection_pdf(wo, wi);
        Value { f: Split { diffuse, glossy }, pdf }
    }

    #[inline]
    pub fn sample(&self, wo: Vec3A, choice: f32, u: Vec2) -> Option<Scatter> {
        if choice < self.p_diffuse {
            return Some(Scatter::Direction(cosine_hemisphere(u)));
        }
        self.facets.sample_reflection(wo, u).map(Scatter::Direction)
    }
}

#[inline]
fn schlick(f0: Rgb, cos: f32) -> Rgb {
    f0 + (Rgb::ONE - f0) * (1.0 - cos).max(0.0).powi(5)
}
