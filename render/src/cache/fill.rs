//! Filling a cache: waves of candidates, coarse to fine.
//!
//! A wave sees the records of earlier waves only, and its records are inserted in the order of their pixels: the cache is
//! the same for any number of threads.

use super::{Cache, Shrink};
use crate::record::Record;
use rayon::prelude::*;
use std::time::Instant;

/// Candidates are the pixels of a film.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Grid {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

/// Told the share of the pixels that were looked at.
pub type Progress<'a> = &'a (dyn Fn(f64) + Sync);

/// Spacing of the first wave, pixels.
const COARSEST: u32 = 32;

/// Records of a wave that are made at once, unless something waits for each batch.
pub const BATCH: usize = 256;

/// Which candidates are looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Density {
    /// All.
    Every,
    /// A lattice of this spacing (a power of two), shifted by `offset`; and all about those pixels of it that nothing reaches.
    Scouted {
        /// Pixels.
        spacing: u32,
        /// Columns and rows.
        offset: [u32; 2],
    },
}

/// What a filling goes over, and until when.
#[derive(Clone, Copy)]
pub struct Filler<'a> {
    /// Candidates.
    pub grid: Grid,
    /// Which of them.
    pub density: Density,
    /// Whether records are filed anew at the end, which takes time where there are many.
    pub refile: bool,
    /// Records that are made at once: between such batches the clock is looked at. The cache does not depend on it.
    pub batch: usize,
    /// End of the time there is.
    pub deadline: Option<Instant>,
    /// Told how far it is.
    pub progress: Progress<'a>,
}

/// How far a filling is, so that it can be left and gone on with.
pub struct Course {
    scouts: Scouts,
    waves: Box<dyn Iterator<Item = Wave> + Send>,
    /// Pixels of the wave in work that nothing reached when it began.
    open: Vec<usize>,
    /// How many of them have had their turn.
    turned: usize,
    /// Pixels that were looked at, the wave in work included.
    seen: usize,
    done: bool,
}

impl Course {
    /// Before the first wave.
    pub fn new(grid: Grid, density: Density) -> Self {
        let waves = Box::new(waves(grid, density));
        Self { scouts: Scouts::new(grid, density), waves, open: Vec::new(), turned: 0, seen: 0, done: false }
    }

    /// Whether there is nothing more to do.
    pub fn is_done(&self) -> bool {
        self.done
    }

    /// Leaves the rest.
    pub fn end(&mut self) {
        self.done = true;
    }

    /// Begins the next wave; `false` after the last.
    fn next<R: Record>(
        &mut self,
        cache: &mut Cache<R>,
        adapt: impl Fn(&Cache<R>, usize) -> Vec<Shrink> + Sync,
        covered: impl Fn(&Cache<R>, usize) -> bool + Sync,
    ) -> bool {
        self.scouts.note(&self.open);
        let Some(wave) = self.waves.next() else { return false };
        let pixels = self.scouts.choose(&wave);
        let shrinks: Vec<Shrink> = pixels.par_iter().flat_map_iter(|&i| adapt(cache, i)).collect();
        cache.shrink(&shrinks);
        self.open = pixels.into_par_iter().filter(|&i| !covered(cache, i)).collect();
        (self.turned, self.seen) = (0, self.seen + wave.len());
        true
    }
}

impl Filler<'_> {
    /// Makes a record at every pixel that is not `covered` by the time its wave comes. `adapt` tells which records must
    /// reach less far for what they say of a pixel. `insert` adds a record, and may adjust it and its neighbours. Stops at
    /// the deadline; called again with the same `course` it goes on, to the same records as without a stop.
    pub fn fill<R: Record, M: Send>(
        &self,
        course: &mut Course,
        cache: &mut Cache<R>,
        adapt: impl Fn(&Cache<R>, usize) -> Vec<Shrink> + Sync,
        covered: impl Fn(&Cache<R>, usize) -> bool + Sync,
        make: impl Fn(&Cache<R>, usize) -> Option<M> + Sync,
        mut insert: impl FnMut(&mut Cache<R>, M),
    ) {
        if course.done {
            return;
        }
        let total = f64::from(self.grid.width) * f64::from(self.grid.height);
        loop {
            while course.turned < course.open.len() {
                if self.deadline.is_some_and(|end| Instant::now() >= end) {
                    return;
                }
                let end = course.open.len().min(course.turned + self.batch.max(1));
                let batch = &course.open[course.turned..end];
                let made: Vec<M> = batch.par_iter().filter_map(|&i| make(cache, i)).collect();
                made.into_iter().for_each(|record| insert(cache, record));
                course.turned = end;
            }
            (self.progress)(course.seen as f64 / total);
            if !course.next(cache, &adapt, &covered) {
                break;
            }
        }
        course.done = true;
        if self.refile {
            cache.refile();
        }
    }
}

/// Pixels of one spacing.
#[derive(Clone, Copy)]
struct Wave {
    grid: Grid,
    /// Of all pixels up to this wave.
    spacing: u32,
    /// Of its own pixels, and the first of them.
    step: u32,
    first: [u32; 2],
}

