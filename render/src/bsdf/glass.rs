//! Light that rough glass loses between its facets, given back.

use super::{Facets, fresnel};
use crate::scene::Distribution;
use glam::{Vec2, Vec3A};

/// Share of light that facets of all roughnesses send back or on after one bounce. Dividing by it at the view stands for
/// the bounces that follow (Turquin 2019, "Practical multiple scattering compensation for microfacet models"), as in
/// Cycles: glass without colour then neither absorbs nor makes light. It costs reciprocity.
#[derive(Clone, Debug)]
pub(crate) struct GlassTable {
    /// From the front, then from behind; by roughness, then by cosine.
    share: [[[f32; Self::NODES]; Self::NODES]; 2],
}

impl GlassTable {
    /// Nodes per axis: roughness and cosine from 0 to 1.
    const NODES: usize = 16;
    /// Points per axis of the midpoint rule over visible facets.
    const POINTS: usize = 24;

    /// For an index, as a sheet or a boundary.
    pub fn new(eta: f32, sheet: bool) -> Self {
        let node = |i: usize| i as f32 / (Self::NODES - 1) as f32;
        let share = |behind: usize, roughness: f32, cos: f32| {
            let facets = Facets::new(Distribution::Ggx, Vec2::splat(roughness * roughness));
            let eta = if behind == 1 && !sheet { 1.0 / eta } else { eta };
            Self::integrate(&facets, cos.max(0.01), eta, sheet)
        };
        Self { share: [0, 1].map(|b| core::array::from_fn(|r| core::array::from_fn(|c| share(b, node(r), node(c))))) }
    }

    /// Midpoint rule over the facets seen under a cosine.
    fn integrate(facets: &Facets, cos: f32, eta: f32, sheet: bool) -> f32 {
        let w = Vec3A::new((1.0 - cos * cos).max(0.0).sqrt(), 0.0, cos);
        let coordinate = |i: usize| (i as f32 + 0.5) / Self::POINTS as f32;
        let passed = |w: Vec3A, h: Vec3A, up: bool| if (w.z > 0.0) == up { facets.g1(w, h) } else { 0.0 };
        let weight = |i: usize| {
            let u = Vec2::new(coordinate(i % Self::POINTS), coordinate(i / Self::POINTS));
            let Some(h) = facets.sample(w, u) else { return 0.0 };
            let reflected = passed(2.0 * w.dot(h) * h - w, h, true);
            if sheet {
                return reflected;
            }
            let interface = fresnel::dielectric(w.dot(h), eta);
            let r = interface.reflectance;
            let refracted = if r < 1.0 { passed(fresnel::refract(w, h, &interface), h, false) } else { 0.0 };
            r * reflected + (1.0 - r) * refracted
        };
        (0..Self::POINTS * Self::POINTS).map(weight).sum::<f32>() / (Self::POINTS * Self::POINTS) as f32
    }

    /// The share for a perceptual roughness and a view, whose cosine is negative behind the surface.
    #[inline]
    pub fn share(&self, roughness: f32, cos: f32) -> f32 {
        let table = &self.share[usize::from(cos < 0.0)];
        let place = |x: f32| {
            let x = x.clamp(0.0, 1.0) * (Self::NODES - 1) as f32;
            let i = (x as usize).min(Self::NODES - 2);
            (i, x - i as f32)
        };
        let ((r, fr), (c, fc)) = (place(roughness), place(cos.abs()));
        let along = |r: usize| table[r][c] + (table[r][c + 1] - table[r][c]) * fc;
        (along(r) + (along(r + 1) - along(r)) * fr).max(0.1)
    }
}
