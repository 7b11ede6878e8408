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

/// Schlick's reflectance.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Schlick {
    /// At normal incidence.
    pub f0: Rgb,
    /// At grazing incidence.
    pub f90: f32,
}

impl Schlick {
    #[inline]
    fn at(&self, cos: f32) -> Rgb {
        self.f0 + (Rgb::splat(self.f90) - self.f0) * (1.0 - cos).max(0.0).powi(5)
    }
}

/// The material of glTF 2.0, appendix B: GGX with Schlick's F over a Lambertian base that metal lacks. The base gets
/// what the largest channel of the dielectric's F leaves (KHR_materials_specular).
#[derive(Clone, Copy, Debug)]
pub(crate) struct MetallicRoughness {
    pub base_color: Rgb,
    pub facets: Facets,
    /// Reflectance of the dielectric.
    pub dielectric: Schlick,
    /// Reflectance of the mixture of dielectric and metal.
    pub mixture: Schlick,
    /// Albedo of the base.
    pub diffuse: Rgb,
    /// Probability of sampling the base.
    pub p_diffuse: f32,
}

impl MetallicRoughness {
    pub fn new(base_color: Rgb, metallic: f32, facets: Facets, dielectric: Schlick, cos: f32) -> Self {
        let metallic = metallic.clamp(0.0, 1.0);
        let f90 = dielectric.f90 + (1.0 - dielectric.f90) * metallic;
        let mixture = Schlick { f0: dielectric.f0.lerp(base_color, metallic), f90 };
        let diffuse = base_color * (1.0 - metallic);
        let reflected = super::mean(mixture.at(cos.abs()));
        let p_diffuse = super::share(super::mean(diffuse) * (1.0 - reflected), reflected).clamp(0.0, 0.95);
        Self { base_color, facets, dielectric, mixture, diffuse, p_diffuse }
    }

    #[inline]
    pub fn value(&self, wo: Vec3A, wi: Vec3A) -> Value {
        let cos = (0.5 * (wo + wi).length()).min(1.0);
        let glossy = self.mixture.at(cos) * self.facets.reflection(wo, wi);
        let diffuse = (1.0 - self.dielectric.at(cos).max_element()) * self.diffuse * FRAC_1_PI;
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
