//! Estimators of the radiance along a ray.

pub mod cached;
pub(crate) mod direct;
mod guides;
mod media;
mod path;
pub mod plane;
mod simple;
mod wave;

use crate::picture::Radiance;
use crate::ray::Ray;
use crate::sampler::Sampler;
use crate::world::{Queries, World};
pub use path::PathTracer;
pub use simple::SimplePathTracer;

/// Where a path starts.
#[derive(Clone, Copy, Debug)]
pub struct Start {
    /// Its first ray, of a unit direction.
    pub ray: Ray,
    /// Its sample points from there on.
    pub sampler: Sampler,
}

/// An estimator of incident radiance: right on average, whatever the sampler's seed.
pub trait Integrator: Sync {
    /// Estimates the radiance that arrives at the origin of `ray` against its (unit) direction.
    fn radiance(&self, world: &World, ray: Ray, sampler: &mut Sampler, queries: &mut Queries) -> Radiance;

    /// The same for many rays: writes as many estimates to `out`, in their order. No estimate depends on the others.
    fn radiances(&self, world: &World, starts: &[Start], queries: &mut Queries, out: &mut Vec<Radiance>) {
        out.clear();
        for start in starts {
            out.push(self.radiance(world, start.ray, &mut start.sampler.clone(), queries));
        }
    }
}
