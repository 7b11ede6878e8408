//! Image-based light from infinity, chosen in proportion to its brightness.

use crate::math::{atan2, sin_cos_turn};
use crate::scene::{EnvironmentMap, Rgb, Rows};
use crate::simd::prefetch;
use core::f32::consts::{PI, TAU};
use glam::{Vec2, Vec3A};
use rayon::prelude::*;

impl EnvironmentMap {
    /// Coordinates of a direction of the world, and the sine of its angle to the pole.
    #[inline(always)]
    fn uv(&self, d: Vec3A) -> (Vec2, f32) {
        let local = self.to_world.transpose() * d;
        let u = atan2(local.x, -local.z) * (1.0 / TAU);
        let sin = (local.x * local.x + local.z * local.z).sqrt();
        (Vec2::new(if u < 0.0 { u + 1.0 } else { u }, atan2(sin, local.y) * (1.0 / PI)), sin)
    }

    /// Radiance from the unit direction `d`: bilinear, periodic in u, the first and last row being the poles.
    #[inline]
    pub fn radiance(&self, d: Vec3A) -> Rgb {
        self.radiance_at(self.uv(d).0)
    }

    #[inline(always)]
    fn radiance_at(&self, uv: Vec2) -> Rgb {
        let (w, h) = (self.image.width as usize, self.image.height as usize);
        let row = match self.rows {
            Rows::Poles => uv.y * (h - 1) as f32,
            Rows::Bands => (uv.y * h as f32 - 0.5).clamp(0.0, (h - 1) as f32),
        };
        let p = Vec2::new(uv.x * w as f32 - 0.5, row);
        let f = p - p.floor();
        let (x0, y0) = (p.x.floor() as i32, p.y as usize);
        let x = [x0, x0 + 1].map(|x| {
            if x < 0 {
                w - 1
            } else if x >= w as i32 {
                0
            } else {
                x as usize
            }
        });
        let y = [y0.min(h - 1) * w, (y0 + 1).min(h - 1) * w];
        let row = |y: usize| self.image.texels.get(y + x[0]).lerp(self.image.texels.get(y + x[1]), f.x);
        row(y[0]).lerp(row(y[1]), f.y) * self.scale
    }
}

/// Rows of cumulated weights, each of which inverts a number of the unit interval.
///
/// A map that is larger than the caches costs what it takes to fetch from memory. A row's blocks are told apart by their first
/// values, which stand close together; what is fetched for a sample is one block of [`BLOCK`] values.
#[derive(Clone, Debug)]
struct Cdfs {
    /// Of each row n + 1 values from 0 to 1, then infinity up to the end of the block.
    cumulated: Vec<f32>,
    /// Of each row the first value of every block.
    first: Vec<f32>,
    /// Number of intervals.
    n: usize,
    /// Blocks of a row.
    blocks: usize,
}

/// Values of a block: a line of the cache.
const BLOCK: usize = 16;

/// How many values are u at most. Counting has no branch whose outcome no processor could foresee.
#[inline(always)]
fn at_most(values: &[f32], u: f32) -> usize {
    values.iter().map(|&c| u32::from(c <= u)).sum::<u32>() as usize
}

/// Where a sample of a map lies, as far as that is known without a look at more than the beginnings of blocks.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Place {
    row: usize,
    /// Position inside of the row.
    down: f32,
    block: usize,
    /// Which part of the row.
    across: f32,
}

impl Cdfs {
    /// Rows of `n` weights each; also returns the sum of each row. A row without weight is even.
    fn new(n: usize, rows: usize, weight: impl Fn(usize, usize) -> f64 + Sync) -> (Self, Vec<f64>) {
        let blocks = (n + 1).div_ceil(BLOCK);
        let row = |row| {
            let weights: Vec<f64> = (0..n).map(|i| weight(row, i)).collect();
            let total: f64 = weights.iter().sum();
            let mut sum = 0.0;
            let mut cumulated = vec![f32::INFINITY; blocks * BLOCK];
            for (i, (c, w)) in cumulated.iter_mut().zip(&weights).enumerate() {
                *c = if total > 0.0 { sum / total } else { i as f64 / n as f64 } as f32;
                sum += w;
            }
            cumulated[n] = 1.0;
            (cumulated, total)
        };
        let (cumulated, sums): (Vec<_>, Vec<_>) = (0..rows).into_par_iter().map(row).unzip();
        let cumulated = cumulated.concat();
        let first = cumulated.iter().copied().step_by(BLOCK).collect();
        (Self { cumulated, first, n, blocks }, sums)
    }

