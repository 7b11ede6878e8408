//! How bright a picture is: denoisers take some numbers from the whole of it, which strips of it have to share.

use super::layers::Kind;
use crate::color::luminance;
use crate::picture::Picture;
use rayon::prelude::*;

/// Brightness of one kind of light in a whole picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Level {
    /// Mean of the channels.
    pub mean: f32,
    /// Factor that brings the mean logarithm of the luminance of blocks to [`KEY`]: by this Open Image Denoise scales what its networks
    /// see (its `Autoexposure`).
    pub exposure: f32,
}

/// Side of the blocks, the logarithm's mean, and the luminance that counts as black, of Open Image Denoise.
const BLOCK: usize = 16;
const KEY: f64 = 0.18;
const BLACK: f64 = 1e-8;

impl Level {
    /// Of light of this kind.
    pub fn of(picture: &Picture, kind: Kind) -> Self {
        let (width, height) = (picture.width as usize, picture.height as usize);
        let (columns, rows) = (width.div_ceil(BLOCK), height.div_ceil(BLOCK));
        let scale = 1.0 / f64::from(picture.spp.max(1));
        // Sum of the channels and mean luminance of a block.
        let block = |x: usize, y: usize| {
            let [left, right] = [x, x + 1].map(|i| width * i / columns);
            let [top, bottom] = [y, y + 1].map(|i| height * i / rows);
            let (mut channels, mut light) = (0.0, 0.0);
            for row in top..bottom {
                for pixel in &picture.pixels[row * width + left..row * width + right] {
                    let sum = kind.sum(pixel);
                    channels += f64::from(sum.element_sum()) * scale;
                    light += f64::from(luminance(sum).max(0.0)) * scale;
                }
            }
            (channels, light / ((right - left) * (bottom - top)) as f64)
        };
        // Rows of blocks in their order: the same sum for any number of threads.
        let sums: Vec<_> = (0..rows)
            .into_par_iter()
            .map(|y| {
                let (mut channels, mut logarithms, mut lit) = (0.0, 0.0, 0u32);
                for x in 0..columns {
                    let (sum, light) = block(x, y);
                    channels += sum;
                    if light > BLACK {
                        (logarithms, lit) = (logarithms + light.log2(), lit + 1);
                    }
                }
                (channels, logarithms, lit)
            })
            .collect();
        let channels: f64 = sums.iter().map(|s| s.0).sum();
        let logarithms: f64 = sums.iter().map(|s| s.1).sum();
        let lit: u32 = sums.iter().map(|s| s.2).sum();
        let exposure = if lit > 0 { KEY / (logarithms / f64::from(lit)).exp2() } else { 1.0 };
        Self { mean: (channels / (3 * width * height).max(1) as f64) as f32, exposure: exposure as f32 }
    }
}