impl Wave {
    /// Number of its pixels.
    fn len(&self) -> usize {
        let count = |first: u32, of: u32| of.saturating_sub(first).div_ceil(self.step) as usize;
        count(self.first[0], self.grid.width) * count(self.first[1], self.grid.height)
    }

    fn pixels(&self) -> impl Iterator<Item = usize> + use<> {
        let Self { grid: Grid { width, height }, step, first: [x0, y0], .. } = *self;
        let columns = move |y: u32| (x0..width).step_by(step as usize).map(move |x| (y * width + x) as usize);
        (y0..height).step_by(step as usize).flat_map(columns)
    }
}

/// Every pixel once: a coarse grid, then the three grids between at every halving of the spacing.
fn waves(grid: Grid, density: Density) -> impl Iterator<Item = Wave> {
    let [right, down] = match density {
        Density::Every => [0, 0],
        Density::Scouted { offset, .. } => offset,
    };
    let halvings = (0..COARSEST.ilog2()).map(|k| COARSEST >> k);
    let finer = halvings.flat_map(move |s| [(s, s / 2, s / 2), (s, s / 2, 0), (s, 0, s / 2)].map(|at| (s / 2, at)));
    let all = core::iter::once((COARSEST, (COARSEST, 0, 0))).chain(finer);
    let wave =
        move |(spacing, (step, x, y))| Wave { grid, spacing, step, first: [(x + right) % step, (y + down) % step] };
    all.map(wave)
}

/// Where pixels between those of a lattice are looked at.
struct Scouts {
    grid: Grid,
    /// Finest lattice that is looked at everywhere.
    spacing: u32,
    /// Blocks of this lattice in which nothing reached a pixel, and their neighbours.
    open: Vec<bool>,
}

impl Scouts {
    fn new(grid: Grid, density: Density) -> Self {
        let spacing = match density {
            Density::Every => 1,
            Density::Scouted { spacing, .. } => spacing.max(1),
        };
        let blocks = if spacing == 1 { 0 } else { grid.width.div_ceil(spacing) * grid.height.div_ceil(spacing) };
        Self { grid, spacing, open: vec![false; blocks as usize] }
    }

    fn block(&self, pixel: usize) -> (u32, u32) {
        let pixel = pixel as u32;
        (pixel % self.grid.width / self.spacing, pixel / self.grid.width / self.spacing)
    }

    /// Those of a wave that are to be looked at.
    fn choose(&self, wave: &Wave) -> Vec<usize> {
        if wave.spacing >= self.spacing {
            return wave.pixels().collect();
        }
        if !self.open.contains(&true) {
            return Vec::new();
        }
        let columns = self.grid.width.div_ceil(self.spacing);
        let is_open = |pixel: &usize| {
            let (x, y) = self.block(*pixel);
            self.open[(y * columns + x) as usize]
        };
        wave.pixels().filter(is_open).collect()
    }

    /// Notes pixels that nothing reached.
    fn note(&mut self, pixels: &[usize]) {
        if self.spacing == 1 {
            return;
        }
        let (columns, rows) = (self.grid.width.div_ceil(self.spacing), self.grid.height.div_ceil(self.spacing));
        for &pixel in pixels {
            let (x, y) = self.block(pixel);
            for y in y.saturating_sub(1)..=(y + 1).min(rows - 1) {
                for x in x.saturating_sub(1)..=(x + 1).min(columns - 1) {
                    self.open[(y * columns + x) as usize] = true;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn waves_meet_every_pixel_once() {
        let scouted = Density::Scouted { spacing: 4, offset: [3, 2] };
        for (width, height) in [(1, 1), (40, 33), (100, 7)] {
            for density in [Density::Every, scouted] {
                let mut count = vec![0; (width * height) as usize];
                waves(Grid { width, height }, density).flat_map(|w| w.pixels()).for_each(|i| count[i] += 1);
                let pixels: usize = waves(Grid { width, height }, density).map(|w| w.len()).sum();
                assert_eq!(pixels, (width * height) as usize);
                assert!(count.iter().all(|&n| n == 1), "{width} {height} {density:?}");
            }
        }
    }

    /// Scouts look at a lattice, and closely only about what nothing reaches.
    #[test]
    fn scouts_look_closely_where_it_is_open() {
        let grid = Grid { width: 40, height: 40 };
        let density = Density::Scouted { spacing: 4, offset: [1, 2] };
        let looked = |hole: Option<usize>| {
            let mut scouts = Scouts::new(grid, density);
            let mut looked = Vec::new();
            for wave in waves(grid, density) {
                let pixels = scouts.choose(&wave);
                let open: Vec<_> = pixels.iter().copied().filter(|p| Some(*p) == hole).collect();
                scouts.note(&open);
                looked.extend(pixels);
            }
            looked
        };
        let lattice = looked(None);
        assert_eq!(lattice.len(), 100);
        assert!(lattice.iter().all(|p| p % 40 % 4 == 1 && p / 40 % 4 == 2));
        // Nine blocks of 4 × 4 about the hole, and the rest of the lattice.
        assert_eq!(looked(Some(22 * 40 + 21)).len(), 100 + 9 * 15);
    }
}
