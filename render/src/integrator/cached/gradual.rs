//! A fill that is left and gone on with, for who looks at the caches in between.

use super::build::Builder;
use super::caches::Caches;
use super::kinds::COUNT;
use super::rendering::Rendering;
use crate::cache::{Course, Density, Grid};
use crate::scene::Camera;
use crate::world::World;
use std::time::Instant;

/// Records that are made between looks at the clock: a few hundredths of a second.
const BATCH: usize = 32;

/// How far the fills of all caches are.
pub(super) struct Courses {
    pub coarse: Course,
    pub diffuse: Course,
    /// By kind.
    pub glossy: [Course; COUNT],
}

impl Courses {
    /// Before all of them.
    pub fn new(grid: Grid, density: Density) -> Self {
        let course = || Course::new(grid, density);
        Self { coarse: course(), diffuse: course(), glossy: core::array::from_fn(|_| course()) }
    }

    /// Whether all caches hold what is needed.
    pub fn are_done(&self) -> bool {
        self.coarse.is_done() && self.diffuse.is_done() && self.glossy.iter().all(Course::is_done)
    }

    /// Leaves the rest.
    pub fn end(&mut self) {
        self.diffuse.end();
        self.glossy.iter_mut().for_each(Course::end);
    }
}

/// A fill for one camera, in steps. After the last step the caches are those that [`Rendering::fill`] makes.
pub struct GradualFill<'a> {
    builder: Builder<'a>,
    courses: Courses,
}

impl<'a> GradualFill<'a> {
    /// For a camera, whatever that of the world is.
    pub fn new(rendering: &'a Rendering, world: &'a World, camera: &Camera, tolerance: f32) -> Self {
        Self::of(rendering.coarse_builder(world, camera, tolerance, rendering.settings.seed))
    }

    /// The same for one of many views, which looks at fewer pixels, with a seed of its own. Sums over records have an order of their own
    /// until [`Caches::refile`].
    pub fn scouting(
        rendering: &'a Rendering,
        world: &'a World,
        camera: &Camera,
        tolerance: f32,
        (density, seed): (Density, u64),
    ) -> Self {
        Self::of(rendering.coarse_builder(world, camera, tolerance, seed).scouting(density))
    }

    fn of(builder: Builder<'a>) -> Self {
        let builder = builder.in_batches(BATCH);
        let courses = builder.courses();
        Self { builder, courses }
    }

    /// Makes records until the deadline. `progress` is told the share of the work done.
    pub fn step(&mut self, caches: &mut Caches, deadline: Instant, progress: &(dyn Fn(f64) + Sync)) {
        self.builder.go_on(&mut self.courses, caches, Some(deadline), progress);
    }

    /// Whether the caches hold all that the camera needs.
    pub fn is_done(&self) -> bool {
        self.courses.are_done()
    }
}
