//! How much facets reflect in all, and what that leaves for the base below them.

use super::{Facets, fresnel};
use crate::scene::{Distribution, Rgb};
use glam::{Vec2, Vec3A};

/// How far Fresnel's reflectance of a dielectric of index `eta` is at a cosine on its way from normal to grazing incidence:
/// 0 … 1, in the place of Schlick's (1 − cos)⁵. An index above 1 reflects somewhat more than Schlick's term at 45° to 75°.
#[inline]
pub(crate) fn dielectric_rise(cos: f32, eta: f32) -> f32 {
    let normal = ((eta - 1.0) / (eta + 1.0)).powi(2);
    let reflectance = fresnel::dielectric(cos.clamp(1e-4, 1.0), eta).reflectance;
    ((reflectance - normal) / (1.0 - normal).max(1e-6)).clamp(0.0, 1.0)
}

/// Schlick's (1 − cos)⁵.
#[inline]
pub(crate) fn schlick_rise(cos: f32) -> f32 {
    (1.0 - cos).max(0.0).powi(5)
}

/// GGX facets of every roughness, seen under every cosine, by a midpoint rule over the visible ones.
#[derive(Clone, Debug)]
pub(crate) struct FacetTable {
    /// Index of the dielectric.
    eta: f32,
    /// By roughness, then by cosine.
    seen: Box<[[Seen; Self::NODES]; Self::NODES]>,
    /// Mean of [`Seen::share`] over a cosine-weighted hemisphere; by roughness.
    share: [f32; Self::NODES],
    /// Mean of the rise of the dielectric over a cosine-weighted hemisphere.
    dielectric: f32,
}

/// Facets under one cosine.
#[derive(Clone, Copy, Debug, Default)]
struct Seen {
    /// Share E of light that leaves after one bounce from white ones.
    share: f32,
    /// Means over that light of how far Fresnel's term of a dielectric, and of a metal by Schlick, has risen.
    rise: [f32; 2],
}

/// What [`FacetTable`] says of a roughness and a view.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FacetAlbedo {
    seen: Seen,
    /// Mean of the share over a cosine-weighted hemisphere.
    mean_share: f32,
    /// Means over a cosine-weighted hemisphere of how far Fresnel's terms have risen.
    mean_rise: [f32; 2],
}

/// Which of Fresnel's terms.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Rise {
    Dielectric,
    Schlick,
}

impl FacetTable {
    /// Nodes per axis: perceptual roughness and cosine from 0 to 1.
    const NODES: usize = 24;
    /// Points per axis of the midpoint rule over visible facets.
    const POINTS: usize = 20;

    /// For a dielectric of this index, or a metal.
    pub fn new(eta: f32) -> Self {
        let node = |i: usize| i as f32 / (Self::NODES - 1) as f32;
        let mut seen = Box::new([[Seen::default(); Self::NODES]; Self::NODES]);
        for (r, row) in seen.iter_mut().enumerate() {
            for (c, cell) in row.iter_mut().enumerate() {
                *cell = Self::integrate(node(r), node(c).max(0.005), eta);
            }
        }
        // ∫ 2 c f(c) dc of a piecewise linear f: on an interval from c to c + h, h (c (a + b) + h (a + 2b)/3).
        let h = 1.0 / (Self::NODES - 1) as f32;
        let part = |c: f32, a: f32, b: f32| h * (c * (a + b) + h * (a + 2.0 * b) / 3.0);
        let mean = |f: &dyn Fn(usize) -> f32| (1..Self::NODES).map(|i| part(node(i - 1), f(i - 1), f(i))).sum();
        let share = core::array::from_fn(|r| mean(&|c| seen[r][c].share));
        let dielectric = mean(&|c| dielectric_rise(node(c), eta));
        Self { eta, seen, share, dielectric }
    }

