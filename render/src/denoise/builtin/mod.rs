//! Our own denoiser: non-local means of each half of the samples with weights from the other half (Buades et al. 2005; Rousselle,
//! Knaus and Zwicker 2012), and where albedo and normal differ, none (Rousselle, Manzi and Zwicker 2013, "Robust denoising using
//! feature and color information").
//!
//! How much difference between two pixels is put down to noise is the choice that matters: three answers are tried, and at
//! every pixel the one with the least error is taken. What a half says of a filtered picture of the other one tells the error: their
//! noise is independent ([`select`]).

mod means;
mod planes;
mod select;

use super::Progress;
use super::layers::{Layer, Layers};
use planes::{Guides, Light};

/// A layer without noise.
pub(super) fn denoise(layers: &Layers, layer: &Layer, progress: Progress) -> Vec<[f32; 3]> {
    let guides = Guides::new(layers);
    let size = guides.size;
    let light = Light::new(size, layer);
    let candidates = means::candidates(&guides, &light, progress);
    // One sample has no halves to tell the error by.
    let pixels = if layer.halves.is_some() { select::best(size, &candidates) } else { candidates.middle() };
    pixels.into_iter().map(|p| p.map(|x| x.max(0.0))).collect()
}
