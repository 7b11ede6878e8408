//! Microfacets in single precision: distribution, shadowing, sampling of the visible normals.

use crate::math::sin_cos_turn;
use crate::scene::Distribution;
use brdf_tables::brdf::{self, Formula, Fresnel, Microfacet};
use core::f32::consts::PI;
use glam::{Vec2, Vec3A};

/// Smallest roughness: below it single precision resolves the lobe no more.
const MIN_ALPHA: f32 = 1e-4;

/// A distribution of facet normals with its Smith shadowing.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Facets {
    distribution: Distribution,
    alpha: Vec2,
}

impl Facets {
    pub fn new(distribution: Distribution, alpha: Vec2) -> Self {
        Self { distribution, alpha: alpha.max(Vec2::splat(MIN_ALPHA)) }
    }

    /// Roughness along x and y.
    #[inline]
    pub fn alpha(&self) -> Vec2 {
        self.alpha
    }

    /// Which distribution.
    #[inline]
    pub fn distribution(&self) -> Distribution {
        self.distribution
    }

    /// D G₁(wi) G₁(wo) / (4 cosθi cosθo) for directions of the upper hemisphere, by the formula of `brdf-tables`.
    #[inline]
    pub fn reflection(&self, wo: Vec3A, wi: Vec3A) -> f32 {
        let distribution = match self.distribution {
            Distribution::Beckmann => brdf::Distribution::Beckmann,
            Distribution::Ggx => brdf::Distribution::Ggx,
        };
        let (alpha_x, alpha_y) = (f64::from(self.alpha.x), f64::from(self.alpha.y));
        Microfacet { distribution, alpha_x, alpha_y, fresnel: Fresnel::None }.f(wi.to_array(), wo.to_array())
    }

    /// D(h) in sr⁻¹ for a unit vector of the upper hemisphere.
    #[inline]
    pub fn d(&self, h: Vec3A) -> f32 {
        let slope2 = ((h.x / self.alpha.x).powi(2) + (h.y / self.alpha.y).powi(2)) / (h.z * h.z);
        let scale = 1.0 / (PI * self.alpha.x * self.alpha.y * h.z.powi(4));
        match self.distribution {
            Distribution::Beckmann => scale * (-slope2).exp(),
            Distribution::Ggx => scale / (1.0 + slope2).powi(2),
        }
    }

    /// Share of the facets of normal `h` that is seen from `w`.
    #[inline]
    pub fn g1(&self, w: Vec3A, h: Vec3A) -> f32 {
        if w.dot(h) * w.z <= 0.0 {
            return 0.0;
        }
        let tan2 = ((w.x * self.alpha.x).powi(2) + (w.y * self.alpha.y).powi(2)) / (w.z * w.z);
        match self.distribution {
            Distribution::Ggx => 2.0 / (1.0 + (1.0 + tan2).sqrt()),
            Distribution::Beckmann => {
                let a = 1.0 / tan2.max(1e-12).sqrt();
                if a >= 1.6 { 1.0 } else { a * (3.535 + 2.181 * a) / (1.0 + a * (2.276 + 2.577 * a)) }
            }
        }
    }

    /// A facet normal seen from `wo` (upper hemisphere): exact for GGX (Dupuy and Benyoub 2023); the GGX of equal
    /// roughness stands in for Beckmann, which leaves weights below 2.7.
    #[inline]
    pub fn sample(&self, wo: Vec3A, u: Vec2) -> Option<Vec3A> {
        let alpha = Vec3A::new(self.alpha.x, self.alpha.y, 1.0);
        let view = (alpha * wo).normalize();
        let z = (1.0 - u.x) * (1.0 + view.z) - view.z;
        let r = (1.0 - z * z).max(0.0).sqrt();
        let (s, c) = sin_cos_turn(u.y);
        (alpha * (Vec3A::new(r * c, r * s, z) + view)).try_normalize().filter(|h| h.z > 0.0 && wo.dot(*h) > 0.0)
    }

    /// Density of [`Facets::sample`] over normals, in sr⁻¹.
    #[inline]
    pub fn pdf(&self, wo: Vec3A, h: Vec3A) -> f32 {
        let ggx = Self { distribution: Distribution::Ggx, ..*self };
        ggx.d(h) * ggx.g1(wo, h) * wo.dot(h).max(0.0) / wo.z
    }

    /// A direction reflected by a visible facet.
    #[inline]
    pub fn sample_reflection(&self, wo: Vec3A, u: Vec2) -> Option<Vec3A> {
        let h = self.sample(wo, u)?;
        Some(2.0 * wo.dot(h) * h - wo).filter(|wi| wi.z > 0.0)
    }

    /// Density of [`Facets::sample_reflection`] at a direction of the upper hemisphere, in sr⁻¹.
    #[inline]
    pub fn reflection_pdf(&self, wo: Vec3A, wi: Vec3A) -> f32 {
        let Some(h) = (wo + wi).try_normalize() else { return 0.0 };
        let cos = wo.dot(h);
        if cos > 0.0 { self.pdf(wo, h) / (4.0 * cos) } else { 0.0 }
    }
}
