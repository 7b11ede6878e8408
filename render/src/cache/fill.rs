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

/// Records of a wave that are made at once: between such batches the clock is looked at.
const BATCH: usize = 256;

/// What a filling goes over, and until when.
#[derive(Clone, Copy)]
pub struct Filler<'a> {
    /// Candidates.
    pub grid: Grid,
    /// End of the time there is.
    pub deadline: Option<Instant>,
    /// Told how far it is.
    pub progress: Progress<'a>,
}

impl Filler<'_> {
    /// Makes a record at every pixel that is not `covered` by the time its wave comes. `adapt` tells which records must
    /// reach less far for what they say of a pixel. `insert` adds a record, and may adjust it and its neighbours. Stops at
    /// the deadline; returns whether it was reached.
    pub fn fill<R: Record, M: Send>(
        &self,
        cache: &mut Cache<R>,
        adapt: impl Fn(&Cache<R>, usize) -> Vec<Shrink> + Sync,
        covered: impl Fn(&Cache<R>, usize) -> bool + Sync,
        make: impl Fn(&Cache<R>, usize) -> Option<M> + Sync,
        mut insert: impl FnMut(&mut Cache<R>, M),
    ) -> bool {
        let total = f64::from(self.grid.width) * f64::from(self.grid.height);
        let mut seen = 0;
        let mut stopped = false;
        'waves: for pixels in waves(self.grid) {
            let shrinks: Vec<Shrink> = pixels.par_iter().flat_map_iter(|&i| adapt(cache, i)).collect();
            cache.shrink(&shrinks);
            let open: Vec<usize> = pixels.par_iter().copied().filter(|&i| !covered(cache, i)).collect();
            for batch in open.chunks(BATCH) {
                if self.deadline.is_some_and(|end| Instant::now() >= end) {
                    stopped = true;
                    break 'waves;
                }
                let made: Vec<M> = batch.par_iter().filter_map(|&i| make(cache, i)).collect();
                made.into_iter().for_each(|record| insert(cache, record));
            }
            seen += pixels.len();
            (self.progress)(seen as f64 / total);
        }
        cache.refile();
        stopped
    }
}

/// Every pixel once: a coarse grid, then the three grids between at every halving of the spacing.
fn waves(grid: Grid) -> impl Iterator<Item = Vec<usize>> {
    let lattice = move |spacing: u32, x0: u32, y0: u32| {
        let columns =
            move |y: u32| (x0..grid.width).step_by(spacing as usize).map(move |x| (y * grid.width + x) as usize);
        (y0..grid.height).step_by(spacing as usize).flat_map(columns).collect::<Vec<_>>()
    };
    let halvings = (0..COARSEST.ilog2()).map(|k| COARSEST >> k);
    let finer = halvings.flat_map(move |s| [(s, s / 2, s / 2), (s, s / 2, 0), (s, 0, s / 2)]);
    core::iter::once((COARSEST, 0, 0)).chain(finer).map(move |(s, x, y)| lattice(s, x, y))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn waves_meet_every_pixel_once() {
        for (width, height) in [(1, 1), (40, 33), (100, 7)] {
            let mut count = vec![0; (width * height) as usize];
            waves(Grid { width, height }).flatten().for_each(|i| count[i] += 1);
            assert!(count.iter().all(|&n| n == 1), "{width} {height}");
        }
    }
}
