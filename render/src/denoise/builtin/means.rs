//! Means over the pixels around that look alike, in tiles that fit into the cache of a core.

use super::super::Progress;
use super::planes::{Guides, Light, PATCH, Plane, REACH, Size};
use crate::simd::widest;
use fearless_simd::Level;
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Largest size of a tile.
const TILE: Size = Size { width: 64, height: 16 };
/// The same with the patches around its pixels.
const OUTER: Size = Size { width: TILE.width + 2 * PATCH, height: TILE.height + 2 * PATCH };

/// How many candidates there are. Differences between pixels count against the noise of 2, 1 and ½ standard deviations.
pub(super) const COUNT: usize = 3;
const LARGEST: f32 = 2.0;

/// Values of a tile.
type Tile = [[f32; TILE.width]; TILE.height];
/// The same with patches.
type OuterTile = [[f32; OUTER.width]; OUTER.height];

/// Filtered pictures, and what the halves say of their errors.
pub(super) struct Candidates(Vec<[Candidate; COUNT]>);

/// One pixel, filtered in one way.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Candidate {
    pub light: [f32; 3],
    /// An estimate, without bias, of the squared error: very noisy, and negative half of the time where there is none.
    pub error: f32,
}

impl Candidates {
    pub fn get(&self, pixel: usize) -> &[Candidate; COUNT] {
        &self.0[pixel]
    }

    /// The second one alone.
    pub fn middle(&self) -> Vec<[f32; 3]> {
        self.0.iter().map(|c| c[1].light).collect()
    }
}

/// Sums of one half with the weights of the other.
#[derive(Clone)]
struct Sums {
    weight: [Tile; COUNT],
    light: [[Tile; 3]; COUNT],
}

impl Sums {
    const ZERO: Tile = [[0.0; TILE.width]; TILE.height];
    const NONE: Self = Self { weight: [Self::ZERO; COUNT], light: [[Self::ZERO; 3]; COUNT] };
}

/// Filters a layer in every way.
pub(super) fn candidates(guides: &Guides, light: &Light, progress: Progress) -> Candidates {
    let Size { width, height } = guides.size;
    let mut pixels = vec![[Candidate::default(); COUNT]; width * height];
    let (level, done) = (Level::new(), AtomicUsize::new(0));
    pixels.par_chunks_mut(width * TILE.height).enumerate().for_each(|(band, rows)| {
        let mut work = Box::new(Work::new());
        for x in (0..width).step_by(TILE.width) {
            let at = [x, band * TILE.height];
            let size = Size { width: TILE.width.min(width - x), height: rows.len() / width };
            widest(
                level,
                #[inline(always)]
                || work.tile(guides, light, at, size),
            );
            work.finish(light, at, size, |column, row, candidates| rows[row * width + x + column] = candidates);
        }
        let rows = rows.len() / width;
        progress((done.fetch_add(rows, Ordering::Relaxed) + rows) as f64 / height as f64);
    });
    Candidates(pixels)
}

/// What a thread works with.
struct Work {
    sums: [Sums; 2],
    /// Differences of the halves, between pixels and then summed down the patches.
    differences: [OuterTile; 2],
    column: [OuterTile; 2],
    /// Weights by albedo and normal.
    guided: Tile,
}

impl Work {
    fn new() -> Self {
        let outer = [[[0.0; OUTER.width]; OUTER.height]; 2];
        Self { sums: [Sums::NONE, Sums::NONE], differences: outer, column: outer, guided: Sums::ZERO }
    }

    /// Sums over all neighbours.
    #[inline(always)]
    fn tile(&mut self, guides: &Guides, light: &Light, at: [usize; 2], size: Size) {
        self.sums = [Sums::NONE, Sums::NONE];
        let reach = REACH as isize;
        for dy in -reach..=reach {
            for dx in -reach..=reach {
                self.guide(guides, at, [dx, dy], size);
                self.compare(light, at, [dx, dy], size);
                self.add(light, at, [dx, dy], size);
            }
        }
    }

    /// Weights by the guides; none outside of the picture.
    #[inline(always)]
    fn guide(&mut self, guides: &Guides, at: [usize; 2], offset: [isize; 2], size: Size) {
        for (row, weights) in self.guided.iter_mut().enumerate().take(size.height) {
            let (x, y) = (at[0] as isize, (at[1] + row) as isize);
            let mut far = [0.0; TILE.width];
            for plane in &guides.planes {
                let (here, there) = both(plane, [x, y], offset, size.width);
                for ((far, p), q) in far.iter_mut().zip(here).zip(there) {
                    *far += (p - q) * (p - q);
                }
            }
            let inside = guides.inside.row(x + offset[0], y + offset[1], size.width);
            for ((weight, far), inside) in weights.iter_mut().zip(far).zip(inside) {
                *weight = inside * falling(far);
            }
        }
    }

