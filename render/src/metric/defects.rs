//! Faults that a mean error hides: light where none belongs, negative light, single bright pixels.

use super::{SizeMismatch, pixel_error};
use crate::color::luminance;
use crate::image::Image;
use crate::scene::Rgb;
use serde::Serialize;

/// Edge of a block in pixels: over it the noise of single pixels averages out, and what is wrong remains.
const BLOCK: u32 = 4;

/// A block of the reference is dark below this share of the reference's mean luminance; light leaks into it if the
/// picture shows at least this share more.
pub const DARK: f64 = 0.02;

/// Faults of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Defects {
    /// Mean over blocks of 4×4 pixels and channels of squared error / (reference² + 0.01).
    pub blocks: f64,
    /// Largest error of a pixel: root of the channels' mean of squared error / (reference² + 0.01).
    pub worst: f64,
    /// Share of the blocks that are dark ([`DARK`]) in the reference and not in the picture.
    pub leaks: f64,
    /// Share of the pixels with a negative channel.
    pub negative: f64,
}

impl Defects {
    /// Defects of a picture against its reference.
    ///
    /// # Errors
    /// Pictures of different sizes.
    pub fn new(image: &Image, reference: &Image) -> Result<Self, SizeMismatch> {
        let (a, b) = ((image.width, image.height), (reference.width, reference.height));
        if a != b {
            return Err(SizeMismatch(a, b));
        }
        let count = image.pixels.len().max(1) as f64;
        let pairs = || image.pixels.iter().zip(&reference.pixels);
        let worst = pairs().map(|(x, y)| f64::from(pixel_error(x, y))).fold(0.0, f64::max);
        let negative = image.pixels.iter().filter(|p| p.iter().any(|x| *x < 0.0)).count() as f64 / count;
        let light = |p: Rgb| f64::from(luminance(p));
        let mean = reference.pixels.iter().map(|p| light(Rgb::from_array(*p))).sum::<f64>() / count;
        let (columns, rows) = (a.0.div_ceil(BLOCK), a.1.div_ceil(BLOCK));
        let (mut error, mut leaks) = (0.0, 0u32);
        for block in 0..columns * rows {
            let at = (block % columns * BLOCK, block / columns * BLOCK);
            let (x, y) = (block_mean(image, at), block_mean(reference, at));
            error += (0..3)
                .map(|c| (f64::from(x[c]), f64::from(y[c])))
                .map(|(x, y)| (x - y).powi(2) / (y * y + 0.01))
                .sum::<f64>();
            let (x, y) = (light(x), light(y));
            leaks += u32::from(y <= DARK * mean && x > y && x - y >= DARK * mean);
        }
        let blocks = f64::from((columns * rows).max(1));
        Ok(Self { blocks: error / (3.0 * blocks), worst, leaks: f64::from(leaks) / blocks, negative })
    }
}

/// Mean of the block whose first pixel is given; at the border, of what there is of it.
fn block_mean(image: &Image, (x, y): (u32, u32)) -> Rgb {
    let (right, bottom) = ((x + BLOCK).min(image.width), (y + BLOCK).min(image.height));
    let pixels = (y..bottom).flat_map(|row| (x..right).map(move |column| (row * image.width + column) as usize));
    let sum: Rgb = pixels.map(|i| Rgb::from_array(image.pixels[i])).sum();
    sum / ((right - x) * (bottom - y)) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A bright left half and a black right one, 8 × 5 pixels: three kinds of block, two of them cut off.
    fn half() -> Image {
        let pixels = (0..40).map(|i| if i % 8 < 4 { [1.0; 3] } else { [0.0; 3] }).collect();
        Image { width: 8, height: 5, pixels }
    }

    #[test]
    fn a_picture_has_no_faults_against_itself() {
        let same = Defects::new(&half(), &half()).unwrap();
        assert_eq!(same, Defects { blocks: 0.0, worst: 0.0, leaks: 0.0, negative: 0.0 });
        let black = Image { pixels: vec![[0.0; 3]; 40], ..half() };
        assert_eq!(Defects::new(&black, &black).unwrap().leaks, 0.0);
        assert!(Defects::new(&Image { width: 5, height: 8, ..half() }, &half()).is_err());
    }

    #[test]
    fn each_fault_is_told_from_the_others() {
        // Light in one of the two dark blocks; darkness in a bright one is no leak.
        let mut leak = half();
        (0..4).for_each(|i| leak.pixels[i * 8 + 6] = [0.1; 3]);
        leak.pixels[0] = [0.0; 3];
        let found = Defects::new(&leak, &half()).unwrap();
        assert_eq!((found.leaks, found.negative), (0.25, 0.0));
        // 1 % of light is below what counts.
        let mut faint = half();
        (0..4).for_each(|i| faint.pixels[i * 8 + 6] = [0.02; 3]);
        assert_eq!(Defects::new(&faint, &half()).unwrap().leaks, 0.0);
        // Ringing.
        let mut rings = half();
        rings.pixels[5] = [0.0, -0.01, 0.0];
        assert_eq!(Defects::new(&rings, &half()).unwrap().negative, 1.0 / 40.0);
        // A spot; noise that cancels within a block is no error of the block.
        let mut spot = half();
        (spot.pixels[0], spot.pixels[1]) = ([3.0; 3], [-1.0; 3]);
        let found = Defects::new(&spot, &half()).unwrap();
        assert!((found.worst - 2.0 / 1.01f64.sqrt()).abs() < 1e-6 && found.blocks < 1e-12);
    }
}
