//! Metals, smooth and rough, and glTF's mixture of metal and plastic.

use super::layers::{FacetTable, Rise, dielectric_rise, schlick_rise};
use super::{Facets, Scatter, Split, Value, fresnel, mirror};
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
        self.risen(schlick_rise(cos))
    }

    #[inline]
    fn risen(&self, share: f32) -> Rgb {
        self.f0 + (self.f90 - self.f0) * share
    }
}

/// The material of glTF 2.0: GGX facets over a Lambertian base that metal lacks. The base gets what the largest channel of
/// the dielectric's F leaves (KHR_materials_specular), or of all that the dielectric's facets reflect.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MetallicRoughness {
    pub base_color: Rgb,
    pub facets: Facets,
    /// Reflectance by Schlick's formula that the base lacks at the half vector.
    covering: Schlick,
    /// Reflectance of the facets by Schlick's formula.
    mixture: Schlick,
    /// What their reflectance has besides, that rises as that of a dielectric of the index beside it does.
    dielectric: Option<(Schlick, f32)>,
    /// Albedo of the base.
    pub diffuse: Rgb,
    /// Probability of sampling the base.
    p_diffuse: f32,
}

impl MetallicRoughness {
    /// By the formula of appendix B, of a perceptual roughness and the reflectance of the dielectric, seen under a cosine.
    pub fn new(base_color: Rgb, metallic: f32, roughness: f32, dielectric: Schlick, cos: f32) -> Self {
        let metallic = metallic.clamp(0.0, 1.0);
        let mixture =
            Schlick { f0: dielectric.f0.lerp(base_color, metallic), f90: dielectric.f90.lerp(Rgb::ONE, metallic) };
        let diffuse = base_color * (1.0 - metallic);
        let reflected = super::mean(mixture.at(cos.abs()));
        Self {
            base_color,
            facets: Facets::new(Distribution::Ggx, Vec2::splat(roughness * roughness)),
            covering: dielectric,
            mixture,
            dielectric: None,
            diffuse,
            p_diffuse: super::share(super::mean(diffuse) * (1.0 - reflected), reflected).clamp(0.0, 0.95),
        }
    }

    /// In layers, each of which gets what the one above leaves at the view, and that lose nothing between their facets.
    pub fn layered(
        base_color: Rgb,
        metallic: f32,
        roughness: f32,
        dielectric: Schlick,
        cos: f32,
        table: &FacetTable,
    ) -> Self {
        let metallic = metallic.clamp(0.0, 1.0);
        let albedo = table.albedo(roughness, cos.abs());
        let Schlick { f0, f90 } = dielectric;
        let of_dielectric = albedo.all_bounces(f0, f90, Rise::Dielectric) * (1.0 - metallic);
        let of_metal = albedo.all_bounces(base_color, Rgb::ONE, Rise::Schlick) * metallic;
        let covered = albedo.reflected(f0, f90, Rise::Dielectric);
        let diffuse = base_color * ((1.0 - metallic) * (1.0 - covered.max_element()).max(0.0));
        let reflected = covered.lerp(albedo.reflected(base_color, Rgb::ONE, Rise::Schlick), metallic);
        Self {
            base_color,
            facets: Facets::new(Distribution::Ggx, Vec2::splat(roughness * roughness)),
            covering: Schlick::NONE,
            mixture: Schlick { f0: base_color * of_metal, f90: of_metal },
            dielectric: Some((Schlick { f0: f0 * of_dielectric, f90: f90 * of_dielectric }, table.eta())),
            diffuse,
            p_diffuse: super::share(super::mean(diffuse), super::mean(reflected)).clamp(0.0, 0.95),
        }
    }

    #[inline]
    pub fn value(&self, wo: Vec3A, wi: Vec3A) -> Value {
        let cos = (0.5 * (wo + wi).length()).min(1.0);
        let mut reflectance = self.mixture.at(cos);
        if let Some((dielectric, eta)) = &self.dielectric {
            reflectance += dielectric.risen(dielectric_rise(cos, *eta));
        }
        let glossy = reflectance * self.facets.reflection(wo, wi);
        let diffuse = (1.0 - self.covering.at(cos).max_element()) * self.diffuse * FRAC_1_PI;
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
