//! Metals, smooth and rough, and glTF's mixture of metal and plastic.

use super::burley::{Burley, tint};
use super::layers::{FacetTable, Rise, dielectric_rise, schlick_rise};
use super::{Facets, Parts, Scatter, Split, Value, fresnel, mirror};
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

/// The numbers of Mitsuba's `principled` at a point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Principled {
    pub base_color: Rgb,
    pub metallic: f32,
    /// Perceptual.
    pub roughness: f32,
    pub anisotropic: f32,
    pub spec_tint: f32,
    pub sheen: f32,
    pub sheen_tint: f32,
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
    /// How much more that reflects at this view, in the mean over the facets, than Schlick's formula says.
    ahead: Rgb,
    /// Albedo of the base.
    pub diffuse: Rgb,
    /// How the base differs from a Lambertian one, if it does.
    burley: Option<Burley>,
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
            ahead: Rgb::ZERO,
            diffuse,
            burley: None,
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
            ahead: (f90 - f0) * of_dielectric * albedo.ahead(),
            diffuse,
            burley: None,
            p_diffuse: super::share(super::mean(diffuse), super::mean(reflected)).clamp(0.0, 0.95),
        }
    }

    /// Mitsuba's `principled` without transmission, flatness and coat: nothing of the base is lost to the facets above it.
    pub fn principled(of: &Principled, cos: f32, table: &FacetTable) -> Self {
        let &Principled { base_color, metallic, roughness, anisotropic, spec_tint, sheen, sheen_tint } = of;
        let [metallic, spec_tint] = [metallic, spec_tint].map(|x| x.clamp(0.0, 1.0));
        let (eta, tint) = (table.eta(), tint(base_color));
        let normal = ((eta - 1.0) / (eta + 1.0)).powi(2);
        let (plain, tinted) = ((1.0 - metallic) * (1.0 - spec_tint), (1.0 - metallic) * spec_tint);
        let mixture =
            Schlick { f0: base_color * metallic + tint * (normal * tinted), f90: Rgb::splat(metallic + tinted) };
        let dielectric = Schlick { f0: Rgb::splat(normal * plain), f90: Rgb::splat(plain) };
        let aspect = (1.0 - 0.9 * anisotropic.clamp(0.0, 1.0)).sqrt();
        let alpha = roughness * roughness;
        let burley = Burley { roughness, sheen: Rgb::ONE.lerp(tint, sheen_tint) * (sheen * (1.0 - metallic)) };
        let diffuse = base_color * (1.0 - metallic);
        let reflected = mixture.at(cos.abs()) + dielectric.risen(dielectric_rise(cos.abs(), eta));
        let base = super::mean(diffuse) + super::mean(burley.sheen_mean(cos.abs()));
        Self {
            base_color,
            facets: Facets::new(Distribution::Ggx, Vec2::new(alpha / aspect, alpha * aspect).max(Vec2::splat(1e-3))),
            covering: Schlick::NONE,
            mixture,
            dielectric: Some((dielectric, eta)),
            ahead: (dielectric.f90 - dielectric.f0) * table.albedo(roughness, cos.abs()).ahead(),
            diffuse,
            burley: Some(burley),
            p_diffuse: super::share(base, super::mean(reflected)).clamp(0.0, 0.95),
        }
    }

    /// Albedo of the base at this view, light coming from everywhere alike.
    pub fn base_albedo(&self, wo: Vec3A) -> Rgb {
        if let Some(burley) = &self.burley {
            return self.diffuse * burley.base_mean(wo.z) + burley.sheen_mean(wo.z);
        }
        self.diffuse * (1.0 - self.covering.risen(mean_edge(wo.z)).max_element())
    }

    /// The base below its facets, and the facets.
    pub fn halves(self) -> [Self; 2] {
        let (none, ahead) = (Schlick::NONE, Rgb::ZERO);
        [
            Self { mixture: none, dielectric: None, ahead, p_diffuse: 1.0, ..self },
            Self { diffuse: Rgb::ZERO, burley: None, p_diffuse: 0.0, ..self },
        ]
    }

    /// What a cache multiplies its light by. All of the reflectance counts as rising by Schlick's formula; what Fresnel's
    /// equations give besides is added as it is in the mean over the facets that this view shows.
    pub fn parts(&self, wo: Vec3A) -> Parts {
        let Schlick { f0, f90 } = self.dielectric.map_or(Schlick::NONE, |(dielectric, _)| dielectric);
        Parts {
            diffuse: self.base_albedo(wo),
            specular: (self.mixture.f0 + f0 + self.ahead).max(Rgb::ZERO),
            grazing: (self.mixture.f90 + f90 + self.ahead).max(Rgb::ZERO),
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
        let diffuse = match &self.burley {
            None => (1.0 - self.covering.at(cos).max_element()) * self.diffuse * FRAC_1_PI,
            Some(burley) => burley.base(wo, wi) * self.diffuse * FRAC_1_PI + burley.sheen(wo, wi),
        };
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
pub(super) fn mean_edge(cos: f32) -> f32 {
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
        let dielectric = Schlick { f0: Rgb::new(0.02, 0.05, 0.1), f90: Rgb::splat(0.9) };
        for cos in [0.02f32, 0.2, 0.5, 0.8, 1.0] {
            let model = MetallicRoughness::new(Rgb::new(0.8, 0.5, 0.2), 0.25, 0.5, dielectric, cos);
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
        let dielectric = Schlick { f0: Rgb::splat(0.04), f90: Rgb::ONE };
        let model = MetallicRoughness::new(Rgb::ONE, 0.0, 0.5, dielectric, 1.0);
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

    /// What caching takes layered facets for against what they are: in the sum over light from everywhere within .5 %; in the
    /// mean square over the facets that a view shows within 13 % of it for rough plastic, whose facets reflect a twentieth,
    /// within 1 % where half is metal.
    #[test]
    fn layered_facets_in_a_cache() {
        let table = FacetTable::new(1.5);
        let dielectric = Schlick { f0: Rgb::splat(0.04), f90: Rgb::ONE };
        let (mut worst_sum, mut worst_rms) = (0f32, [0f32; 2]);
        for (metallic, roughness) in [(0.0, 0.25), (0.0, 0.7), (0.5, 0.5), (1.0, 0.3), (1.0, 1.0)] {
            for cos in [0.2f32, 0.5, 0.8, 1.0] {
                let color = Rgb::new(0.9, 0.6, 0.2);
                let model = MetallicRoughness::layered(color, metallic, roughness, dielectric, cos, &table);
                let wo = Vec3A::new((1.0 - cos * cos).sqrt(), 0.0, cos);
                let parts = model.parts(wo);
                const N: usize = 64;
                let (mut exact, mut cached, mut square) = (0.0, 0.0, 0.0);
                for i in 0..N * N {
                    let u = Vec2::new((i % N) as f32 + 0.5, (i / N) as f32 + 0.5) / N as f32;
                    let Some(wi) = model.facets.sample_reflection(wo, u).filter(|wi| wi.z > 0.0) else { continue };
                    let facets = model.facets.reflection(wo, wi) * wi.z / model.facets.reflection_pdf(wo, wi);
                    let rise = schlick_rise((0.5 * (wo + wi).length()).min(1.0));
                    let truth = model.value(wo, wi).f.glossy.x * wi.z / model.facets.reflection_pdf(wo, wi);
                    let found = (parts.specular + (parts.grazing - parts.specular) * rise).x * facets;
                    exact += truth;
                    cached += found;
                    square += (found - truth) * (found - truth);
                }
                let rms = (square * (N * N) as f32).sqrt() / exact;
                println!(
                    "metallic {metallic}, roughness {roughness}, cos {cos}: {:.4}, {rms:.4}",
                    cached / exact - 1.0
                );
                worst_sum = worst_sum.max((cached / exact - 1.0).abs());
                worst_rms[usize::from(metallic > 0.0)] = worst_rms[usize::from(metallic > 0.0)].max(rms);
            }
        }
        assert!(worst_sum < 0.005 && worst_rms[0] < 0.13 && worst_rms[1] < 0.01, "{worst_sum} {worst_rms:?}");
    }
}