    /// Interval of a row that holds u, and the position of u inside it.
    #[inline(always)]
    fn sample(&self, row: usize, u: f32) -> (usize, f32) {
        self.sample_in(row, self.block(row, u), u)
    }

    /// Block of a row that holds u.
    #[inline(always)]
    fn block(&self, row: usize, u: f32) -> usize {
        at_most(&self.first[row * self.blocks..][..self.blocks], u).max(1) - 1
    }

    /// [`Cdfs::sample`], given the block.
    #[inline(always)]
    fn sample_in(&self, row: usize, block: usize, u: f32) -> (usize, f32) {
        let cumulated = &self.cumulated[row * self.blocks * BLOCK..][..self.blocks * BLOCK];
        let i = (block * BLOCK + at_most(&cumulated[block * BLOCK..][..BLOCK], u).max(1) - 1).min(self.n - 1);
        let width = cumulated[i + 1] - cumulated[i];
        (i, if width > 0.0 { ((u - cumulated[i]) / width).clamp(0.0, 1.0 - f32::EPSILON) } else { 0.5 })
    }

    /// Probability of interval `i` of a row.
    #[inline(always)]
    fn probability(&self, row: usize, i: usize) -> f32 {
        let at = row * self.blocks * BLOCK + i;
        self.cumulated[at + 1] - self.cumulated[at]
    }
}

/// Chooses a cell (a texel across, and down a band or what lies between two rows) by its mean brightness, that of the interpolated image so that
/// no light is out of reach, times the solid angle; then a point of the cell.
#[derive(Clone, Debug)]
pub(super) struct MapSampler {
    /// One row: which row of cells.
    rows: Cdfs,
    /// Which cell of a row.
    columns: Cdfs,
    /// Cells across and down.
    size: [usize; 2],
}

impl MapSampler {
    pub fn new(map: &EnvironmentMap) -> Self {
        let (w, h) = (map.image.width as usize, map.image.height as usize);
        let brightness = |x: usize, y: usize| {
            let c = map.image.texels.get(y * w + x);
            f64::from((c.x + c.y + c.z).max(0.0))
        };
        // The mean of a bilinear function over a texel weighs the neighbours by 1/8, 6/8, 1/8.
        let across = |x: usize, y: usize| {
            0.125 * (brightness((x + w - 1) % w, y) + brightness((x + 1) % w, y)) + 0.75 * brightness(x, y)
        };
        let cell = |x: usize, y: usize| match map.rows {
            Rows::Poles => 0.5 * (across(x, y) + across(x, (y + 1).min(h - 1))),
            Rows::Bands => {
                0.125 * (across(x, y.saturating_sub(1)) + across(x, (y + 1).min(h - 1))) + 0.75 * across(x, y)
            }
        };
        let n = match map.rows {
            Rows::Poles => (h - 1).max(1),
            Rows::Bands => h,
        };
        let (columns, sums) = Cdfs::new(w, n, |y, x| cell(x, y));
        let sine = |y: usize| (core::f64::consts::PI * (y as f64 + 0.5) / n as f64).sin();
        let rows = Cdfs::new(n, 1, |_, y: usize| sums[y] * sine(y)).0;
        Self { rows, columns, size: [w, n] }
    }

    /// Where the sample of two numbers of the unit interval lies; begins to fetch what [`MapSampler::sample`] reads.
    #[inline(always)]
    pub fn place(&self, u: Vec2) -> Place {
        let (row, down) = self.rows.sample(0, u.y);
        let block = self.columns.block(row, u.x);
        prefetch(&self.columns.cumulated[(row * self.columns.blocks + block) * BLOCK]);
        Place { row, down, block, across: u.x }
    }

