//! How far a picture is from its reference.

pub mod defects;
mod flicker;
mod judge;
mod truth;
pub mod z_scores;

#[cfg(feature = "flip")]
use crate::image::to_srgb;
use crate::image::{Image, from_srgb};
pub use flicker::Flicker;
pub use judge::Verdict;
use serde::Serialize;
use thiserror::Error;
pub use truth::Truth;
use truth::same_size;

/// Differences of two pictures, linear RGB.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Comparison {
    /// Root mean square error over pixels and channels.
    pub rmse: f64,
    /// Mean over pixels and channels of squared error / (reference² + 0.01).
    pub rel_mse: f64,
    /// The same over the 99.5 % of the pixels that differ least.
    pub trimmed: f64,
    /// Mean difference over the mean of the reference.
    pub bias: f64,
    /// Largest difference of a channel.
    pub max: f64,
    /// Mean ꟻLIP error of the sRGB views, at 67 pixels per degree (Andersson et al. 2020);
    /// `None` in a build without the feature `flip`.
    pub flip: Option<f64>,
}

/// Pictures that cannot be compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("{}×{} pixels against {}×{}", .0.0, .0.1, .1.0, .1.1)]
pub struct SizeMismatch(pub (u32, u32), pub (u32, u32));

/// Compares a picture with its only reference.
///
/// # Errors
/// Pictures of different sizes.
pub fn compare(image: &Image, reference: &Image) -> Result<Comparison, SizeMismatch> {
    Truth::one(reference).compare(image)
}

/// Mean ꟻLIP error of the sRGB views.
#[cfg(feature = "flip")]
fn flip(image: &Image, reference: &Image) -> Option<f64> {
    if image.pixels.is_empty() {
        return Some(0.0);
    }
    let view = |image: &Image| {
        let bytes: Vec<u8> = image.pixels.iter().flatten().map(|x| (255.0 * to_srgb(*x) + 0.5) as u8).collect();
        nv_flip::FlipImageRgb8::with_data(image.width, image.height, &bytes)
    };
    let error = nv_flip::flip(view(reference), view(image), nv_flip::DEFAULT_PIXELS_PER_DEGREE);
    Some(f64::from(nv_flip::FlipPool::from_image(&error).mean()))
}

/// Not in this build.
#[cfg(not(feature = "flip"))]
fn flip(_: &Image, _: &Image) -> Option<f64> {
    None
}

/// Largest relative error the false colours show.
const FULL_SCALE: f32 = 1.0;

/// The error of every pixel in false colours: dark blue 0, green 0.25, yellow, red 1 and more; the error is the root of
/// the channels' mean of squared error / (reference² + 0.01).
///
/// # Errors
/// Pictures of different sizes.
pub fn false_color(image: &Image, reference: &Image) -> Result<Image, SizeMismatch> {
    let (a, b) = ((image.width, image.height), (reference.width, reference.height));
    if a != b {
        return Err(SizeMismatch(a, b));
    }
    let shown = |(x, y): (&[f32; 3], &[f32; 3])| color(pixel_error(x, y) / FULL_SCALE).map(from_srgb);
    let pixels = image.pixels.iter().zip(&reference.pixels).map(shown).collect();
    Ok(Image { pixels, ..*image })
}

/// Root of the channels' mean of squared error / (reference² + 0.01).
fn pixel_error(x: &[f32; 3], y: &[f32; 3]) -> f32 {
    let sum: f32 = (0..3).map(|c| (x[c] - y[c]).powi(2) / (y[c] * y[c] + 0.01)).sum();
    (sum / 3.0).sqrt()
}

/// Colour map of 0 … 1 on the sRGB scale; the square root spreads the small errors.
pub fn color(error: f32) -> [f32; 3] {
    const STOPS: [[f32; 3]; 5] =
        [[0.05, 0.03, 0.3], [0.1, 0.4, 0.7], [0.15, 0.7, 0.35], [0.95, 0.85, 0.2], [0.8, 0.1, 0.1]];
    let x = error.clamp(0.0, 1.0).sqrt() * (STOPS.len() - 1) as f32;
    let i = (x as usize).min(STOPS.len() - 2);
    core::array::from_fn(|c| STOPS[i][c] + (STOPS[i + 1][c] - STOPS[i][c]) * (x - i as f32))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn flat(values: &[f32], width: u32) -> Image {
        let pixels: Vec<_> = values.iter().map(|&v| [v; 3]).collect();
        Image { width, height: pixels.len() as u32 / width, pixels }
    }

    #[test]
    fn figures_by_hand() {
        let (a, b) = (flat(&[1.0, 0.0, 2.0, 0.5], 2), flat(&[1.0, 0.1, 1.0, 0.5], 2));
        let c = compare(&a, &b).unwrap();
        assert!((c.rmse - (1.01f64 / 4.0).sqrt()).abs() < 1e-6);
        assert!((c.rel_mse - (0.01 / 0.02 + 1.0 / 1.01) / 4.0).abs() < 1e-6);
        assert!((c.bias - 0.9 / 2.6).abs() < 1e-6);
        assert!((c.max - 1.0).abs() < 1e-9);
        assert_eq!(c.flip.map(|x| x > 0.0), cfg!(feature = "flip").then_some(true));
        assert_eq!(compare(&b, &b).unwrap().flip, cfg!(feature = "flip").then_some(0.0));
        assert_eq!(compare(&a, &flat(&[0.0; 4], 4)), Err(SizeMismatch((2, 2), (4, 1))));
    }

    #[test]
    fn false_colours_span_the_map() {
        let reference = flat(&[0.0, 1.0], 2);
        let picture = false_color(&flat(&[0.0, 9.0], 2), &reference).unwrap();
        assert!(picture.pixels[0][2] > picture.pixels[0][0] && picture.pixels[1][0] > picture.pixels[1][2]);
    }
}
