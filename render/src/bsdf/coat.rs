//! A diffuse base under a dielectric coat: Mitsuba's `plastic` and `roughplastic`.

use super::{Facets, Scatter, Split, Value, fresnel, mean, mirror, share};
use crate::frame::cosine_hemisphere;
use crate::scene::{Distribution, Rgb};
use core::f32::consts::{FRAC_1_PI, PI};
use glam::{Vec2, Vec3A};

/// Albedo of the base over the light that internal reflection sends back to it, over π η².
fn base(diffuse: Rgb, internal: f32, nonlinear: bool, eta: f32) -> Rgb {
    let returned = if nonlinear { diffuse * internal } else { Rgb::splat(internal) };
    diffuse / (Rgb::ONE - returned) * (FRAC_1_PI / (eta * eta))
}

/// Smooth coat.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SmoothCoat {
    pub eta: f32,
    pub diffuse: Rgb,
    pub specular: Rgb,
    pub nonlinear: bool,
}

impl SmoothCoat {
    /// Reflectance of the coat at the view, and the probability of sampling the reflection.
    fn choose(&self, wo: Vec3A) -> (f32, f32) {
        let r = fresnel::dielectric(wo.z, self.eta).reflectance;
        (r, share(r * mean(self.specular), (1.0 - r) * mean(self.diffuse)))
    }

    /// Albedo of the base at this view, light coming from everywhere alike.
    pub fn base_albedo(&self, wo: Vec3A) -> Rgb {
        let internal = fresnel::diffuse_reflectance(1.0 / self.eta);
        let through = 1.0 - fresnel::dielectric(wo.z, self.eta).reflectance;
        let through = through * (1.0 - fresnel::diffuse_reflectance(self.eta));
        base(self.diffuse, internal, self.nonlinear, self.eta) * (through * PI)
    }

    #[inline]
    pub fn value(&self, wo: Vec3A, wi: Vec3A) -> Value {
        let (r, p_specular) = self.choose(wo);
        let through = (1.0 - r) * (1.0 - fresnel::dielectric(wi.z, self.eta).reflectance);
        let internal = fresnel::diffuse_reflectance(1.0 / self.eta);
        let diffuse = base(self.diffuse, internal, self.nonlinear, self.eta) * through;
        Value { f: Split { diffuse, glossy: Rgb::ZERO }, pdf: (1.0 - p_specular) * wi.z * FRAC_1_PI }
    }

    #[inline]
    pub fn sample(&self, wo: Vec3A, choice: f32, u: Vec2) -> Option<Scatter> {
        let (r, p_specular) = self.choose(wo);
        if choice < p_specular {
            return Some(Scatter::Delta { wi: mirror(wo), weight: self.specular * (r / p_specular), eta: 1.0 });
        }
        Some(Scatter::Direction(cosine_hemisphere(u)))
    }
}

/// What depends on roughness and index alone: light that passes the rough coat.
#[derive(Clone, Debug)]
pub(crate) struct CoatTable {
    /// Share of light under the cosine i/(n − 1) that passes into the coat.
    transmittance: [f32; Self::NODES],
    /// Share of diffuse light from below that is sent back.
    internal: f32,
}

impl CoatTable {
    const NODES: usize = 64;
    /// Points per axis of the midpoint rule over visible facets.
    const POINTS: usize = 32;

    /// Integrates over the visible facets of every direction.
    pub fn new(distribution: Distribution, alpha: f32, eta: f32) -> Self {
        let facets = Facets::new(distribution, Vec2::splat(alpha));
        let node = |i: usize| (i as f32 / (Self::NODES - 1) as f32).max(1e-3);
        let transmittance = core::array::from_fn(|i| Self::integrate(&facets, node(i), eta, true));
        let inner = |i: usize| {
            let cos = (i as f32 + 0.5) / Self::NODES as f32;
            2.0 * cos * Self::integrate(&facets, cos, 1.0 / eta, false)
        };
        let internal = (0..Self::NODES).map(inner).sum::<f32>() / Self::NODES as f32;
        Self { transmittance, internal }
    }

    /// Share of light from a direction that the facets transmit (or reflect), shadowing included.
    fn integrate(facets: &Facets, cos: f32, eta: f32, transmitted: bool) -> f32 {
        let w = Vec3A::new((1.0 - cos * cos).max(0.0).sqrt(), 0.0, cos);
        let coordinate = |i: usize| (i as f32 + 0.5) / Self::POINTS as f32;
        let points = (0..Self::POINTS * Self::POINTS)
            .map(|i| Vec2::new(coordinate(i % Self::POINTS), coordinate(i / Self::POINTS)));
        let weight = |u: Vec2| {
            let Some(h) = facets.sample(w, u) else { return 0.0 };
            // Beckmann facets are sampled by the GGX: the ratio of visible densities mends it.
            let visible = facets.d(h) * facets.g1(w, h) * w.dot(h) / (w.z * facets.pdf(w, h));
            let interface = fresnel::dielectric(w.dot(h), eta);
            let (share, out) = if transmitted {
                (1.0 - interface.reflectance, fresnel::refract(w, h, &interface))
            } else {
                (interface.reflectance, 2.0 * w.dot(h) * h - w)
            };
            let right_side = (out.z < 0.0) == transmitted;
            if right_side && share > 0.0 { visible * share * facets.g1(out, h) } else { 0.0 }
        };
        points.map(weight).sum::<f32>() / (Self::POINTS * Self::POINTS) as f32
    }