    fn integrate(roughness: f32, cos: f32, eta: f32) -> Seen {
        let facets = Facets::new(Distribution::Ggx, Vec2::splat(roughness * roughness));
        let w = Vec3A::new((1.0 - cos * cos).max(0.0).sqrt(), 0.0, cos);
        let coordinate = |i: usize| (i as f32 + 0.5) / Self::POINTS as f32;
        let (mut share, mut rise) = (0.0, [0.0; 2]);
        for i in 0..Self::POINTS * Self::POINTS {
            let u = Vec2::new(coordinate(i % Self::POINTS), coordinate(i / Self::POINTS));
            let Some(h) = facets.sample(w, u) else { continue };
            let (cos, wi) = (w.dot(h), 2.0 * w.dot(h) * h - w);
            if wi.z > 0.0 {
                let left = facets.g1(wi, h);
                share += left;
                rise[0] += left * dielectric_rise(cos, eta);
                rise[1] += left * schlick_rise(cos);
            }
        }
        let points = (Self::POINTS * Self::POINTS) as f32;
        Seen { share: share / points, rise: rise.map(|sum| if share > 0.0 { sum / share } else { 0.0 }) }
    }

    /// Index of the dielectric.
    #[inline]
    pub fn eta(&self) -> f32 {
        self.eta
    }

    /// For a perceptual roughness and the cosine of the view.
    #[inline]
    pub fn albedo(&self, roughness: f32, cos: f32) -> FacetAlbedo {
        let place = |x: f32| {
            let x = x.clamp(0.0, 1.0) * (Self::NODES - 1) as f32;
            let i = (x as usize).min(Self::NODES - 2);
            (i, x - i as f32)
        };
        let ((r, fr), (c, fc)) = (place(roughness), place(cos));
        let mix = |a: f32, b: f32, t: f32| a + (b - a) * t;
        let at = |f: fn(&Seen) -> f32| {
            let along = |r: usize| mix(f(&self.seen[r][c]), f(&self.seen[r][c + 1]), fc);
            mix(along(r), along(r + 1), fr)
        };
        let seen = Seen { share: at(|s| s.share).max(0.1), rise: [at(|s| s.rise[0]), at(|s| s.rise[1])] };
        // ∫ 2 c (1 − c)⁵ dc is 1/21.
        let mean_rise = [self.dielectric, 1.0 / 21.0];
        FacetAlbedo { seen, mean_share: mix(self.share[r], self.share[r + 1], fr), mean_rise }
    }
}

impl FacetAlbedo {
    /// Factor on one bounce that stands for all bounces among the facets: 1 + F_ms (1 − E)/E (Turquin 2019, "Practical
    /// multiple scattering compensation for microfacet models"), with F_ms = F̄ Ē/(1 − F̄ (1 − Ē)) of the mean F̄ of
    /// Fresnel's term (Kulla and Conty 2017). White facets then lose nothing. It costs reciprocity.
    #[inline]
    pub fn all_bounces(&self, f0: Rgb, f90: Rgb, rise: Rise) -> Rgb {
        let mean_f = f0 + (f90 - f0) * self.mean_rise[rise as usize];
        let further = mean_f * self.mean_share / (Rgb::ONE - mean_f * (1.0 - self.mean_share));
        Rgb::ONE + further * ((1.0 - self.seen.share) / self.seen.share)
    }

    /// How much further Fresnel's term of the dielectric has risen than Schlick's, in the mean over the facets.
    #[inline]
    pub fn ahead(&self) -> f32 {
        self.seen.rise[Rise::Dielectric as usize] - self.seen.rise[Rise::Schlick as usize]
    }

    /// Share of light that facets send back in all.
    #[inline]
    pub fn reflected(&self, f0: Rgb, f90: Rgb, rise: Rise) -> Rgb {
        let f = f0 + (f90 - f0) * self.seen.rise[rise as usize];
        f * self.seen.share * self.all_bounces(f0, f90, rise)
    }
}
