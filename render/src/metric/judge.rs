//! Which of two pictures is nearer to a truth that nobody has, told by a noisy picture.
//!
//! (a − t)² − (b − t)² = (a − b)(a + b − 2t) is linear in the truth t: a picture in its place that is right in the mean, and whose noise
//! knows nothing of a and b, leaves the mean of the difference as it is. What noise it brings is scaled by a − b, which is
//! small between pictures that are denoised: few samples tell them apart.

use super::SizeMismatch;
use crate::image::Image;
use std::cmp::Ordering;

/// Side of the squares of pixels whose means are taken to be independent: what a denoiser leaves of noise is correlated over some pixels.
const SQUARE: usize = 8;
/// Deviations that a difference must have to be told.
const CERTAIN: f64 = 2.0;

/// How much further one picture is from the truth than another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Verdict {
    /// `rel_mse` of the first less that of the second.
    pub difference: f64,
    /// Standard deviation of that.
    pub deviation: f64,
}

impl Verdict {
    /// Of pictures `a` and `b`, by a third that is unbiased and independent of both.
    ///
    /// # Errors
    /// Pictures of different sizes.
    pub fn of([a, b]: [&Image; 2], unbiased: &Image) -> Result<Self, SizeMismatch> {
        super::same_size(a, b)?;
        super::same_size(a, unbiased)?;
        let (width, height) = (a.width as usize, a.height as usize);
        let across = width.div_ceil(SQUARE);
        let mut squares = vec![(0.0, 0.0); across * height.div_ceil(SQUARE)];
        for (i, ((a, b), t)) in a.pixels.iter().zip(&b.pixels).zip(&unbiased.pixels).enumerate() {
            let square = &mut squares[i / width / SQUARE * across + i % width / SQUARE];
            square.0 += (0..3).map(|c| further([a[c], b[c], t[c]].map(f64::from))).sum::<f64>();
            square.1 += 3.0;
        }
        let all: f64 = squares.iter().map(|(_, count)| count).sum();
        let difference = squares.iter().map(|(sum, _)| sum).sum::<f64>() / all.max(1.0);
        let variance: f64 = squares.iter().map(|(sum, count)| (sum - count * difference).powi(2)).sum();
        Ok(Self { difference, deviation: variance.sqrt() / all.max(1.0) })
    }

    /// Whether the first is nearer (less) or further (greater); `None` where that cannot be told.
    pub fn order(&self) -> Option<Ordering> {
        (self.difference.abs() > CERTAIN * self.deviation).then(|| self.difference.total_cmp(&0.0))
    }
}

/// How much further `a` is from `t` than `b`, as squares over what errors are divided by.
fn further([a, b, t]: [f64; 3]) -> f64 {
    let mean = 0.5 * (a + b);
    (a - b) * (a + b - 2.0 * t) / (mean * mean + 0.01)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::Sampler;

    /// A picture of a ramp with noise of a deviation about it.
    fn noisy(seed: u64, deviation: f32) -> Image {
        let pixel = |i: u32| {
            let u = Sampler::new(seed, (i, 0), 0).next_2d();
            [0.5 + i as f32 * 1e-4 + deviation * 6f32.sqrt() * (u.x + u.y - 1.0); 3]
        };
        Image { width: 125, height: 81, pixels: (0..125 * 81).map(pixel).collect() }
    }

    #[test]
    fn a_noisy_picture_tells_two_better_ones_apart() {
        let (good, bad, judge) = (noisy(1, 0.05), noisy(2, 0.1), noisy(3, 0.5));
        let truth = noisy(0, 0.0);
        let error = |x: &Image| super::super::compare(x, &truth).unwrap().rel_mse;
        let verdict = Verdict::of([&bad, &good], &judge).unwrap();
        let right = error(&bad) - error(&good);
        assert!((verdict.difference - right).abs() < 3.0 * verdict.deviation, "{verdict:?} for {right}");
        assert!(verdict.deviation < 0.25 * right, "{verdict:?}");
        assert_eq!(verdict.order(), Some(Ordering::Greater));
        assert_eq!(Verdict::of([&good, &bad], &judge).unwrap().order(), Some(Ordering::Less));
    }

    #[test]
    fn pictures_as_good_as_each_other_are_not_told_apart() {
        let undecided = |seed: u64| {
            let [a, b] = [2, 3].map(|i| noisy(10 * seed + i, 0.05));
            Verdict::of([&a, &b], &noisy(10 * seed, 0.5)).unwrap().order().is_none()
        };
        assert!((1..21).filter(|seed| undecided(*seed)).count() >= 16);
        let same = noisy(1, 0.1);
        assert_eq!(Verdict::of([&same, &same], &noisy(2, 0.1)).unwrap().order(), None);
    }

    #[test]
    fn pictures_of_different_sizes_are_refused() {
        let small = Image { width: 1, height: 1, pixels: vec![[0.0; 3]] };
        assert!(Verdict::of([&small, &noisy(1, 0.1)], &small).is_err());
    }
}