    /// Mean transmittance under a cosine-weighted hemisphere.
    fn mean_transmittance(&self) -> f32 {
        let node = |i: usize| (i as f32 / (Self::NODES - 1) as f32, self.transmittance[i]);
        let (weights, sum) = (0..Self::NODES).map(node).fold((0.0, 0.0), |(w, s), (cos, t)| (w + cos, s + cos * t));
        sum / weights
    }

    #[inline]
    pub fn transmittance(&self, cos: f32) -> f32 {
        let x = cos.clamp(0.0, 1.0) * (Self::NODES - 1) as f32;
        let i = (x as usize).min(Self::NODES - 2);
        self.transmittance[i] + (self.transmittance[i + 1] - self.transmittance[i]) * (x - i as f32)
    }
}

/// Rough coat.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RoughCoat<'a> {
    pub facets: Facets,
    pub eta: f32,
    pub diffuse: Rgb,
    pub specular: Rgb,
    pub nonlinear: bool,
    pub table: &'a CoatTable,
}

impl RoughCoat<'_> {
    /// Albedo of the base at this view, light coming from everywhere alike.
    pub fn base_albedo(&self, wo: Vec3A) -> Rgb {
        let through = self.table.transmittance(wo.z) * self.table.mean_transmittance();
        base(self.diffuse, self.table.internal, self.nonlinear, self.eta) * (through * PI)
    }

    /// What the coat does not let pass at this view.
    pub fn reflectance(&self, wo: Vec3A) -> Rgb {
        self.specular * (1.0 - self.table.transmittance(wo.z))
    }

    /// Albedo of the base at this view under light that has passed the coat already, and the probability of sampling the reflection.
    #[inline(always)]
    pub fn base_at(&self, wo: Vec3A) -> (Rgb, f32) {
        let (t, p_specular) = self.choose(wo);
        (base(self.diffuse, self.table.internal, self.nonlinear, self.eta) * (t * PI), p_specular)
    }

    /// Transmittance at the view, and the probability of sampling the reflection.
    #[inline]
    fn choose(&self, wo: Vec3A) -> (f32, f32) {
        let t = self.table.transmittance(wo.z);
        (t, share((1.0 - t) * mean(self.specular), t * mean(self.diffuse)))
    }

    #[inline]
    pub fn value(&self, wo: Vec3A, wi: Vec3A) -> Value {
        let (t, p_specular) = self.choose(wo);
        let cos = (0.5 * (wo + wi).length()).min(1.0);
        let r = fresnel::dielectric(cos, self.eta).reflectance;
        let glossy = self.specular * (r * self.facets.reflection(wo, wi));
        let through = t * self.table.transmittance(wi.z);
        let diffuse = base(self.diffuse, self.table.internal, self.nonlinear, self.eta) * through;
        let pdf = p_specular * self.facets.reflection_pdf(wo, wi) + (1.0 - p_specular) * wi.z * FRAC_1_PI;
        Value { f: Split { diffuse, glossy }, pdf }
    }

    #[inline]
    pub fn sample(&self, wo: Vec3A, choice: f32, u: Vec2) -> Option<Scatter> {
        let (_, p_specular) = self.choose(wo);
        if choice < p_specular {
            return self.facets.sample_reflection(wo, u).map(Scatter::Direction);
        }
        Some(Scatter::Direction(cosine_hemisphere(u)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_coat_that_is_nearly_smooth_passes_what_a_smooth_one_passes() {
        for distribution in [Distribution::Beckmann, Distribution::Ggx] {
            let table = CoatTable::new(distribution, 0.01, 1.5);
            for cos in [0.3, 0.6, 1.0] {
                let smooth = 1.0 - fresnel::dielectric(cos, 1.5).reflectance;
                assert!((table.transmittance(cos) - smooth).abs() < 5e-3, "{} {smooth}", table.transmittance(cos));
            }
            let internal = fresnel::diffuse_reflectance(1.0 / 1.5);
            // Mitsuba's sum over the nodes, ends included, gives 0.009 less (`tests/peers/mitsuba_rough_plastic.py`).
            assert!((table.internal - internal).abs() < 1.5e-3, "{} {internal}", table.internal);
        }
    }

    #[test]
    fn a_rough_coat_still_passes_most_light() {
        for distribution in [Distribution::Beckmann, Distribution::Ggx] {
            let table = CoatTable::new(distribution, 0.4, 1.5);
            assert!((0.85..0.97).contains(&table.transmittance(0.9)), "{}", table.transmittance(0.9));
        }
    }
}
