//! What the pictures of one world through caches share.

use super::Settings;
use super::build::Builder;
use super::caches::Caches;
use super::passes::{Passes, STRIP};
use super::points::PixelCone;
use super::policy::Policy;
use super::reading::{Paths, Reading};
use super::report::Shading;
use super::settings::{Knobs, Quality};
use super::shade::Shader;
use super::split::LightSplit;
use super::surface::Grouping;
use crate::cache::Density;
use crate::picture::{Budget, Picture};
use crate::scene::Camera;
use crate::world::World;
use std::time::Instant;

/// Pixels along the longer side of the film that a fill looks at, at most: bounds of records are in pixels, and light has no more detail
/// in a larger picture. What lies between is traced where no record reaches.
const FILL_PIXELS: u32 = 512;

/// How the pictures of one world are rendered, whatever camera it has when they are.
#[derive(Clone, Debug)]
pub struct Rendering<'a> {
    /// Treatment of the materials.
    pub policy: &'a Policy,
    /// What to render with.
    pub settings: Settings,
    knobs: Knobs,
    split: LightSplit,
    reading: Reading,
    paths: Paths,
    strip: usize,
}

impl<'a> Rendering<'a> {
    /// With the numbers that pictures are rendered with.
    pub fn new(world: &World, policy: &'a Policy, settings: &Settings) -> Self {
        Self::with(world, policy, settings, &Knobs::default())
    }

    /// With other numbers.
    pub(super) fn with(world: &World, policy: &'a Policy, settings: &Settings, knobs: &Knobs) -> Self {
        let split = LightSplit::new(world, settings.indirect_only);
        let (settings, knobs, reading, paths) = (*settings, *knobs, Reading::default(), Paths::SMOOTH);
        Self { policy, settings, knobs, split, reading, paths, strip: STRIP }
    }

    /// The same, where these pixels read records.
    pub fn reading(self, reading: Reading) -> Self {
        Self { reading, ..self }
    }

    /// The same, which keeps the surfaces of about so many pixels in memory where the number of samples is known. The picture is
    /// the same where all pixels read records.
    pub fn in_strips(self, pixels: usize) -> Self {
        Self { strip: pixels, ..self }
    }

    fn quality(&self, tolerance: f32) -> Quality {
        self.settings.quality(&self.knobs, tolerance)
    }

    /// The same, for pictures that a denoiser will see, or not.
    pub fn denoised(self, denoised: bool) -> Self {
        Self { paths: if denoised { Paths::DENOISED } else { Paths::SMOOTH }, ..self }
    }

    /// The same, for pictures that are shown for a moment: few pixels read records, and what these do not hold is one path.
    pub fn hasty(self) -> Self {
        Self { paths: Paths::HASTY, reading: Reading::Rough, ..self }
    }

    /// Adds to caches, until the deadline, what the camera of the world needs at τ.
    pub fn fill(
        &self,
        world: &World,
        tolerance: f32,
        kept: Option<Caches>,
        deadline: Option<Instant>,
        progress: &(dyn Fn(f64) + Sync),
    ) -> Caches {
        self.builder(world, tolerance, self.settings.seed).build(kept, deadline, progress)
    }

    /// The same for one of many frames, with a seed of its own, and looking at fewer pixels. Afterwards sums over records have
    /// an order of their own until [`Caches::refile`].
    pub fn fill_frame(
        &self,
        world: &World,
        tolerance: f32,
        kept: Caches,
        (density, seed): (Density, u64),
        deadline: Option<Instant>,
    ) -> Caches {
        self.builder(world, tolerance, seed).scouting(density).build(Some(kept), deadline, &|_| ())
    }

    /// How near the camera of a world is to what it sees: the median width of a pixel there.
    pub fn footprint(&self, world: &World) -> f32 {
        self.builder(world, super::TOLERANCE, self.settings.seed).median_footprint()
    }

    /// Share of the pixels of the camera of the world that need a record which is not there.
    pub fn holes(&self, world: &World, tolerance: f32, caches: &Caches) -> f64 {
        let window = world.scene.camera.film.window();
        let holes = self.builder_through(world, &world.scene.camera, tolerance, self.settings.seed).holes(caches);
        holes as f64 / (f64::from(window.width) * f64::from(window.height)).max(1.0)
    }

    fn builder<'w>(&'w self, world: &'w World, tolerance: f32, seed: u64) -> Builder<'w> {
        self.coarse_builder(world, &world.scene.camera, tolerance, seed)
    }

    /// What fills caches for a camera, whose film may be larger than what a fill looks at.
    pub(super) fn coarse_builder<'w>(
        &'w self,
        world: &'w World,
        camera: &Camera,
        tolerance: f32,
        seed: u64,
    ) -> Builder<'w> {
        let coarse = Camera { film: camera.film.at_most(FILL_PIXELS), ..camera.clone() };
        self.builder_through(world, &coarse, tolerance, seed)
    }

    fn builder_through<'w>(&'w self, world: &'w World, camera: &Camera, tolerance: f32, seed: u64) -> Builder<'w> {
        Builder::new(world, camera, self.policy, self.split.held.as_ref(), self.quality(tolerance), seed)
    }

    /// The picture that the camera of the world takes, from caches that were filled for τ, within the budget, which began at
    /// `start`, with sample points of this seed; and what is told of it.
    pub fn shade(
        &self,
        world: &World,
        tolerance: f32,
        caches: &Caches,
        (budget, seed): (Budget, u64),
        start: Instant,
        progress: &(dyn Fn(f64) + Sync),
    ) -> (Picture, Shading) {
        let shader = self.shader((world, &world.scene.camera), tolerance, caches);
        let settings = Settings { budget, seed, ..self.settings };
        Passes::new(&shader, &settings).run(start, self.strip, progress)
    }

    /// What shades pixels of a camera.
    pub(super) fn shader<'s>(
        &'s self,
        (world, camera): (&'s World, &Camera),
        tolerance: f32,
        caches: &'s Caches,
    ) -> Shader<'s> {
        Shader {
            world,
            policy: self.policy,
            caches,
            split: &self.split,
            quality: self.quality(tolerance),
            indirect_only: self.settings.indirect_only,
            cone: PixelCone::new(camera),
            grouping: Grouping::new(camera.lens.is_some()),
            reading: self.reading,
            paths: self.paths,
        }
    }
}
