//! The diffuse base, the sheen and the clear coat of Burley's principled model ("Physically Based Shading at Disney", 2012), as
//! Mitsuba's `principled` has them.

use super::layers::schlick_rise;
use super::metal::mean_edge;
use super::{Scatter, Split, Value};
use crate::math::sin_cos_turn;
use crate::scene::Rgb;
use core::f32::consts::PI;
use glam::{Vec2, Vec3A};

/// What light a rough base gives back towards where it came from, and a film of fibres on it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Burley {
    /// Perceptual roughness.
    pub roughness: f32,
    /// Factor on (1 − cos δ)⁵, δ between the half vector and either direction.
    pub sheen: Rgb,
}

impl Burley {
    /// Factor on a Lambertian base.
    #[inline]
    pub fn base(&self, wo: Vec3A, wi: Vec3A) -> f32 {
        let (fo, fi) = (schlick_rise(wo.z), schlick_rise(wi.z));
        let rise = self.roughness * (1.0 + wo.dot(wi));
        (1.0 - 0.5 * fi) * (1.0 - 0.5 * fo) + rise * (fo + fi + fo * fi * (rise - 1.0))
    }

    /// f_r of the sheen.
    #[inline]
    pub fn sheen(&self, wo: Vec3A, wi: Vec3A) -> Rgb {
        self.sheen * schlick_rise((0.5 * (wo + wi).length()).min(1.0))
    }

    /// Mean of [`Burley::base`] over a cosine-weighted hemisphere of light, for a view under the cosine `c`.
    ///
    /// With x = cos²δ = (1 + ωo·ωi)/2 it is a sum of moments of x and (1 − cosθi)⁵, each a beta function of cosθi.
    #[inline]
    pub fn base_mean(&self, c: f32) -> f32 {
        let (c, fo, r) = (c.clamp(0.0, 1.0), schlick_rise(c), 2.0 * self.roughness);
        let (x, x_fi) = (0.5 + c / 3.0, 0.5 * (1.0 / 21.0 + c / 84.0));
        // ∫ (ωo·ωi)² (1 − cosθi)⁵ 2 cosθi dcosθi, its mean over the azimuth.
        let square = c * c / 252.0 + (1.0 - c * c) * (11.0 / 504.0);
        let xx_fi = 0.25 * (1.0 / 21.0 + c / 42.0 + square);
        (1.0 - 0.5 * fo) * (41.0 / 42.0) + r * (fo * x + (1.0 - fo) * x_fi) + r * r * fo * xx_fi
    }

    /// Albedo of the sheen.
    #[inline]
    pub fn sheen_mean(&self, c: f32) -> Rgb {
        self.sheen * (PI * mean_edge(c))
    }
}

/// A clear coat of index 1.5 whose lobe has a long tail (Burley's GTR1); it is added to what lies below.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ClearCoat {
    /// Width of its lobe.
    alpha: f32,
}

impl ClearCoat {
    /// Of a gloss in 0 … 1.
    pub fn new(gloss: f32) -> Self {
        Self { alpha: 0.1 + (0.001 - 0.1) * gloss.clamp(0.0, 1.0) }
    }

    /// Schlick's reflectance of an index of 1.5.
    #[inline]
    fn fresnel(cos: f32) -> f32 {
        0.04 + 0.96 * schlick_rise(cos)
    }

    /// Rough estimate of the share of light that it reflects.
    #[inline]
    pub fn reflectance(&self, cos: f32) -> f32 {
        Self::fresnel(cos) * cos
    }

    /// Density of the normals, times their cosine to the surface's a density over half vectors.
    #[inline]
    fn density(&self, z: f32) -> f32 {
        let a2 = self.alpha * self.alpha;
        (a2 - 1.0) / (PI * a2.ln() * (1.0 + (a2 - 1.0) * z * z))
    }

    #[inline]
    pub fn value(&self, wo: Vec3A, wi: Vec3A) -> Value {
        let Some(h) = (wo + wi).try_normalize() else { return Value::default() };
        let cos = wo.dot(h);
        // Smith's shadowing of GGX facets of α = ¼.
        let g1 = |z: f32| 2.0 / (1.0 + (1.0 + 0.0625 * (1.0 / (z * z) - 1.0)).sqrt());
        let density = self.density(h.z);
        let f = 0.25 * Self::fresnel(cos) * density * g1(wo.z) * g1(wi.z);
        Value { f: Split { diffuse: Rgb::ZERO, glossy: Rgb::splat(f) }, pdf: density * h.z / (4.0 * cos.max(1e-6)) }
    }

