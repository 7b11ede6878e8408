//! Whether two pictures differ by more than their noise.

use super::SizeMismatch;
use crate::image::Image;
use serde::Serialize;

/// Differences in standard errors (z), of a set of places.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ZScores {
    /// Number of places.
    pub count: usize,
    /// Mean; 0 without bias.
    pub mean: f64,
    /// Standard deviation; at most 1 if the variance is not underestimated.
    pub deviation: f64,
    /// Share beyond 3; 0.0027 for normal numbers.
    pub beyond_3: f64,
    /// Largest absolute value.
    pub max: f64,
    /// What [`ZScores::max`] of normal numbers passes in one comparison of a hundred (Šidák 1967).
    pub limit: f64,
    /// The relative bias of a single place that reaches the limit: [`ZScores::limit`] standard errors over the
    /// reference's mean, the median of all places. A smaller one is found if it is shared by many places.
    pub finds: f64,
}

/// A pixel or a square of pixels: sums over its pixels.
#[derive(Clone, Copy)]
struct Place {
    difference: f64,
    variance: f64,
    /// Mean of the reference.
    level: f64,
}

/// The comparison of two pictures by pixels and, for a smaller bias of a larger part, by squares of pixels.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ZTest {
    /// Every pixel.
    pub pixels: ZScores,
    /// Squares of [`BLOCK`]² pixels.
    pub blocks: ZScores,
    /// Squares of [`TILE`]² pixels.
    pub tiles: ZScores,
    /// The picture as one place.
    pub whole: ZScores,
}

/// Pixels along a block's side.
pub const BLOCK: usize = 8;

/// Pixels along a tile's side.
pub const TILE: usize = 32;

/// Share of normal numbers beyond 3 standard deviations.
const NORMAL_BEYOND_3: f64 = 0.0027;

/// Probability with which equal pictures fail.
const LEVEL: f64 = 0.01;

/// Relative error of a mean summed in f32, and of the other renderer's.
const ROUNDING: f64 = 3e-5;

/// Half side of the window over which the variance is pooled.
const WINDOW: usize = 2;

impl ZScores {
    fn of(places: &[Place]) -> Self {
        let score = |p: &Place| if p.variance > 0.0 { p.difference / p.variance.sqrt() } else { p.difference };
        let z: Vec<f64> = places.iter().map(score).collect();
        let n = z.len().max(1) as f64;
        let mean = z.iter().sum::<f64>() / n;
        let limit = two_sided_quantile(1.0 - (1.0 - LEVEL).powf(1.0 / n));
        let mut errors: Vec<f64> =
            places.iter().filter(|p| p.level > 0.0).map(|p| p.variance.sqrt() / p.level).collect();
        errors.sort_unstable_by(f64::total_cmp);
        Self {
            count: z.len(),
            mean,
            deviation: (z.iter().map(|z| (z - mean).powi(2)).sum::<f64>() / n).sqrt(),
            beyond_3: z.iter().filter(|z| z.abs() > 3.0).count() as f64 / n,
            max: z.iter().fold(0.0, |max, z| max.max(z.abs())),
            limit,
            finds: limit * errors.get(errors.len() / 2).copied().unwrap_or(0.0),
        }
    }

    /// Whether the scores are no wider than normal ones: the largest within the limit, and beyond 3 no more than the
    /// normal share and three of its standard errors.
    pub fn passed(&self) -> bool {
        let n = self.count.max(1) as f64;
        self.max <= self.limit && self.beyond_3 <= NORMAL_BEYOND_3 + 3.0 * (NORMAL_BEYOND_3 / n).sqrt()
    }
}

impl ZTest {
    /// Whether every scale passes.
    pub fn passed(&self) -> bool {
        [self.pixels, self.blocks, self.tiles, self.whole].iter().all(ZScores::passed)
    }
}

