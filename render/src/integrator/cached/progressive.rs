//! Pictures that are looked at while they are made: sums that grow sample by sample, and may be left at any time.

use super::Settings;
use super::caches::Caches;
use super::passes::Passes;
use super::rendering::Rendering;
use super::surface::Surface;
use crate::picture::{Picture, Pixel};
use crate::scene::{Camera, Crop};
use crate::world::{Counts, World};
use std::sync::atomic::{AtomicBool, Ordering};

/// Asks a pass over a picture to leave off, which it does after the rows in work.
#[derive(Debug, Default)]
pub struct Halt(AtomicBool);

impl Halt {
    /// Asks for it, or lets the next pass begin.
    pub fn set(&self, halt: bool) {
        self.0.store(halt, Ordering::Relaxed);
    }

    /// Whether it is asked for.
    pub fn is_set(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// What the pixels of a camera have come to, before the light of records is added.
#[derive(Clone, Default)]
pub struct Sums {
    pub(super) pixels: Vec<Pixel>,
    /// Of each pixel.
    pub(super) surfaces: Vec<Vec<Surface>>,
    pub(super) spp: u32,
    pub(super) counts: Counts,
    /// Whether the graphics card was to sum records and failed, in any of the pictures so far.
    pub(super) card_failed: bool,
}

impl Sums {
    /// Begins anew for a picture of this size, in the same memory.
    pub fn clear(&mut self, window: Crop) {
        let count = window.width as usize * window.height as usize;
        self.pixels.clear();
        self.pixels.resize(count, Pixel::default());
        self.surfaces.truncate(count);
        self.surfaces.iter_mut().for_each(Vec::clear);
        self.surfaces.resize_with(count, Vec::new);
        (self.spp, self.counts) = (0, Counts::default());
    }

    /// Whether the graphics card was to sum records of any picture so far, and failed: then the processor summed them.
    pub fn card_failed(&self) -> bool {
        self.card_failed
    }

    /// Samples of every pixel.
    pub fn spp(&self) -> u32 {
        self.spp
    }
}

/// What a picture is made from.
#[derive(Clone, Copy)]
pub struct Scenery<'a> {
    /// The scene, whose own camera does not count.
    pub world: &'a World,
    /// Who looks.
    pub camera: &'a Camera,
    /// τ.
    pub tolerance: f32,
    /// Records.
    pub caches: &'a Caches,
}

impl Rendering<'_> {
    /// Adds samples to sums. Returns `false` where it was asked to leave off: the sums are of no use then.
    pub fn go_on(&self, from: &Scenery, sums: &mut Sums, (samples, seed): (u32, u64), halt: &Halt) -> bool {
        self.passing(from, sums, seed, halt, |passes| passes.direct(samples));
        !halt.is_set()
    }

    /// The picture that the sums make with the light of records: after as many samples, with the same seed and all records that the
    /// camera needs, that of [`Rendering::shade`]. `None` where it was asked to leave off.
    pub fn developed(&self, from: &Scenery, sums: &mut Sums, seed: u64, halt: &Halt) -> Option<Picture> {
        let mut pixels = sums.pixels.clone();
        let (traced, _) = self.passing(from, sums, seed, halt, |passes| passes.add_indirect(&mut pixels, &|_| ()));
        let counts = [sums.counts, traced].into_iter().sum();
        let picture = Picture::of(from.camera.film.window(), pixels, sums.spp, counts, true);
        (!halt.is_set()).then_some(picture)
    }

    /// Does something with the passes that go on with sums.
    fn passing<T>(
        &self,
        from: &Scenery,
        sums: &mut Sums,
        seed: u64,
        halt: &Halt,
        work: impl FnOnce(&mut Passes) -> T,
    ) -> T {
        let shader = self.shader((from.world, from.camera), from.tolerance, from.caches);
        let settings = Settings { seed, ..self.settings };
        let mut passes = Passes::with(&shader, &settings, from.camera, core::mem::take(sums), Some(halt));
        let done = work(&mut passes);
        *sums = passes.into_sums();
        done
    }
}
