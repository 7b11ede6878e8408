//! PNG, JPEG and WebP. Profiles and gammas in the file are ignored: the values count as sRGB.

use super::{MAX_PIXELS, Pixels, check_plausible, check_size, require_room};
use crate::image::{Channels, Raster, Samples};
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
    require_room(width as usize * height as usize, decoder.total_bytes())?;
    let (channels, samples) = match DynamicImage::from_decoder(decoder).map_err(damaged)? {
        DynamicImage::ImageLuma8(image) => (Channels::Gray, Samples::U8(image.into_raw())),
        DynamicImage::ImageLumaA8(image) => (Channels::GrayAlpha, Samples::U8(image.into_raw())),
        DynamicImage::ImageRgb8(image) => (Channels::Rgb, Samples::U8(image.into_raw())),
        DynamicImage::ImageRgba8(image) => (Channels::Rgba, Samples::U8(image.into_raw())),
        DynamicImage::ImageLuma16(image) => (Channels::Gray, Samples::U16(image.into_raw())),
        DynamicImage::ImageLumaA16(image) => (Channels::GrayAlpha, Samples::U16(image.into_raw())),
        DynamicImage::ImageRgb16(image) => (Channels::Rgb, Samples::U16(image.into_raw())),
        DynamicImage::ImageRgba16(image) => (Channels::Rgba, Samples::U16(image.into_raw())),
        other => return Err(format!("a {name} of {:?} pixels is not read", other.color())),
    };
    Ok(Pixels { raster: Raster { width, height, channels, samples }, ..Pixels::default() })
}