    /// A direction of the world, its density in sr⁻¹, and the radiance from there.
    #[inline(always)]
    pub fn sample(&self, map: &EnvironmentMap, place: &Place) -> (Vec3A, f32, Rgb) {
        let (y, fy) = (place.row, place.down);
        let (x, fx) = self.columns.sample_in(y, place.block, place.across);
        let [w, h] = self.size;
        let uv = Vec2::new((x as f32 + fx) / w as f32, (y as f32 + fy) / h as f32);
        let (sin_phi, cos_phi) = sin_cos_turn(uv.x);
        let (sin, cos) = sin_cos_turn(0.5 * uv.y);
        let d = map.to_world * Vec3A::new(sin * sin_phi, cos, -sin * cos_phi);
        (d, self.density(x, y, sin), map.radiance_at(uv))
    }

    #[inline(always)]
    fn density(&self, x: usize, y: usize, sin: f32) -> f32 {
        let cells = (self.size[0] * self.size[1]) as f32;
        self.rows.probability(0, y) * self.columns.probability(y, x) * cells / (TAU * PI * sin.max(1e-6))
    }

    /// Radiance from a direction of the world, and its density in sr⁻¹.
    #[inline(always)]
    pub fn look_up(&self, map: &EnvironmentMap, d: Vec3A) -> (Rgb, f32) {
        let (uv, sin) = map.uv(d);
        let [w, h] = self.size;
        let x = ((uv.x * w as f32) as usize).min(w - 1);
        let y = ((uv.y * h as f32) as usize).min(h - 1);
        (map.radiance_at(uv), self.density(x, y, sin))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Bitmap, Interpolation, Texels, Wrap};
    use glam::{Affine2, Mat3A};

    fn map(rows: Rows) -> EnvironmentMap {
        let (w, h) = (16, 8);
        let texels = (0..w * h).map(|i| if i == 37 { 500.0 } else { (i % 7) as f32 }).collect();
        EnvironmentMap {
            image: Bitmap {
                width: w,
                height: h,
                texels: Texels::Gray(texels),
                wrap: [Wrap::Repeat; 2],
                second_uv: false,
                interpolation: Interpolation::Bilinear,
                to_uv: Affine2::IDENTITY,
            },
            to_world: Mat3A::from_rotation_x(0.7),
            scale: 2.0,
            rows,
        }
    }

    #[test]
    fn samples_have_the_density_they_state_and_integrate_the_map() {
        [Rows::Poles, Rows::Bands].into_iter().for_each(agrees);
    }

    fn agrees(rows: Rows) {
        let map = map(rows);
        let sampler = MapSampler::new(&map);
        let n = 1 << 17;
        let (mut estimate, mut plain, mut mass) = (0.0f64, 0.0f64, 0.0f64);
        let (mut disagree, sphere) = (0, 4.0 * core::f64::consts::PI);
        for i in 0..n {
            let u = crate::sampler::Sampler::new(0, (0, 0), i).next_2d();
            let (d, pdf, radiance) = sampler.sample(&map, &sampler.place(u));
            let (found, found_pdf) = sampler.look_up(&map, d);
            disagree += u32::from((pdf - found_pdf).abs() > 1e-3 * pdf);
            disagree += u32::from((radiance - found).length() > 1e-2 * found.length());
            estimate += f64::from(radiance.x / pdf);
            let d = crate::frame::uniform_sphere(u);
            plain += f64::from(map.radiance(d).x) * sphere;
            mass += f64::from(sampler.look_up(&map, d).1) * sphere;
        }
        assert!(disagree < 100, "{disagree}"); // rounding puts a few points into the next texel
        let count = f64::from(n);
        assert!((mass / count - 1.0).abs() < 2e-3, "{}", mass / count);
        assert!((estimate / plain - 1.0).abs() < 2e-3, "{estimate} {plain}");
    }
    /// Bands: the value of a texel at its middle, and of the first and the last row as far as the poles.
    #[test]
    fn rows_are_bands_of_their_own() {
        let map = EnvironmentMap { to_world: Mat3A::IDENTITY, scale: 1.0, ..map(Rows::Bands) };
        for y in 0..8 {
            let texel = map.image.texels.get(y * 16 + 8).x;
            let uv = |v: f32| Vec2::new(8.5 / 16.0, v / 8.0);
            assert!((map.radiance_at(uv(y as f32 + 0.5)).x - texel).abs() < 1e-3, "{y}");
            if y == 0 || y == 7 {
                assert!((map.radiance_at(uv(if y == 0 { 0.0 } else { 8.0 })).x - texel).abs() < 1e-3, "{y}");
            }
        }
    }
}
