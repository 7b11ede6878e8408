//! Estimators of the radiance along a ray.

pub mod cached;
mod media;
mod path;
mod simple;

use crate::bsdf::Split;
use crate::ray::Ray;
use crate::sampler::Sampler;
use crate::scene::Rgb;
use crate::world::{Queries, World};
use core::ops::AddAssign;
use glam::Vec3A;
pub use path::PathTracer;
pub use simple::SimplePathTracer;

/// Radiance along a ray, by the way the light took, and what the ray meets first.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Radiance {
    /// From emitters the ray itself meets.
    pub emission: Rgb,
    /// From emitters, scattered once; by the part of the first surface that scattered it.
    pub direct: Split,
    /// Scattered more than once; by the part of the first surface.
    pub indirect: Split,
    /// Reflectance of the first surface.
    pub albedo: Rgb,
    /// Unit shading normal of the first surface, towards the eye; zero without surface.
    pub normal: Vec3A,
    /// Distance to the first surface; 0 without surface.
    pub distance: f32,
}

impl Radiance {
    /// Light of all ways.
    #[inline]
    pub fn sum(&self) -> Rgb {
        self.emission + self.direct.sum() + self.indirect.sum()
    }

    /// Whether every number is finite, and so will be the sum over the samples of a pixel.
    #[inline]
    pub fn is_finite(&self) -> bool {
        summable(self.sum() + self.albedo + self.normal + Vec3A::splat(self.distance))
    }

    /// The same, or nothing where a number is not finite: nothing of a broken sample enters a picture. `queries` counts it.
    #[inline]
    pub fn finite(self, queries: &mut Queries) -> Self {
        if self.is_finite() {
            return self;
        }
        queries.counts.not_finite += 1;
        Self::default()
    }
}

/// Whether millions of such numbers have a sum; not so where one is NaN.
#[inline]
pub(crate) fn summable(x: Rgb) -> bool {
    x.abs().cmplt(Vec3A::splat(1e30)).all()
}

impl AddAssign for Radiance {
    #[inline]
    fn add_assign(&mut self, other: Self) {
        self.emission += other.emission;
        self.direct = self.direct + other.direct;
        self.indirect = self.indirect + other.indirect;
        self.albedo += other.albedo;
        self.normal += other.normal;
        self.distance += other.distance;
    }
}

/// An estimator of incident radiance: right on average, whatever the sampler's seed.
pub trait Integrator: Sync {
    /// Estimates the radiance that arrives at the origin of `ray` against its (unit) direction.
    fn radiance(&self, world: &World, ray: Ray, sampler: &mut Sampler, queries: &mut Queries) -> Radiance;
}
