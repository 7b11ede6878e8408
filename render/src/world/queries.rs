//! Ray queries with memory that is reused from ray to ray.

use super::World;
use crate::bvh::Stack;
use crate::ray::{Hit, Ray};
use crate::sampler::Scrambles;

/// What a thread keeps from path to path. No result depends on what an earlier path left here.
#[derive(Clone, Debug, Default)]
pub struct Queries {
    /// Rays traced so far.
    pub rays: u64,
    /// What the samples of a pixel or record have in common.
    pub scrambles: Scrambles,
    stack: Stack,
}

impl Queries {
    /// [`World::intersect`].
    #[inline(always)]
    pub fn intersect(&mut self, world: &World, ray: &Ray) -> Hit {
        self.rays += 1;
        let mut hit = Hit { t: ray.t_max, ..Hit::NONE };
        world.aggregate.intersect(world.context(), &mut self.stack, ray, &mut hit);
        hit
    }

    /// [`World::occluded`].
    #[inline(always)]
    pub fn occluded(&mut self, world: &World, ray: &Ray) -> bool {
        self.rays += 1;
        world.aggregate.occluded(world.context(), &mut self.stack, ray)
    }
}
