//! How much facets reflect in all, and what that leaves for the base below them.

use super::Facets;
use crate::scene::{Distribution, Rgb};
use glam::{Vec2, Vec3A};
use std::sync::LazyLock;

/// GGX facets of every roughness, seen under every cosine, by a midpoint rule over the visible ones.
#[derive(Clone, Debug)]
pub(crate) struct FacetTable {
    /// Share E of light that leaves after one bounce from white facets; by roughness, then by cosine.
    share: [[f32; Self::NODES]; Self::NODES],
    /// Mean of Schlick's (1 − cos)⁵ over that light.
    grazing: [[f32; Self::NODES]; Self::NODES],
    /// Mean of the share over a cosine-weighted hemisphere; by roughness.
    mean: [f32; Self::NODES],
}

/// What [`FacetTable`] says of a roughness and a view.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FacetAlbedo {
    pub share: f32,
    pub grazing: f32,
    pub mean: f32,
}

static TABLE: LazyLock<FacetTable> = LazyLock::new(FacetTable::new);

impl FacetTable {
    /// Nodes per axis: perceptual roughness and cosine from 0 to 1.
    const NODES: usize = 24;
    /// Points per axis of the midpoint rule over visible facets.
    const POINTS: usize = 24;

    fn new() -> Self {
        let node = |i: usize| i as f32 / (Self::NODES - 1) as f32;
        let both: [[[f32; 2]; Self::NODES]; Self::NODES] =
            core::array::from_fn(|r| core::array::from_fn(|c| Self::integrate(node(r), node(c).max(0.005))));
        let share = both.map(|row| row.map(|[share, _]| share));
        let grazing = both.map(|row| row.map(|[share, grazing]| if share > 0.0 { grazing / share } else { 0.0 }));
        // ∫ 2 c E(c) dc of the piecewise linear E: on an interval from c to c + h, h (c (a + b) + h (a + 2b)/3).
        let h = 1.0 / (Self::NODES - 1) as f32;
        let mean = share.map(|row| {
            let part = |(i, w): (usize, &[f32])| h * (node(i) * (w[0] + w[1]) + h * (w[0] + 2.0 * w[1]) / 3.0);
            row.windows(2).enumerate().map(part).sum()
        });
        Self { share, grazing, mean }
    }

    fn integrate(roughness: f32, cos: f32) -> [f32; 2] {
        let facets = Facets::new(Distribution::Ggx, Vec2::splat(roughness * roughness));
        let w = Vec3A::new((1.0 - cos * cos).max(0.0).sqrt(), 0.0, cos);
        let coordinate = |i: usize| (i as f32 + 0.5) / Self::POINTS as f32;
        let mut sums = [0.0; 2];
        for i in 0..Self::POINTS * Self::POINTS {
            let u = Vec2::new(coordinate(i % Self::POINTS), coordinate(i / Self::POINTS));
            let Some(h) = facets.sample(w, u) else { continue };
            let wi = 2.0 * w.dot(h) * h - w;
            if wi.z > 0.0 {
                let left = facets.g1(wi, h);
                sums[0] += left;
                sums[1] += left * (1.0 - w.dot(h)).max(0.0).powi(5);
            }
        }
        sums.map(|s| s / (Self::POINTS * Self::POINTS) as f32)
    }

    #[inline]
    fn look_up(&self, roughness: f32, cos: f32) -> FacetAlbedo {
        let place = |x: f32| {
            let x = x.clamp(0.0, 1.0) * (Self::NODES - 1) as f32;
            let i = (x as usize).min(Self::NODES - 2);
            (i, x - i as f32)
        };
        let ((r, fr), (c, fc)) = (place(roughness), place(cos));
        let mix = |a: f32, b: f32, t: f32| a + (b - a) * t;
        let at = |table: &[[f32; Self::NODES]; Self::NODES]| {
            let along = |r: usize| mix(table[r][c], table[r][c + 1], fc);
            mix(along(r), along(r + 1), fr)
        };
        let (share, grazing) = (at(&self.share), at(&self.grazing));
        FacetAlbedo { share: share.max(0.1), grazing, mean: mix(self.mean[r], self.mean[r + 1], fr) }
    }
}

impl FacetAlbedo {
    /// For a perceptual roughness and the cosine of the view.
    #[inline]
    pub fn of(roughness: f32, cos: f32) -> Self {
        TABLE.look_up(roughness, cos)
    }

    /// Factor on one bounce that stands for all bounces among the facets: 1 + F_ms (1 − E)/E (Turquin 2019, "Practical
    /// multiple scattering compensation for microfacet models"), with F_ms = F̄ Ē/(1 − F̄ (1 − Ē)) of the mean F̄ of
    /// Fresnel's term (Kulla and Conty 2017). White facets then lose nothing. It costs reciprocity.
    #[inline]
    pub fn all_bounces(&self, f0: Rgb, f90: Rgb) -> Rgb {
        // ∫ 2 c (1 − c)⁵ dc is 1/21.
        let mean_f = f0 + (f90 - f0) * (1.0 / 21.0);
        let further = mean_f * self.mean / (Rgb::ONE - mean_f * (1.0 - self.mean));
        Rgb::ONE + further * ((1.0 - self.share) / self.share)
    }

    /// Share of light that facets of Schlick's reflectance send back in all.
    #[inline]
    pub fn reflected(&self, f0: Rgb, f90: Rgb) -> Rgb {
        (f0 + (f90 - f0) * self.grazing) * self.share * self.all_bounces(f0, f90)
    }
}