/// Compares the channels' means of two pictures. The reference's variance is `share` times that of the image: the
/// ratio of their samples per pixel, or 0 where it has no noise.
///
/// A pixel that by chance missed a rare bright path also underestimates its own variance; so the larger of its own and
/// the mean over its neighbourhood counts.
///
/// # Errors
/// Pictures of different sizes.
pub fn z_test(image: &Image, noise: &Image, reference: &Image, share: f64) -> Result<ZTest, SizeMismatch> {
    let size = (image.width, image.height);
    for other in [reference, noise] {
        if size != (other.width, other.height) {
            return Err(SizeMismatch(size, (other.width, other.height)));
        }
    }
    let (w, h) = (size.0 as usize, size.1 as usize);
    let mean = |p: &[f32; 3]| p.iter().map(|x| f64::from(*x)).sum::<f64>() / 3.0;
    let difference: Vec<f64> = image.pixels.iter().zip(&reference.pixels).map(|(a, b)| mean(a) - mean(b)).collect();
    // The channels of a path vary together: the variance of their mean is at most the mean of their variances.
    let own: Vec<f64> = noise.pixels.iter().map(|v| (1.0 + share) * mean(v).max(0.0)).collect();
    let level: Vec<f64> = reference.pixels.iter().map(mean).collect();
    let rounding: Vec<f64> = level.iter().map(|m| (ROUNDING * m).powi(2)).collect();
    let pixel = |i: usize| {
        let (x, y) = (i % w, i / w);
        let rows = y.saturating_sub(WINDOW)..(y + WINDOW + 1).min(h);
        let columns = x.saturating_sub(WINDOW)..(x + WINDOW + 1).min(w);
        let count = (rows.len() * columns.len()) as f64;
        let pooled = rows.map(|y| own[y * w..][columns.clone()].iter().sum::<f64>()).sum::<f64>() / count;
        Place { difference: difference[i], variance: own[i].max(pooled) + rounding[i], level: level[i] }
    };
    let squares = |side: usize| {
        let mut places = Vec::new();
        for y in (0..h).step_by(side) {
            for x in (0..w).step_by(side) {
                let rows = y..(y + side).min(h);
                let columns = x..(x + side).min(w);
                let sum = |values: &[f64]| -> f64 {
                    rows.clone().map(|y| values[y * w..][columns.clone()].iter().sum::<f64>()).sum()
                };
                // Rounding is alike in all pixels: its errors add up, those of noise partly cancel.
                let count = (rows.len() * columns.len()) as f64;
                let variance = sum(&own) + count * sum(&rounding);
                places.push(Place { difference: sum(&difference), variance, level: sum(&level) });
            }
        }
        ZScores::of(&places)
    };
    let pixels: Vec<Place> = (0..w * h).map(pixel).collect();
    let whole = squares(w.max(h).max(1));
    Ok(ZTest { pixels: ZScores::of(&pixels), blocks: squares(BLOCK), tiles: squares(TILE), whole })
}

