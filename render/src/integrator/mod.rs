//! Estimators of the radiance along a ray.

pub mod cached;
pub(crate) mod direct;
mod guides;
mod media;
mod path;
mod simple;

use crate::picture::Radiance;
use crate::ray::Ray;
use crate::sampler::Sampler;
use crate::world::{Queries, World};
pub use path::PathTracer;
pub use simple::SimplePathTracer;

/// An estimator of incident radiance: right on average, whatever the sampler's seed.
pub trait Integrator: Sync {
    /// Estimates the radiance that arrives at the origin of `ray` against its (unit) direction.
    fn radiance(&self, world: &World, ray: Ray, sampler: &mut Sampler, queries: &mut Queries) -> Radiance;
}
