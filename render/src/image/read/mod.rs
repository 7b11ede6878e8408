//! One reader of pictures for skies, textures and `compare`: OpenEXR, Radiance HDR, PNG, JPEG and WebP, recognised by
//! their first bytes whatever the name says. Sizes are checked against limits, and against what the bytes could hold,
//! before anything is allocated.

mod compact;
mod display;
mod exr;
mod hdr;
mod primaries;
mod window;

use super::write::content;
use super::{Image, ImageError, Noise, Raster, from_srgb};
use crate::memory;
use std::path::Path;

pub use window::{Window, Windows};

/// More pixels than this are refused: 16384 × 16384.
const MAX_PIXELS: u64 = 1 << 28;

/// Larger files are refused.
const MAX_FILE: u64 = 1 << 33;

/// A decoded picture.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Pixels {
    /// The pixels as stored: no transfer function has been undone. Colours are finite; alpha need not be, for few who
    /// read a picture ask for it.
    pub raster: Raster,
    /// Where the pixels lie, for formats that say so (OpenEXR).
    pub windows: Option<Windows>,
    /// What the file left open, and how it was read: one line each.
    pub warnings: Vec<String>,
}

impl From<Pixels> for Image {
    /// Undoes the sRGB curve of formats made for display, and drops alpha.
    fn from(Pixels { raster, .. }: Pixels) -> Self {
        let display_referred = raster.is_display_referred();
        let linear = |x| if display_referred { from_srgb(x) } else { x };
        let pixels = raster.pixels().map(|[r, g, b, _]| [r, g, b].map(linear)).collect();
        Self { width: raster.width, height: raster.height, pixels }
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
        display::decode(bytes)
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
    if pixels.raster.is_empty() {
        return Err(content(path, "an image without pixels"));
    }
    match pixels.raster.color_not_finite() {
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

/// Refuses pixels of so many bytes in all for which there is not enough memory. Small ones are not worth the question.
fn require_room(pixels: usize, bytes: u64) -> Result<(), String> {
    const SMALL: u64 = 1 << 26;
    if bytes < SMALL { Ok(()) } else { memory::require(&format!("an image of {pixels} pixels"), bytes) }
}

/// So many equal pixels, if memory suffices.
fn filled<T: Copy>(pixels: usize, value: T) -> Result<Vec<T>, String> {
    require_room(pixels, pixels as u64 * size_of::<T>() as u64)?;
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
