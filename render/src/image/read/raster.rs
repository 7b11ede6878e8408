//! PNG, JPEG and WebP. Profiles and gammas in the file are ignored: the values count as sRGB.

use super::{MAX_PIXELS, Pixels, check_plausible, check_size};
use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits};
use std::io::Cursor;

/// Pixels that a byte of PNG or JPEG can stand for: deflate repeats 1032 bytes of eight 1-bit pixels; eight blocks of
/// 64 pixels take at least a bit each.
const PIXELS_PER_BYTE: usize = 8 * 1032;

/// Bytes of a small file.
const SMALL: usize = 1 << 12;

pub(super) fn decode(bytes: &[u8]) -> Result<Pixels, String> {
    let mut reader = ImageReader::new(Cursor::new(bytes)).with_guessed_format().map_err(|e| e.to_string())?;
    let mut limits = Limits::default();
    limits.max_alloc = Some(MAX_PIXELS * 16);
    reader.limits(limits);
    let name = match reader.format() {
        Some(ImageFormat::Png) => "PNG",
        Some(ImageFormat::Jpeg) => "JPEG",
        Some(ImageFormat::WebP) => "WebP",
        _ => return Err("not an OpenEXR, Radiance HDR, PNG, JPEG or WebP image".into()),
    };
    let damaged = |e: image::ImageError| format!("a damaged {name}: {e}");
    let decoder = reader.into_decoder().map_err(damaged)?;
    let (width, height) = decoder.dimensions();
    // An even WebP of any size has a few bytes: it may be as large as a small file of the others.
    let available = if name == "WebP" { bytes.len().max(SMALL) } else { bytes.len() };
    check_plausible(check_size(width.into(), height.into())?, available, PIXELS_PER_BYTE)?;
    let image = DynamicImage::from_decoder(decoder).map_err(damaged)?;
    let rgba = image.into_rgba32f().into_vec().as_chunks().0.to_vec();
    Ok(Pixels { width, height, rgba, display_referred: true, ..Pixels::default() })
}
