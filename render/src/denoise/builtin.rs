//! Our own denoiser.

use super::layers::{Layer, Layers};
use crate::scene::Rgb;
use rayon::prelude::*;

/// Pixels each way.
const REACH: usize = 8;

/// Direct and indirect light without noise; `None` where a layer is black.
pub(super) fn denoise(layers: &Layers) -> [Option<Vec<[f32; 3]>>; 2] {
    [&layers.direct, &layers.indirect].map(|layer| layer.as_ref().map(|layer| filter(layers, layer)))
}

/// Mean over the pixels around with the same albedo and normal.
fn filter(layers: &Layers, layer: &Layer) -> Vec<[f32; 3]> {
    let (width, height) = (layers.width, layers.height);
    let far = |a: &[f32; 3], b: &[f32; 3]| (Rgb::from_array(*a) - Rgb::from_array(*b)).length_squared();
    let pixel = |i: usize| {
        let (x, y) = (i % width, i / width);
        let (mut sum, mut weights) = (Rgb::ZERO, 0.0);
        for y in y.saturating_sub(REACH)..(y + REACH + 1).min(height) {
            for x in x.saturating_sub(REACH)..(x + REACH + 1).min(width) {
                let j = y * width + x;
                let difference = far(&layers.albedo[i], &layers.albedo[j]) / 0.002
                    + far(&layers.normal[i], &layers.normal[j]) / 0.02;
                let weight = (-difference).exp();
                sum += Rgb::from_array(layer.mean[j]) * weight;
                weights += weight;
            }
        }
        (sum / weights).to_array()
    };
    (0..width * height).into_par_iter().map(pixel).collect()
}
