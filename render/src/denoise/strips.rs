//! Large pictures are denoised strip by strip: what a denoiser needs beside them is then no part of what a film takes.

use crate::picture::{Picture, Pixel};
use crate::scene::Crop;
use core::ops::Range;

/// Pixels of a strip, about: that of a 4K picture whole. What they take beside a film is then below a gigabyte.
pub(super) const PIXELS: usize = 1 << 23;

/// Rows that a denoiser sees beyond those of a strip on either side: more than the 101 that the large network of Open Image Denoise
/// 2.3 looks at (its `receptiveField` of 202), and the bound of fireflies before it.
pub(super) const MARGIN: usize = 128;

/// Pixels that a denoiser sees at once of a part of a film, at most.
pub fn seen(window: Crop) -> u64 {
    let strips = Strip::of([window.width as usize, window.height as usize], PIXELS);
    strips.iter().map(|strip| strip.seen_pixels().len() as u64).max().unwrap_or(0)
}

/// Some rows of a picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Strip {
    /// The rows to denoise.
    pub rows: Range<usize>,
    /// Those that the denoiser sees.
    pub seen: Range<usize>,
    width: usize,
}

impl Strip {
    /// Those of so many columns and rows, from the top, of about so many pixels.
    pub fn of([width, height]: [usize; 2], pixels: usize) -> Vec<Self> {
        let count = (width * height).div_ceil(pixels.max(1)).clamp(1, height.max(1));
        let strip = |i: usize| {
            let rows = height * i / count..height * (i + 1) / count;
            let seen = rows.start.saturating_sub(MARGIN)..(rows.end + MARGIN).min(height);
            Self { rows, seen, width }
        };
        (0..count).map(strip).collect()
    }

    /// The pixels that the denoiser sees, of those of the picture.
    pub fn seen_pixels(&self) -> Range<usize> {
        self.seen.start * self.width..self.seen.end * self.width
    }

    /// The pixels to denoise, of those of the picture.
    pub fn pixels<'a>(&self, picture: &'a Picture) -> &'a [Pixel] {
        &picture.pixels[self.rows.start * self.width..self.rows.end * self.width]
    }

    /// The pixels to denoise, of those that the denoiser sees.
    pub fn inner(&self) -> Range<usize> {
        let rows = self.rows.start - self.seen.start..self.rows.end - self.seen.start;
        rows.start * self.width..rows.end * self.width
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::Split;
    use crate::denoise::{Choice, Denoiser, Effort};
    use crate::picture::Radiance;
    use crate::scene::Rgb;
    use crate::world::Counts;
    use std::sync::Mutex;

    /// Noisy tiles of several albedos and brightnesses, brighter towards the bottom.
    fn tiles() -> Picture {
        let window = Crop { x: 0, y: 0, width: 96, height: 700 };
        let noise = |i: usize, k: usize| ((i * 2_654_435_761 + k * 40_503) >> 7) % 1000;
        let pixel = |i: usize| {
            let tile = (i % 96 / 12 + i / 96 / 20) % 3;
            let level = 0.2 + 0.3 * tile as f32 + i as f32 / 30_000.0;
            let mut pixel = Pixel::default();
            for half in 0..2 {
                let [direct, indirect] =
                    [0, 1].map(|k| Rgb::splat(level * noise(i, 2 * half + k) as f32 / 500.0) * Rgb::new(1.0, 0.8, 0.6));
                let diffuse = |light| Split { diffuse: light, glossy: Rgb::ZERO };
                let (direct, indirect) = (diffuse(direct), diffuse(indirect));
                let (albedo, normal) = (Rgb::splat(0.3 * tile as f32), Rgb::Z);
                pixel.add(Radiance { direct, indirect, albedo, normal, ..Radiance::NONE }, half == 0);
            }
            pixel
        };
        Picture::of(window, (0..96 * 700).map(pixel).collect(), 2, Counts::default(), false)
    }

    /// Largest difference of a pixel between denoising in one piece and in strips.
    fn difference(denoiser: &Denoiser) -> f32 {
        let [mut whole, mut strips] = [tiles(), tiles()];
        denoiser.denoise_strips(&mut whole, Effort::Low, usize::MAX, &|_| ()).unwrap();
        let told = Mutex::new(Vec::new());
        denoiser.denoise_strips(&mut strips, Effort::Low, 96 * 200, &|share| told.lock().unwrap().push(share)).unwrap();
        let told = told.into_inner().unwrap();
        assert!(told.len() > 4 && told.iter().all(|share| (0.0..=1.0).contains(share)), "{told:?}");
        assert!(told.iter().copied().fold(0.0, f64::max) == 1.0, "{told:?}");
        let [whole, strips] = [whole, strips].map(|p| p.denoised.unwrap());
        assert_eq!(whole.len(), strips.len());
        whole.iter().flatten().zip(strips.iter().flatten()).map(|(a, b)| (a - b).abs() / a).fold(0.0, f32::max)
    }

    #[test]
    fn strips_cover_a_picture_once() {
        for (size, pixels) in [([7, 5], 7), ([7, 5], 1), ([3, 1000], 600), ([4000, 1000], PIXELS)] {
            let strips = Strip::of(size, pixels);
            let rows: Vec<_> = strips.iter().flat_map(|s| s.rows.clone()).collect();
            assert_eq!(rows, (0..size[1]).collect::<Vec<_>>());
            assert!(strips.iter().all(|s| s.rows.len() * size[0] <= pixels.max(size[0]) && s.seen.end <= size[1]));
            assert!(strips.iter().all(|s| s.inner().len() == s.rows.len() * size[0]));
        }
    }

    #[test]
    fn strips_show_what_the_whole_does() {
        let ours = difference(&Denoiser::open(Choice::Builtin, None, 0).unwrap());
        assert!(ours < 1e-4, "{ours}");
        match Denoiser::open(Choice::Oidn, None, 0) {
            // A network of half precision that is laid over other tiles.
            Ok(oidn) => assert!(difference(&oidn) < 1e-2, "{}", difference(&oidn)),
            Err(error) => eprintln!("skipped: {error}"),
        }
    }
}
