//! Ray queries with memory that is reused from ray to ray.

use super::World;
use crate::bvh::{Lanes, Stack};
use crate::ray::{Hit, Ray};
use crate::sampler::Scrambles;
use core::cell::Cell;
use core::ops::AddAssign;

/// What was done so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Rays traced.
    pub rays: u64,
    /// Paths followed from the eye, from surfaces in a pixel, or from records.
    pub paths: u64,
    /// Paths and records that were dropped because a number in them was not finite: each darkens the picture.
    pub not_finite: u64,
}

impl AddAssign for Counts {
    fn add_assign(&mut self, other: Self) {
        self.rays += other.rays;
        self.paths += other.paths;
        self.not_finite += other.not_finite;
    }
}

impl core::iter::Sum for Counts {
    fn sum<I: Iterator<Item = Self>>(counts: I) -> Self {
        let mut sum = Self::default();
        counts.for_each(|c| sum += c);
        sum
    }
}

/// What a thread keeps from path to path. No result depends on what an earlier path left here.
#[derive(Clone, Debug, Default)]
pub struct Queries {
    /// What was done so far.
    pub counts: Counts,
    /// What the samples of a pixel or record have in common.
    pub scrambles: Scrambles,
    stack: Stack,
}

impl Queries {
    /// [`World::intersect`].
    #[inline(always)]
    pub fn intersect(&mut self, world: &World, ray: &Ray) -> Hit {
        self.counts.rays += 1;
        let mut hit = Hit { t: ray.t_max, ..Hit::NONE };
        world.aggregate.intersect(world.context(), &mut self.stack, ray, &mut hit);
        if world.masked { world.through_masks(&mut self.stack, ray, hit) } else { hit }
    }

    /// [`World::occluded`].
    #[inline(always)]
    pub fn occluded(&mut self, world: &World, ray: &Ray) -> bool {
        self.counts.rays += 1;
        let partly = Cell::new(false);
        let met = world.aggregate.occluded(world.context(), &mut self.stack, ray, &partly);
        met && (!partly.get() || self.is_stopped(world, ray))
    }

    /// [`World::intersect`] of the rays whose bit is set.
    #[inline(always)]
    pub(crate) fn intersect_all<const N: usize>(&mut self, world: &World, rays: &[Ray; N], which: u32) -> [Hit; N] {
        match world.aggregate.triangles_alone() {
            Some(bvh) => {
                let mut hits = rays.each_ref().map(|ray| Hit { t: ray.t_max, ..Hit::NONE });
                self.counts.rays += u64::from(which.count_ones());
                bvh.intersect_all(&mut self.stack, rays, which, &mut hits);
                hits
            }
            None => {
                let mut hits = [Hit::NONE; N];
                Lanes(which).for_each(|i| hits[i] = self.intersect(world, &rays[i]));
                hits
            }
        }
    }

    /// [`World::occluded`] of the rays whose bit is set: the bits of those that are.
    #[inline(always)]
    pub(crate) fn occluded_all<const N: usize>(&mut self, world: &World, rays: &[Ray; N], which: u32) -> u32 {
        match world.aggregate.triangles_alone() {
            Some(bvh) => {
                self.counts.rays += u64::from(which.count_ones());
                bvh.occluded_all(&mut self.stack, rays, which)
            }
            None => Lanes(which).fold(0, |bits, i| bits | u32::from(self.occluded(world, &rays[i])) << i),
        }
    }

    /// Whether a ray that meets surfaces with holes is stopped by any of them.
    #[inline(never)]
    fn is_stopped(&mut self, world: &World, ray: &Ray) -> bool {
        let mut hit = Hit { t: ray.t_max, ..Hit::NONE };
        world.aggregate.intersect(world.context(), &mut self.stack, ray, &mut hit);
        world.through_masks(&mut self.stack, ray, hit).exists()
    }
}
