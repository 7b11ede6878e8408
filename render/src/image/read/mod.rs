//! One reader of pictures for skies, textures and `compare`: OpenEXR, Radiance HDR, PNG, JPEG and WebP, recognised by
//! their first bytes whatever the name says. Sizes are checked against limits, and against what the bytes could hold,
//! before anything is allocated.

mod exr;
mod hdr;
mod primaries;
mod raster;
mod window;

use super::write::content;
use super::{Image, ImageError, Noise, from_srgb};
use std::path::Path;

pub use window::{Window, Windows};

/// More pixels than this are refused: 16384 × 16384.
const MAX_PIXELS: u64 = 1 << 28;

/// Larger files are refused.
const MAX_FILE: u64 = 1 << 33;

/// A decoded picture, row by row from the top; values as stored: no transfer function has been undone.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Pixels {
    /// Pixels per row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Red, green, blue, alpha; integer formats scaled to 0 … 1, grey repeated, alpha 1 where the file has none.
    /// Colours are finite; alpha need not be, for few who read a picture ask for it.
    pub rgba: Vec<[f32; 4]>,
    /// Whether the format stores display values (8-bit or 16-bit integers) rather than linear light.
    pub display_referred: bool,
    /// Where the pixels lie, for formats that say so (OpenEXR).
    pub windows: Option<Windows>,
    /// What the file left open, and how it was read: one line each.
    pub warnings: Vec<String>,
}

impl Pixels {
    /// The first pixel (column, row) whose alpha is not finite.
    pub fn alpha_not_finite(&self) -> Option<(u32, u32)> {
        self.find(|p| !p[3].is_finite())
    }

    fn find(&self, wrong: impl Fn(&[f32; 4]) -> bool) -> Option<(u32, u32)> {
        let at = self.rgba.iter().position(wrong)? as u32;
        Some((at % self.width, at / self.width))
    }
}

impl From<Pixels> for Image {
    /// Undoes the sRGB curve of formats made for display, and drops alpha.
    fn from(pixels: Pixels) -> Self {
        let linear = |x| if pixels.display_referred { from_srgb(x) } else { x };
        let rgb = pixels.rgba.iter().map(|&[r, g, b, _]| [r, g, b].map(linear)).collect();
        Self { width: pixels.width, height: pixels.height, pixels: rgb }
    }
}

/// Reads a picture as linear RGB.
///
/// # Errors
/// A file that cannot be read, is broken, is too large, has no colour channels, or a colour that is not finite.
pub fn read(path: &Path) -> Result<Image, ImageError> {
    read_pixels(path).map(Image::from)
}

/// Reads a picture as it is stored.
///
/// # Errors
/// As [`read`].
pub fn read_pixels(path: &Path) -> Result<Pixels, ImageError> {
    decode(&read_file(path)?, path)
}

/// Decodes a picture in memory; `path` serves error messages only.
///
/// # Errors
/// As [`read`].
pub fn decode(bytes: &[u8], path: &Path) -> Result<Pixels, ImageError> {
    let pixels = if bytes.starts_with(&exr::MAGIC) {
        exr::decode(bytes)
    } else if bytes.starts_with(hdr::MAGIC) {
        hdr::decode(bytes)
    } else {
        raster::decode(bytes)
    };
    checked(pixels.map_err(|reason| content(path, one_line(&reason)))?, path)
}

/// Reads the layer `variance` of an EXR by `render image`; `None` where there is none.
///
/// # Errors
/// As [`read`].
pub fn read_noise(path: &Path) -> Result<Option<Noise>, ImageError> {
    let bytes = read_file(path)?;
    if !bytes.starts_with(&exr::MAGIC) {
        return Ok(None);
    }
    let variance = exr::variance(&bytes).map_err(|reason| content(path, one_line(&reason)))?;
    let Some((pixels, spp)) = variance else { return Ok(None) };
    let variance = Image::from(checked(pixels, path)?);
    if spp == 0 || variance.pixels.iter().flatten().any(|v| *v < 0.0) {
        return Err(content(path, "the variance is not one"));
    }
    Ok(Some(Noise { variance, spp }))
}

/// The promise that colours are finite.
fn checked(pixels: Pixels, path: &Path) -> Result<Pixels, ImageError> {
    if pixels.rgba.is_empty() {
        return Err(content(path, "an image without pixels"));
    }
    match pixels.find(|p| p[..3].iter().any(|c| !c.is_finite())) {
        Some((x, y)) => Err(content(path, format_args!("pixel ({x}, {y}) is not finite"))),
        None => Ok(pixels),
    }
}

/// Reads a regular file: devices never end.
fn read_file(path: &Path) -> Result<Vec<u8>, ImageError> {
    let io = |error| ImageError::Io { path: path.display().to_string(), error };
    let metadata = std::fs::metadata(path).map_err(io)?;
    if !metadata.is_file() {
        return Err(content(path, "not a file"));
    }
    if metadata.len() > MAX_FILE {
        return Err(content(path, format_args!("{} bytes, more than the {MAX_FILE} accepted", metadata.len())));
    }
    std::fs::read(path).map_err(io)
}

/// Joins the lines of a message into one; a name in it may hold any characters, and thousands of them.
fn one_line(text: &str) -> String {
    const MOST: usize = 300;
    let words = text.split(|c: char| c.is_whitespace() || c.is_control()).filter(|w| !w.is_empty());
    words.collect::<Vec<_>>().join(" ").chars().take(MOST).collect()
}

/// The number of pixels, if it is accepted.
fn check_size(width: u64, height: u64) -> Result<usize, String> {
    let pixels = width.checked_mul(height).filter(|n| *n <= MAX_PIXELS);
    let refused = || format!("{width} × {height} pixels, more than the {MAX_PIXELS} accepted");
    pixels.map(|n| n as usize).ok_or_else(refused)
}

/// Refuses a size that `available` bytes cannot hold, when one byte holds at most `per_byte` pixels.
fn check_plausible(pixels: usize, available: usize, per_byte: usize) -> Result<(), String> {
    if pixels / per_byte <= available {
        return Ok(());
    }
    Err(format!("{available} bytes cannot hold the {pixels} pixels that its header claims"))
}

/// So many equal pixels, if memory suffices.
fn filled<T: Copy>(pixels: usize, value: T) -> Result<Vec<T>, String> {
    let mut all = Vec::new();
    all.try_reserve_exact(pixels).map_err(|_| format!("not enough memory for {pixels} pixels"))?;
    all.resize(pixels, value);
    Ok(all)
}

#[cfg(test)]
mod tests {
    #[test]
    fn a_message_is_one_line_of_plain_text() {
        assert_eq!(super::one_line("channel a\u{1}\u{1b}[31m:\r\n\tbroken"), "channel a [31m: broken");
        assert_eq!(super::one_line(&"é".repeat(70_000)).chars().count(), 300);
    }
}