    #[inline]
    pub fn sample(&self, wo: Vec3A, u: Vec2) -> Option<Scatter> {
        let a2 = self.alpha * self.alpha;
        let z2 = ((1.0 - a2.powf(1.0 - u.x)) / (1.0 - a2)).clamp(0.0, 1.0);
        let (r, (s, c)) = ((1.0 - z2).sqrt(), sin_cos_turn(u.y));
        let h = Vec3A::new(r * c, r * s, z2.sqrt());
        Some(2.0 * wo.dot(h) * h - wo).filter(|wi| wi.z > 0.0).map(Scatter::Direction)
    }
}

/// A clear coat on top of something else.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Added {
    pub coat: ClearCoat,
    /// Factor on it.
    pub strength: f32,
    /// Probability of sampling it.
    pub share: f32,
}

impl Added {
    /// Rough estimate of the share of light that it reflects at a view.
    pub fn reflectance(&self, wo: Vec3A) -> Rgb {
        Rgb::splat(self.strength * self.coat.reflectance(wo.z.abs()))
    }

    /// Both together, from what lies below, for directions of the upper hemisphere.
    #[inline]
    pub fn over(&self, below: Value, wo: Vec3A, wi: Vec3A) -> Value {
        let Value { f, pdf } = self.coat.value(wo, wi);
        Value { f: below.f + f * self.strength, pdf: below.pdf + (pdf - below.pdf) * self.share }
    }
}

/// Luminance by which Mitsuba tints.
#[inline]
pub(crate) fn tint(base_color: Rgb) -> Rgb {
    let luminance = crate::color::luminance(base_color);
    if luminance > 0.0 { base_color / luminance } else { Rgb::ONE }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn direction(z: f32, turn: f32) -> Vec3A {
        let (s, c) = sin_cos_turn(turn);
        Vec3A::new((1.0 - z * z).sqrt() * c, (1.0 - z * z).sqrt() * s, z)
    }

    /// Albedos of base and sheen against a midpoint rule over the hemisphere.
    #[test]
    fn light_from_everywhere() {
        const N: usize = 256;
        let at = |i: usize| (i as f32 + 0.5) / N as f32;
        for roughness in [0.0, 0.3, 1.0] {
            let burley = Burley { roughness, sheen: Rgb::new(0.2, 0.5, 1.0) };
            for cos in [0.05f32, 0.3, 0.7, 1.0] {
                let wo = direction(cos, 0.0);
                let (mut base, mut sheen) = (0.0, glam::DVec3::ZERO);
                for wi in (0..N * N).map(|k| direction(at(k / N).sqrt(), at(k % N))) {
                    base += f64::from(burley.base(wo, wi));
                    sheen += (burley.sheen(wo, wi) * PI).as_dvec3();
                }
                let count = (N * N) as f64;
                let off = base / count - f64::from(burley.base_mean(cos));
                let sheen = (sheen / count).as_vec3a() - burley.sheen_mean(cos);
                assert!(off.abs() < 1e-4 && sheen.abs().max_element() < 1e-4, "{roughness} {cos}: {off} {sheen}");
            }
        }
    }

    /// Samples of the clear coat have the density that is said, and it is that of directions.
    #[test]
    fn the_coat_is_sampled_by_its_density() {
        const N: usize = 512;
        for (gloss, cos) in [(0.0, 1.0f32), (0.0, 0.5), (0.5, 0.7), (1.0, 0.3)] {
            let (coat, wo) = (ClearCoat::new(gloss), direction(cos, 0.0));
            let at = |i: usize| (i as f32 + 0.5) / N as f32;
            // A smooth function of the direction, by samples and by a rule over the hemisphere; what is lost lies below it.
            let weigh = |w: Vec3A| (1.0 + w.x + w.z * w.z).max(0.0);
            let mut sampled = 0.0f64;
            for u in (0..N * N).map(|k| Vec2::new(at(k / N), at(k % N))) {
                if let Some(Scatter::Direction(wi)) = coat.sample(wo, u) {
                    sampled += f64::from(weigh(wi)) / (N * N) as f64;
                }
            }
            let mut summed = 0.0f64;
            // Half vectors in steps that follow the lobe.
            const STEPS: usize = 4000;
            for i in 0..STEPS {
                let edge = |i: usize| (i as f64 / STEPS as f64).powi(4);
                let (low, high) = (edge(i), edge(i + 1));
                let z = 1.0 - 0.5 * (low + high);
                for j in 0..64 {
                    let h = direction(z as f32, (j as f32 + 0.5) / 64.0);
                    let wi = 2.0 * wo.dot(h) * h - wo;
                    if wi.z > 0.0 && wo.dot(h) > 0.0 {
                        let solid = (high - low) * core::f64::consts::TAU / 64.0 * f64::from(4.0 * wo.dot(h));
                        summed += f64::from(coat.value(wo, wi).pdf) * f64::from(weigh(wi)) * solid;
                    }
                }
            }
            assert!((sampled / summed - 1.0).abs() < 5e-3, "{gloss} {cos}: {sampled} {summed}");
        }
    }
}
