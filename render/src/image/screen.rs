//! PNG, JPEG and WebP: eight bits per channel, as a screen shows them.

use super::note;
use super::view::Display;
use super::write::{Look, content, extension, write_whole};
use super::{Image, ImageError};
use image::codecs::jpeg::JpegEncoder;
use image::codecs::png::PngEncoder;
use image::codecs::webp::WebPEncoder;
use image::{ExtendedColorType, ImageEncoder};
use rayon::prelude::*;
use std::path::Path;

/// Quality of JPEG; libjpeg's manual says that more than about 95 makes files much larger for hardly any gain. Chroma is not
/// subsampled.
const JPEG_QUALITY: u8 = 95;

/// A format for display.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Lossless.
    Png,
    /// Quality 95, without transparency.
    Jpeg,
    /// Lossless.
    WebP,
}

impl Format {
    /// Extensions of all of them.
    pub const EXTENSIONS: [&str; 4] = ["png", "jpg", "jpeg", "webp"];

    /// By the extension of a name, in any case.
    pub fn of(path: &Path) -> Option<Self> {
        match extension(path).as_str() {
            "png" => Some(Self::Png),
            "jpg" | "jpeg" => Some(Self::Jpeg),
            "webp" => Some(Self::WebP),
            _ => None,
        }
    }

    /// What people call it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Png => "PNG",
            Self::Jpeg => "JPEG",
            Self::WebP => "WebP",
        }
    }

    /// Whether it holds alpha.
    pub fn is_transparent(self) -> bool {
        self != Self::Jpeg
    }

    /// Largest width and height of its headers.
    pub fn max_size(self) -> u32 {
        match self {
            Self::Png => i32::MAX as u32,
            Self::Jpeg => u16::MAX.into(),
            Self::WebP => 1 << 14,
        }
    }

    fn encode(self, bytes: &[u8], image: &Image, color: ExtendedColorType) -> image::ImageResult<Vec<u8>> {
        let mut out = Vec::new();
        let (width, height) = (image.width, image.height);
        match self {
            Self::Png => PngEncoder::new(&mut out).write_image(bytes, width, height, color),
            Self::Jpeg => {
                JpegEncoder::new_with_quality(&mut out, JPEG_QUALITY).write_image(bytes, width, height, color)
            }
            Self::WebP => WebPEncoder::new_lossless(&mut out).write_image(bytes, width, height, color),
        }?;
        Ok(out)
    }
}

/// Writes a picture as a display shows it. `alpha`, by pixel, is what part of a pixel is covered: colours are then divided
/// by it before the view, for these formats hold colours that are not multiplied by it.
pub(super) fn write(
    path: &Path,
    format: Format,
    image: &Image,
    alpha: Option<&[f32]>,
    look: &Look,
) -> Result<(), ImageError> {
    let display = &look.display;
    let level = |x: f32| (255.0 * x + 0.5) as u8;
    let (bytes, color): (Vec<u8>, _) = match alpha {
        None => {
            let pixel = |p: &[f32; 3]| display.values(*p).map(level);
            (image.pixels.par_iter().flat_map_iter(pixel).collect(), ExtendedColorType::Rgb8)
        }
        Some(alpha) => {
            let pixel = |(p, &alpha): (&[f32; 3], &f32)| {
                let [r, g, b] = if alpha > 0.0 { display.values(p.map(|x| x / alpha)).map(level) } else { [0; 3] };
                [r, g, b, level(alpha.clamp(0.0, 1.0))]
            };
            (image.pixels.par_iter().zip(alpha).flat_map_iter(pixel).collect(), ExtendedColorType::Rgba8)
        }
    };
    let mut file = format.encode(&bytes, image, color).map_err(|e| content(path, e))?;
    if let (Format::Png, Some(text)) = (format, &look.note) {
        note::into_png(&mut file, text);
    }
    write_whole(path, &file)
}

/// A picture as a display shows it, as JPEG of this quality (1 to 100); `None` where it is too large for that.
pub fn jpeg(image: &Image, display: &Display, quality: u8) -> Option<Vec<u8>> {
    let level = |x: f32| (255.0 * x + 0.5) as u8;
    let bytes: Vec<u8> = image.pixels.par_iter().flat_map_iter(|p| display.values(*p).map(level)).collect();
    let mut out = Vec::new();
    let mut encoder = JpegEncoder::new_with_quality(&mut out, quality);
    encoder.encode(&bytes, image.width, image.height, ExtendedColorType::Rgb8).ok()?;
    Some(out)
}

/// Writes a picture with the sRGB curve.
///
/// # Errors
/// A file that cannot be written.
pub fn write_png(path: &Path, image: &Image) -> Result<(), ImageError> {
    write(path, Format::Png, image, None, &Look::default())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::view::Display;
    use crate::image::{read, read_pixels};

    fn ramp() -> Image {
        let pixels = (0..64 * 48).map(|i| [(i % 64) as f32 / 64.0, (i / 64) as f32 / 48.0, 0.2]).collect();
        Image { width: 64, height: 48, pixels }
    }

    /// Lossless formats hold the nearest level, JPEG something near it; the same picture gives the same bytes.
    #[test]
    fn formats_hold_what_is_written() {
        let folder = tempfile::tempdir().unwrap();
        let image = ramp();
        for (name, format, bound) in [
            ("a.png", Format::Png, 0.5),
            ("a.JPG", Format::Jpeg, 8.0),
            ("a.jpeg", Format::Jpeg, 8.0),
            ("a.webp", Format::WebP, 0.5),
        ] {
            let path = folder.path().join(name);
            assert_eq!(Format::of(&path), Some(format));
            write(&path, format, &image, None, &Look::default()).unwrap();
            let first = std::fs::read(&path).unwrap();
            write(&path, format, &image, None, &Look::default()).unwrap();
            assert_eq!(std::fs::read(&path).unwrap(), first);
            let found = read_pixels(&path).unwrap();
            let levels = |p: [f32; 3]| Display::STANDARD.values(p).map(|x| 255.0 * x);
            let far = found.raster.pixels().zip(&image.pixels).flat_map(|(p, q)| {
                let right = levels(*q);
                [0, 1, 2].map(|c| (255.0 * p[c] - right[c]).abs())
            });
            let far = far.fold(0.0, f32::max);
            assert!(far <= bound + 1e-3, "{name}: {far} levels");
        }
        assert!(Format::of(Path::new("a.exr")).is_none());
    }

    /// A pixel that is half covered by light of 0.5 holds half of that light, and shows 0.5 with alpha ½.
    #[test]
    fn alpha_is_not_in_the_colours() {
        let folder = tempfile::tempdir().unwrap();
        let image = Image { width: 3, height: 1, pixels: vec![[0.25; 3], [0.5; 3], [0.0; 3]] };
        for (name, format) in [("a.png", Format::Png), ("a.webp", Format::WebP)] {
            let path = folder.path().join(name);
            write(&path, format, &image, Some(&[0.5, 1.0, 0.0]), &Look::default()).unwrap();
            let found = read_pixels(&path).unwrap();
            let alpha: Vec<f32> = found.raster.pixels().map(|p| p[3]).collect();
            assert_eq!(alpha, [128.0 / 255.0, 1.0, 0.0]);
            let shown = read(&path).unwrap().pixels;
            assert!((shown[0][1] - 0.5).abs() < 0.003 && shown[0] == shown[1] && shown[2] == [0.0; 3], "{shown:?}");
        }
    }
}
