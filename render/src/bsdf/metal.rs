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

    /// Albedo of the base at this view, light coming from everywhere alike.
    pub fn base_albedo(&self, wo: Vec3A) -> Rgb {
        let Schlick { f0, f90 } = self.dielectric;
        let f0 = f0.max_element();
        self.diffuse * (1.0 - f0 - (f90 - f0) * mean_edge(wo.z))
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

/// ∫ (1 − cos δ)⁵ cosθi/π dωi over the hemisphere, δ between the half vector and either direction, `cos` that of ωo: a fit
/// within 10⁻⁵.
fn mean_edge(cos: f32) -> f32 {
    const FIT: [f32; 5] = [8.260_805e-5, 2.015_901_5e-3, 9.341_548e-3, 7.741_923e-3, 8.982_655e-3];
    let u = 1.0 - cos.clamp(0.0, 1.0);
    FIT.iter().rev().fold(0.0, |sum, c| sum * u + c)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::sin_cos_turn;

    /// The fit, and the albedo of the base that follows from it, against a midpoint rule over the whole hemisphere.
    #[test]
    fn the_base_under_light_from_everywhere() {
        let facets = Facets::new(crate::scene::Distribution::Ggx, Vec2::splat(0.3));
        let dielectric = Schlick { f0: Rgb::new(0.02, 0.05, 0.1), f90: 0.9 };
        for cos in [0.02f32, 0.2, 0.5, 0.8, 1.0] {
            let model = MetallicRoughness::new(Rgb::new(0.8, 0.5, 0.2), 0.25, facets, dielectric, cos);
            let wo = Vec3A::new((1.0 - cos * cos).sqrt(), 0.0, cos);
            const N: usize = 256;
            let mut sum = glam::DVec3::ZERO;
            for i in 0..N * N {
                let u = Vec2::new((i % N) as f32 + 0.5, (i / N) as f32 + 0.5) / N as f32;
                let (r, z) = (u.x.sqrt(), (1.0 - u.x).sqrt());
                let (s, c) = sin_cos_turn(u.y);
                sum += (model.value(wo, Vec3A::new(r * c, r * s, z)).f.diffuse * core::f32::consts::PI).as_dvec3();
            }
            let (sum, found) = ((sum / (N * N) as f64).as_vec3a(), model.base_albedo(wo));
            assert!((sum - found).abs().max_element() < 1e-4, "{cos}: {sum} {found}");
        }
    }

    /// What caching takes the base for, a Lambertian surface of that albedo, against the base under light from one direction:
    /// within 3 % where light and view are within 60° of the normal, 2 % in the mean square over all (cosine weighted).
    #[test]
    fn the_base_under_light_from_one_side() {
        let facets = Facets::new(crate::scene::Distribution::Ggx, Vec2::splat(0.3));
        let dielectric = Schlick { f0: Rgb::splat(0.04), f90: 1.0 };
        let model = MetallicRoughness::new(Rgb::ONE, 0.0, facets, dielectric, 1.0);
        let direction = |z: f32, turn: f32| {
            let (s, c) = sin_cos_turn(turn);
            Vec3A::new((1.0 - z * z).sqrt() * c, (1.0 - z * z).sqrt() * s, z)
        };
        const N: usize = 48;
        let at = |i: usize| (i as f32 + 0.5) / N as f32;
        let (mut worst, mut sum) = (0f32, 0.0);
        for (i, j) in (0..N * N).map(|k| (k / N, k % N)) {
            let (wo, z) = (direction(at(i).sqrt(), 0.0), at(j).sqrt());
            for wi in (0..N).map(|k| direction(z, at(k))) {
                let off = model.value(wo, wi).f.diffuse.x / (model.base_albedo(wo).x * FRAC_1_PI) - 1.0;
                sum += off * off;
                if wo.z > 0.5 && wi.z > 0.5 {
                    worst = worst.max(off.abs());
                }
            }
        }
        let rms = (sum / (N * N * N) as f32).sqrt();
        println!("the base: up to {worst:.4}, root of the mean square {rms:.4}");
        assert!(worst < 0.03 && rms < 0.02, "{worst} {rms}");
    }
}