/// The z beyond which, on both sides, lies the share `p` of the normal distribution: bisection on [`two_sided_tail`].
fn two_sided_quantile(p: f64) -> f64 {
    let (mut low, mut high) = (0.0, 40.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if two_sided_tail(middle) > p { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// Share of the normal distribution beyond ±z: the continued fraction of erfc, or its series near 0.
fn two_sided_tail(z: f64) -> f64 {
    let density = (-0.5 * z * z).exp() * (2.0 / core::f64::consts::PI).sqrt();
    if z > 2.0 {
        let fraction = (1..=60).rev().fold(0.0, |f, k| f64::from(k) / (z + f));
        return density / (z + fraction);
    }
    let (mut term, mut sum) = (z, z);
    for k in 1..60 {
        term *= z * z / f64::from(2 * k + 1);
        sum += term;
    }
    1.0 - density * sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    #[test]
    fn quantiles_of_the_normal_distribution() {
        for (p, z) in [(0.317_310_507, 1.0), (0.045_500_264, 2.0), (0.002_699_796, 3.0), (5.733e-7, 5.0)] {
            assert!((two_sided_quantile(p) - z).abs() < 1e-4, "{p}: {}", two_sided_quantile(p));
        }
    }

    /// Grey noise of the given standard deviation about 1 + `bias(x, y)`, of 64 × 64 pixels times `scale`².
    fn picture(scale: u32, bias: impl Fn(u32, u32) -> f64, deviation: f64, seed: u64) -> Image {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
        let mut normal = || (0..12).map(|_| rng.random::<f64>()).sum::<f64>() - 6.0;
        let side = 64 * scale;
        let pixel = |i: u32| [(1.0 + bias(i % side, i / side) + deviation * normal()) as f32; 3];
        Image { width: side, height: side, pixels: (0..side * side).map(pixel).collect() }
    }

    #[test]
    fn noise_passes_and_a_bias_does_not() {
        let (s, share) = (0.1f64, 0.25f64);
        let noise = Image { width: 64, height: 64, pixels: vec![[(s * s) as f32; 3]; 64 * 64] };
        let reference = picture(1, |_, _| 0.0, s * share.sqrt(), 1);
        let test = |image: &Image| z_test(image, &noise, &reference, share).unwrap();
        let equal = test(&picture(1, |_, _| 0.0, s, 2));
        assert!(equal.passed() && (equal.pixels.deviation - 1.0).abs() < 0.05, "{equal:?}");
        // Half a standard deviation shows in blocks, three in pixels; so does twice the noise.
        assert!(!test(&picture(1, |_, _| 0.5 * s, s, 2)).blocks.passed());
        assert!(!test(&picture(1, |_, _| 3.0 * s, s, 2)).pixels.passed());
        assert!(!test(&picture(1, |_, _| 0.0, 2.0 * s, 2)).pixels.passed());
        let mut one = picture(1, |_, _| 0.0, s, 2);
        one.pixels[100] = [2.0; 3];
        assert!(!test(&one).pixels.passed());
    }

    /// The power of the test, at 3.5 % of noise in a pixel and an eighth of its variance in the reference: a bias of a
    /// region, and of an object that does not lie on the grid of the squares, is found from a known size on.
    #[test]
    fn the_smallest_bias_that_is_found() {
        let (s, share) = (0.035f64, 0.125f64);
        let noise = Image { width: 256, height: 256, pixels: vec![[(s * s) as f32; 3]; 256 * 256] };
        let test = |bias: &dyn Fn(u32, u32) -> f64, seed: u64| {
            let reference = picture(4, |_, _| 0.0, s * share.sqrt(), 100 + seed);
            z_test(&picture(4, bias, s, seed), &noise, &reference, share).unwrap()
        };
        let region = |bias: f64| move |x: u32, y: u32| if x < 64 && y >= 192 { bias } else { 0.0 };
        let object =
            |bias: f64| move |x: u32, y: u32| if (99..146).contains(&x) && (75..185).contains(&y) { bias } else { 0.0 };
        let found = |bias: &dyn Fn(u32, u32) -> f64| (0..8).filter(|&seed| !test(bias, seed).passed()).count();
        assert!(found(&|_, _| 0.0) <= 1);
        assert_eq!((found(&region(0.007)), found(&object(0.01))), (8, 8));
        assert!(found(&region(0.001)) <= 1 && found(&object(0.001)) <= 1);
        let tiles = test(&|_, _| 0.0, 0).tiles;
        let error = s * (1.0 + share).sqrt() / TILE as f64;
        let whole = test(&|_, _| 0.0005, 0).whole;
        assert!(whole.count == 1 && !whole.passed() && whole.finds < 0.0005, "{whole:?}");
        assert!((tiles.finds / (tiles.limit * error) - 1.0).abs() < 0.01 && tiles.finds < 0.005, "{tiles:?}");
    }
}
