//! What a picture is measured against: a reference, or two independent ones.
//!
//! A reference has noise of its own. With e₁ and e₂ the differences from two references whose noises know nothing of each
//! other, the mean of e₁e₂ is the squared error without it: (x − r₁)(x − r₂) = (x − r)² − (r₁ − r₂)²/4, r = (r₁ + r₂)/2.

use super::{Comparison, SizeMismatch, flip};
use crate::image::Image;
use std::borrow::Cow;

/// Share of the pixels that [`Comparison::trimmed`] leaves out.
const TRIMMED: f64 = 0.005;

/// One reference or two, all of one size.
#[derive(Clone, Debug)]
pub struct Truth<'a> {
    references: [&'a Image; 2],
    mean: Cow<'a, Image>,
}

/// A channel of a picture beside its references.
#[derive(Clone, Copy, Debug)]
pub(super) struct Difference {
    /// From each reference.
    pub from: [f64; 2],
    /// Mean of the references.
    pub truth: f64,
}

impl Difference {
    /// What errors are divided by.
    pub fn scale(&self) -> f64 {
        self.truth * self.truth + 0.01
    }

    /// The error itself, noise of the references included.
    fn error(&self) -> f64 {
        0.5 * (self.from[0] + self.from[1])
    }

    /// Its square, without that noise where there are two.
    fn square(&self) -> f64 {
        self.from[0] * self.from[1]
    }
}

impl<'a> Truth<'a> {
    /// A reference alone.
    pub fn one(reference: &'a Image) -> Self {
        Self { references: [reference; 2], mean: Cow::Borrowed(reference) }
    }

    /// Two references of independent noise.
    ///
    /// # Errors
    /// Pictures of different sizes.
    pub fn two(first: &'a Image, second: &'a Image) -> Result<Self, SizeMismatch> {
        same_size(first, second)?;
        let mean = |(a, b): (&[f32; 3], &[f32; 3])| core::array::from_fn(|c| 0.5 * a[c] + 0.5 * b[c]);
        let pixels = first.pixels.iter().zip(&second.pixels).map(mean).collect();
        Ok(Self { references: [first, second], mean: Cow::Owned(Image { pixels, ..*first }) })
    }

    /// The mean of the references.
    pub fn mean(&self) -> &Image {
        &self.mean
    }

    /// The channels of every pixel of a picture.
    pub(super) fn differences(&self, image: &Image) -> Result<impl Iterator<Item = [Difference; 3]>, SizeMismatch> {
        same_size(image, self.references[0])?;
        let [first, second] = self.references;
        Ok(image.pixels.iter().enumerate().map(move |(i, x)| {
            core::array::from_fn(|c| {
                let [x, a, b, truth] =
                    [x[c], first.pixels[i][c], second.pixels[i][c], self.mean.pixels[i][c]].map(f64::from);
                Difference { from: [x - a, x - b], truth }
            })
        }))
    }

    /// Compares a picture with the truth. With two references `rmse`, `rel_mse` and `trimmed` are free of their noise;
    /// `bias`, `max` and `flip` are those against their mean.
    ///
    /// # Errors
    /// Pictures of different sizes.
    pub fn compare(&self, image: &Image) -> Result<Comparison, SizeMismatch> {
        let (mut squares, mut difference, mut total, mut max) = (0.0, 0.0, 0.0, 0f64);
        // Of every pixel what it is ranked by, and its error.
        let mut pixels = Vec::with_capacity(image.pixels.len());
        for channels in self.differences(image)? {
            let (mut rank, mut relative) = (0.0, 0.0);
            for d in channels {
                squares += d.square();
                difference += d.error();
                total += d.truth;
                max = max.max(d.error().abs());
                rank += d.error() * d.error() / d.scale();
                relative += d.square() / d.scale();
            }
            pixels.push((rank, relative));
        }
        let mean = |pixels: &[(f64, f64)]| {
            pixels.iter().map(|(_, error)| error).sum::<f64>() / (3 * pixels.len()).max(1) as f64
        };
        let rel_mse = mean(&pixels);
        // By the difference, not by the error of two references: there, a firefly of one of them counts as a gain.
        pixels.sort_by(|a, b| a.0.total_cmp(&b.0));
        let kept = pixels.len() - (TRIMMED * pixels.len() as f64) as usize;
        Ok(Comparison {
            rmse: (squares.max(0.0) / (3 * pixels.len()).max(1) as f64).sqrt(),
            rel_mse,
            trimmed: mean(&pixels[..kept]),
            bias: if total == 0.0 { difference } else { difference / total },
            max,
            flip: flip(image, &self.mean),
        })
    }
}

pub(super) fn same_size(a: &Image, b: &Image) -> Result<(), SizeMismatch> {
    let (a, b) = ((a.width, a.height), (b.width, b.height));
    if a == b { Ok(()) } else { Err(SizeMismatch(a, b)) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::Sampler;

    /// A picture of noise of a deviation of 0.1 about 1, from two halves of it.
    fn noisy(seed: u64, error: f32) -> Image {
        let pixel = |i: u32| {
            let u = Sampler::new(seed, (i, 0), 0).next_2d();
            [1.0 + error + 0.1 * 6f32.sqrt() * (u.x + u.y - 1.0); 3]
        };
        Image { width: 200, height: 100, pixels: (0..20_000).map(pixel).collect() }
    }

    #[test]
    fn two_references_take_their_noise_off() {
        let (image, first, second) = (noisy(1, 0.05), noisy(2, 0.0), noisy(3, 0.0));
        // Noise and error of the picture; one reference adds its own noise.
        let own = 0.1f64.powi(2) + 0.05f64.powi(2);
        let one = Truth::one(&first).compare(&image).unwrap();
        let two = Truth::two(&first, &second).unwrap().compare(&image).unwrap();
        assert!((one.rmse.powi(2) - own - 0.01).abs() < 5e-4, "{}", one.rmse);
        assert!((two.rmse.powi(2) - own).abs() < 5e-4, "{}", two.rmse);
        assert!((two.bias - 0.05).abs() < 2e-3 && two.trimmed < two.rel_mse, "{two:?}");
    }

    #[test]
    fn the_worst_pixels_are_trimmed() {
        let reference = Image { width: 400, height: 1, pixels: vec![[1.0; 3]; 400] };
        let mut image = reference.clone();
        image.pixels[7] = [101.0; 3];
        image.pixels[9] = [51.0; 3];
        image.pixels[11] = [2.0; 3];
        let found = Truth::one(&reference).compare(&image).unwrap();
        assert!((found.trimmed - 1.0 / 1.01 / 398.0).abs() < 1e-9, "{found:?}");
        // A firefly of a reference is not the picture's gain.
        let mut second = reference.clone();
        second.pixels[13] = [31.0; 3];
        image.pixels[13] = [16.0; 3];
        let found = Truth::two(&reference, &second).unwrap().compare(&image).unwrap();
        assert!(found.trimmed >= 0.0, "{found:?}");
    }
}
