//! The best candidate at every pixel.

use super::means::{COUNT, Candidates};
use super::planes::Size;
use rayon::prelude::*;

/// Standard deviations, in pixels, of the Gaussians over which errors are averaged, and choices.
const OF_ERRORS: f32 = 2.0;
const OF_CHOICES: f32 = 1.5;

/// The candidate of the least error at every pixel, by errors averaged around it; passing softly from one to the other.
pub(super) fn best(size: Size, candidates: &Candidates) -> Vec<[f32; 3]> {
    let count = size.width * size.height;
    let errors: Vec<[f32; COUNT]> = (0..count).map(|i| candidates.get(i).map(|c| c.error)).collect();
    let errors = blurred(size, errors, OF_ERRORS);
    let chosen = errors.iter().map(|errors| {
        let least = (1..COUNT).fold(0, |best, k| if errors[k] < errors[best] { k } else { best });
        core::array::from_fn(|k| f32::from(k == least))
    });
    let shares = blurred(size, chosen.collect(), OF_CHOICES);
    let pixel = |(i, shares): (usize, &[f32; COUNT])| {
        let mut light = [0.0; 3];
        for (candidate, share) in candidates.get(i).iter().zip(shares) {
            for (sum, x) in light.iter_mut().zip(candidate.light) {
                *sum += share * x;
            }
        }
        light
    };
    shares.par_iter().enumerate().map(pixel).collect()
}

/// Convolution with a Gaussian, rows and columns in turn; weights sum to one at the borders too.
fn blurred(size: Size, values: Vec<[f32; COUNT]>, deviation: f32) -> Vec<[f32; COUNT]> {
    let reach = (2.5 * deviation).ceil() as usize;
    let weights: Vec<f32> = (0..=reach).map(|d| (-0.5 * (d as f32 / deviation).powi(2)).exp()).collect();
    let mean = |at: usize, end: usize, value: &dyn Fn(usize) -> [f32; COUNT]| {
        let (mut sum, mut all) = ([0.0; COUNT], 0.0);
        for i in at.saturating_sub(reach)..(at + reach + 1).min(end) {
            let weight = weights[i.abs_diff(at)];
            all += weight;
            for (sum, x) in sum.iter_mut().zip(value(i)) {
                *sum += weight * x;
            }
        }
        sum.map(|x| x / all)
    };
    let Size { width, height } = size;
    let row = |i: usize| mean(i % width, width, &|x| values[i / width * width + x]);
    let rows: Vec<_> = (0..width * height).into_par_iter().map(row).collect();
    let column = |i: usize| mean(i / width, height, &|y| rows[y * width + i % width]);
    (0..width * height).into_par_iter().map(column).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_blur_keeps_what_is_even() {
        let size = Size { width: 9, height: 5 };
        let mut values = vec![[1.0, 2.0, 0.0]; 45];
        values[22] = [1.0, 2.0, 1.0];
        let found = blurred(size, values, 1.5);
        assert!(found.iter().all(|v| (v[0] - 1.0).abs() < 1e-6 && (v[1] - 2.0).abs() < 1e-6));
        assert!(found[22][2] > found[21][2] && found[21][2] > 0.0);
    }
}
