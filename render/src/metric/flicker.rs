//! How errors change from frame to frame: what stays in its place is seen less than what comes and goes.

use super::truth::Difference;
use super::{SizeMismatch, Truth};
use crate::image::Image;

/// Mean over frames, pixels and channels of (e_t − e_{t−1})²/(2 (r_t² + 0.01)), e = frame − reference. Where errors of
/// frames are independent it is their relative error; where they stay, it is 0. With two references (e₁_t − e₁_{t−1})(e₂_t −
/// e₂_{t−1}) stands for the square: their own noise drops out.
#[derive(Clone, Debug, Default)]
pub struct Flicker {
    last: Option<(u32, Vec<[Difference; 3]>)>,
    sum: f64,
    count: u64,
}

impl Flicker {
    /// Adds a frame, after those before it. Only frames whose numbers follow each other are compared. Returns the flicker
    /// from the one before to this one.
    ///
    /// # Errors
    /// Pictures of different sizes.
    pub fn add(&mut self, frame: u32, image: &Image, truth: &Truth) -> Result<Option<f64>, SizeMismatch> {
        let now: Vec<_> = truth.differences(image)?.collect();
        let before =
            self.last.take().filter(|(last, pixels)| last.checked_add(1) == Some(frame) && pixels.len() == now.len());
        let flicker = before.map(|(_, before)| {
            let changed = |(a, b): (&Difference, &Difference)| {
                (b.from[0] - a.from[0]) * (b.from[1] - a.from[1]) / (2.0 * b.scale())
            };
            let sum: f64 = before.as_flattened().iter().zip(now.as_flattened()).map(changed).sum();
            let count = now.as_flattened().len().max(1) as u64;
            self.sum += sum;
            self.count += count;
            sum / count as f64
        });
        self.last = Some((frame, now));
        Ok(flicker)
    }

    /// The mean so far; `None` without two frames that follow each other.
    pub fn mean(&self) -> Option<f64> {
        (self.count > 0).then(|| self.sum / self.count as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn flat(value: f32) -> Image {
        Image { width: 2, height: 1, pixels: vec![[value; 3]; 2] }
    }

    #[test]
    fn what_stays_does_not_flicker() {
        let mut flicker = Flicker::default();
        // Errors of 0.5, 0.5 and 0.7, while the truth moves.
        for (frame, value, truth) in [(1, 1.5, 1.0), (2, 2.5, 2.0), (3, 3.7, 3.0), (9, 1.0, 3.0)] {
            let (image, truth) = (flat(value), flat(truth));
            let step = flicker.add(frame, &image, &Truth::one(&truth)).unwrap();
            assert_eq!(step.is_some(), frame == 2 || frame == 3);
        }
        let expected = 0.5 * 0.2f64.powi(2) / (2.0 * 9.01);
        assert!((flicker.mean().unwrap() - expected).abs() < 1e-7, "{:?}", flicker.mean());
        assert_eq!(Flicker::default().mean(), None);
    }
}