    /// Differences of the light in units of its noise, of both halves.
    #[inline(always)]
    fn compare(&mut self, light: &Light, at: [usize; 2], offset: [isize; 2], size: Size) {
        let (width, patch) = (size.width + 2 * PATCH, PATCH as isize);
        let [first, second] = &mut self.differences;
        for (row, (first, second)) in first.iter_mut().zip(second).enumerate().take(size.height + 2 * PATCH) {
            let place = [at[0] as isize - patch, (at[1] + row) as isize - patch];
            first.fill(0.0);
            second.fill(0.0);
            for channel in 0..3 {
                let (v, w) = both(&light.variance[channel], place, offset, width);
                let (a, b) = both(&light.halves[0][channel], place, offset, width);
                let (c, d) = both(&light.halves[1][channel], place, offset, width);
                for x in 0..width {
                    let noise = v[x] + v[x].min(w[x]);
                    let unit = 1.0 / (3.0 * (light.least + LARGEST * LARGEST * (v[x] + w[x])));
                    first[x] += ((a[x] - b[x]) * (a[x] - b[x]) - noise) * unit;
                    second[x] += ((c[x] - d[x]) * (c[x] - d[x]) - noise) * unit;
                }
            }
        }
        for (differences, column) in self.differences.iter().zip(&mut self.column) {
            for (row, sums) in column.iter_mut().enumerate().take(size.height) {
                *sums = differences[row];
                for other in &differences[row + 1..=row + 2 * PATCH] {
                    for (sum, other) in sums.iter_mut().zip(other) {
                        *sum += other;
                    }
                }
            }
        }
    }

    /// Adds the neighbours: each half with the weights of the other.
    #[inline(always)]
    fn add(&mut self, light: &Light, at: [usize; 2], [dx, dy]: [isize; 2], size: Size) {
        const AREA: f32 = ((2 * PATCH + 1) * (2 * PATCH + 1)) as f32;
        for half in 0..2 {
            let Sums { weight: weights, light: sums } = &mut self.sums[half];
            for row in 0..size.height {
                let place = [at[0] as isize + dx, (at[1] + row) as isize + dy];
                let (column, guided) = (&self.column[half][row], &self.guided[row]);
                let mut powers = [[0.0; TILE.width]; COUNT];
                for x in 0..size.width {
                    let difference: f32 = column[x..=x + 2 * PATCH].iter().sum();
                    let alike = falling((difference / AREA).max(0.0));
                    // Half the noise is a power of four of the weight.
                    let fourth = (alike * alike) * (alike * alike);
                    powers[0][x] = guided[x] * alike;
                    powers[1][x] = guided[x] * fourth;
                    powers[2][x] = guided[x] * (fourth * fourth) * (fourth * fourth);
                }
                let [r, g, b] = [0, 1, 2].map(|c| light.halves[1 - half][c].row(place[0], place[1], size.width));
                for ((powers, weights), sums) in powers.iter().zip(weights.iter_mut()).zip(sums.iter_mut()) {
                    let [red, green, blue] = sums;
                    let (weights, red, green, blue) =
                        (&mut weights[row], &mut red[row], &mut green[row], &mut blue[row]);
                    for x in 0..size.width {
                        weights[x] += powers[x];
                        red[x] += powers[x] * r[x];
                        green[x] += powers[x] * g[x];
                        blue[x] += powers[x] * b[x];
                    }
                }
            }
        }
    }

    /// Means, and the errors that the halves tell: a half has the noise of its own and the error of the other's mean.
    fn finish(
        &self,
        light: &Light,
        at: [usize; 2],
        size: Size,
        mut take: impl FnMut(usize, usize, [Candidate; COUNT]),
    ) {
        for row in 0..size.height {
            let (x, y) = (at[0] as isize, (at[1] + row) as isize);
            let halves = light.halves.each_ref().map(|half| half.each_ref().map(|c| c.row(x, y, size.width)));
            for column in 0..size.width {
                let candidate = |k: usize| {
                    let mut found = Candidate::default();
                    for channel in 0..3 {
                        let own = [halves[0][channel][column], halves[1][channel][column]];
                        let mean = |half: usize| {
                            let Sums { weight, light } = &self.sums[half];
                            light[k][channel][row][column] / weight[k][row][column].max(f32::MIN_POSITIVE)
                        };
                        let means = [mean(0), mean(1)];
                        found.light[channel] = 0.5 * (means[0] + means[1]);
                        let apart = [means[0] - own[0], means[1] - own[1], own[0] - own[1]].map(|d| d * d);
                        found.error += 0.5 * (apart[0] + apart[1] - apart[2]);
                    }
                    found
                };
                take(column, row, [0, 1, 2].map(candidate));
            }
        }
    }
}

/// A row of a plane, and the one at an offset.
#[inline(always)]
fn both(plane: &Plane, [x, y]: [isize; 2], [dx, dy]: [isize; 2], count: usize) -> (&[f32], &[f32]) {
    (plane.row(x, y, count), plane.row(x + dx, y + dy, count))
}

/// Nearly exp(−x), x ≥ 0, the same on every machine: (1 − x/64)⁶⁴, 0 from 64 on.
#[inline(always)]
fn falling(x: f32) -> f32 {
    let mut y = (1.0 - x * (1.0 / 64.0)).max(0.0);
    for _ in 0..6 {
        y *= y;
    }
    y
}
