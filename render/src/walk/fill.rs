//! Filling the caches for all frames of a path.
//!
//! A few frames are looked at pixel by pixel. Of all others only a lattice is, which moves from frame to frame, so that sixteen frames
//! look everywhere; and what is about a point that no record reaches. Frames are filled one after the other, those first that
//! see things from near: records are as far apart as pixels ask for, and those for a far view are too coarse for a near one.

use super::frames::seed_of;
use super::path::Walk;
use crate::cache::Density;
use crate::integrator::cached::file::WalkMark;
use crate::integrator::cached::{Caches, Rendering};
use crate::world::{Counts, World};
use std::time::Instant;

/// Frames that are looked at pixel by pixel.
const KEYS: u32 = 8;
/// Spacing of the lattice in all others.
const SPACING: u32 = 4;
/// Frames of a wave. After it records are filed anew and may be kept in a file: a fill that goes on from there makes the same
/// records.
const WAVE: u32 = 4;

/// How caches are filled for frames of a path.
pub struct Fill<'a> {
    /// How pictures are rendered.
    pub rendering: &'a Rendering<'a>,
    /// The path.
    pub walk: &'a Walk,
    /// τ.
    pub tolerance: f32,
    /// First and last of the frames, counted from the first of the path.
    pub range: [u32; 2],
    /// When to stop, whatever is missing.
    pub deadline: Option<Instant>,
}

/// How far a fill is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Filled {
    /// Frames that are filled.
    pub frames: u32,
    /// Of so many.
    pub all: u32,
    /// Records so far.
    pub records: usize,
}

impl Fill<'_> {
    /// Frames in the order in which they are filled, and how each is looked at.
    fn order(&self, world: &mut World) -> Vec<(u32, Density)> {
        let [first, last] = self.range;
        let count = last - first + 1;
        let mut keys: Vec<u32> = if count <= KEYS {
            (first..=last).collect()
        } else {
            let key = |k: u32| first + ((u64::from(k) * u64::from(count - 1)) / u64::from(KEYS - 1)) as u32;
            (0..KEYS).map(key).collect()
        };
        let scouted = |frame: u32| {
            // Sixteen frames in a row look at each pixel of a cell of the lattice.
            let (column, row) = (frame % SPACING, (frame + frame / SPACING) % SPACING);
            let apart = [0, 2, 1, 3];
            (frame, Density::Scouted { spacing: SPACING, offset: [apart[column as usize], apart[row as usize]] })
        };
        let mut others: Vec<u32> = (first..=last).filter(|frame| !keys.contains(frame)).collect();
        let mut near: Vec<f32> = Vec::with_capacity(count as usize);
        for frame in first..=last {
            self.stand(world, frame);
            near.push(self.rendering.footprint(world));
        }
        let by_nearness = |a: &u32, b: &u32| near[(a - first) as usize].total_cmp(&near[(b - first) as usize]);
        keys.sort_by(by_nearness);
        others.sort_by(by_nearness);
        keys.into_iter().map(|frame| (frame, Density::Every)).chain(others.into_iter().map(scouted)).collect()
    }

    /// Puts the camera where it is in a frame.
    fn stand(&self, world: &mut World, frame: u32) {
        if let Some(camera) = self.walk.camera(self.walk.frames().start() + frame) {
            world.scene.camera.clone_from(camera);
        }
    }

    /// Fills caches, going on where an earlier fill of the same frames was stopped. `save` is offered the caches whenever they may
    /// be kept, before the last time.
    ///
    /// # Errors
    /// Those of `save`.
    pub fn run<E>(
        &self,
        world: &mut World,
        mut caches: Caches,
        mut save: impl FnMut(&Caches) -> Result<(), E>,
        progress: &dyn Fn(Filled),
    ) -> Result<Caches, E> {
        let order = self.order(world);
        let path = self.walk.checksum();
        let frames = self.walk.frames();
        let count = frames.end() - frames.start() + 1;
        let mut mark = caches.walk.take().filter(|mark| (mark.path, mark.frames) == (path, count));
        let mut mark = mark.take().unwrap_or_else(|| WalkMark::new(path, count));
        let done = mark.current.filter(|(range, _)| *range == self.range).map_or(0, |(_, done)| done);
        let mut counts = Counts::default();
        for (i, (frame, density)) in (0..).zip(&order).skip(done as usize) {
            if self.deadline.is_some_and(|deadline| Instant::now() >= deadline) {
                break;
            }
            progress(Filled { frames: i, all: order.len() as u32, records: caches.records() });
            self.stand(world, *frame);
            let seed = seed_of(self.rendering.settings.seed, *frame);
            caches = self.rendering.fill_frame(world, self.tolerance, caches, (*density, seed), self.deadline);
            counts = [counts, caches.counts].into_iter().sum();
            let filled = i + 1;
            if filled % WAVE == 0 && (filled as usize) < order.len() {
                caches.refile();
                mark.current = Some((self.range, filled));
                caches.walk = Some(mark.clone());
                save(&caches)?;
            }
        }
        caches.refile();
        mark.current = None;
        mark.fill(self.range);
        caches.walk = Some(mark);
        caches.counts = counts;
        Ok(caches)
    }
}
