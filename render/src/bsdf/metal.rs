//! Metals, smooth and rough, and glTF's mixture of metal and plastic.

use super::{FacetAlbedo, Facets, Scatter, Split, Value, fresnel, mirror};
use crate::frame::cosine_hemisphere;
use crate::scene::{Distribution, Rgb};
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
    pub f90: Rgb,
}

impl Schlick {
    const NONE: Self = Self { f0: Rgb::ZERO, f90: Rgb::ZERO };

    #[inline]
    fn at(&self, cos: f32) -> Rgb {
        self.f0 + (self.f90 - self.f0) * (1.0 - cos).max(0.0).powi(5)
    }
}

/// The material of glTF 2.0: GGX facets with Schlick's F over a Lambertian base that metal lacks. The base gets what the
/// largest channel of the dielectric's F leaves (KHR_materials_specular), or of all that the dielectric's facets reflect.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MetallicRoughness {
    pub base_color: Rgb,
    pub facets: Facets,
    /// Reflectance of the dielectric, which the base lacks at the half vector.
    pub dielectric: Schlick,
    /// Reflectance of the mixture of dielectric and metal.
    pub mixture: Schlick,
    /// Albedo of the base.
    pub diffuse: Rgb,
    /// Probability of sampling the base.
    pub p_diffuse: f32,
}

impl MetallicRoughness {
    /// By the formula of appendix B.
    pub fn new(base_color: Rgb, metallic: f32, roughness: f32, dielectric: Schlick, cos: f32) -> Self {
        let facets = Facets::new(Distribution::Ggx, Vec2::splat(roughness * roughness));
        let metallic = metallic.clamp(0.0, 1.0);
        let mixture = Schlick {
            f0: dielectric.f0.lerp(base_color, metallic),
            f90: dielectric.f90.lerp(Rgb::ONE, metallic),
        };
        let diffuse = base_color * (1.0 - metallic);
        let reflected = super::mean(mixture.at(cos.abs()));
        let p_diffuse = super::share(super::mean(diffuse) * (1.0 - reflected), reflected).clamp(0.0, 0.95);
        Self { base_color, facets, dielectric, mixture, diffuse, p_diffuse }
    }

    /// In layers, each of which gets what the one above leaves at the view, and that lose nothing between their facets.
    pub fn layered(base_color: Rgb, metallic: f32, roughness: f32, dielectric: Schlick, cos: f32) -> Self {
        let facets = Facets::new(Distribution::Ggx, Vec2::splat(roughness * roughness));
        let metallic = metallic.clamp(0.0, 1.0);
        let albedo = FacetAlbedo::of(roughness, cos.abs());
        let Schlick { f0, f90 } = dielectric;
        let of_dielectric = albedo.all_bounces(f0, f90);
        let of_metal = albedo.all_bounces(base_color, Rgb::ONE);
        let mixture = Schlick {
            f0: (f0 * of_dielectric).lerp(base_color * of_metal, metallic),
            f90: (f90 * of_dielectric).lerp(of_metal, metallic),
        };
        let covered = albedo.reflected(f0, f90);
        let diffuse = base_color * ((1.0 - metallic) * (1.0 - covered.max_element()).max(0.0));
        let reflected = covered.lerp(albedo.reflected(base_color, Rgb::ONE), metallic);
        let p_diffuse = super::share(super::mean(diffuse), super::mean(reflected)).clamp(0.0, 0.95);
        Self { base_color, facets, dielectric: Schlick::NONE, mixture, diffuse, p_diffuse }
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
