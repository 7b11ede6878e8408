//! Images from files: OpenEXR, Radiance HDR, PNG and JPEG, with a limit on size set before anything is allocated.

use super::error::{FileError, read_file};
use exr::prelude::{MetaData, ReadChannels, ReadLayers};
use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits};
use std::io::Cursor;
use std::path::Path;

/// More pixels than this are refused: 16384 × 16384.
const MAX_PIXELS: u64 = 1 << 28;
/// Larger image files are refused.
const MAX_FILE: u64 = 1 << 31;

/// A decoded image, row by row from the top; values as stored: no transfer function has been undone.
#[derive(Clone, Debug, PartialEq)]
pub struct Pixels {
    /// Pixels per row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Red, green, blue, alpha; integer formats scaled to 0 … 1, grey repeated, alpha 1 where the file has none.
    pub rgba: Vec<[f32; 4]>,
    /// Whether the format stores display values (8-bit or 16-bit integers) rather than linear light.
    pub display_referred: bool,
}

/// Reads an image file, recognised by its first bytes.
pub fn read(path: &Path) -> Result<Pixels, FileError> {
    decode(&read_file(path, MAX_FILE)?, path)
}

/// Decodes an image in memory; `path` serves error messages only.
pub fn decode(bytes: &[u8], path: &Path) -> Result<Pixels, FileError> {
    let pixels = if bytes.starts_with(&[0x76, 0x2f, 0x31, 0x01]) { exr(bytes) } else { raster(bytes) };
    let pixels = pixels.map_err(|what| FileError::new(path, what))?;
    if pixels.rgba.is_empty() {
        return Err(FileError::new(path, "an image without pixels"));
    }
    match pixels.rgba.iter().position(|p| p.iter().any(|c| !c.is_finite())) {
        Some(i) => {
            let (x, y) = (i as u32 % pixels.width, i as u32 / pixels.width);
            Err(FileError::new(path, format_args!("pixel ({x}, {y}) is not finite")))
        }
        None => Ok(pixels),
    }
}

fn check_size(width: u64, height: u64) -> Result<(), String> {
    if width.checked_mul(height).is_some_and(|n| n <= MAX_PIXELS) {
        return Ok(());
    }
    Err(format!("{width} × {height} pixels, more than the {MAX_PIXELS} accepted"))
}

/// PNG, JPEG, Radiance HDR.
fn raster(bytes: &[u8]) -> Result<Pixels, String> {
    let mut reader = ImageReader::new(Cursor::new(bytes)).with_guessed_format().map_err(|e| e.to_string())?;
    let mut limits = Limits::default();
    limits.max_alloc = Some(MAX_PIXELS * 16);
    reader.limits(limits);
    let format = reader.format().ok_or("not an OpenEXR, Radiance HDR, PNG or JPEG image")?;
    let decoder = reader.into_decoder().map_err(|e| e.to_string())?;
    let (width, height) = decoder.dimensions();
    check_size(width.into(), height.into())?;
    let image = DynamicImage::from_decoder(decoder).map_err(|e| e.to_string())?;
    let rgba = image.into_rgba32f().into_vec().as_chunks().0.to_vec();
    Ok(Pixels { width, height, rgba, display_referred: format != ImageFormat::Hdr })
}

/// The first layer of an OpenEXR image with colour or luminance channels.
fn exr(bytes: &[u8]) -> Result<Pixels, String> {
    // The header alone decides how much the decoder allocates.
    let metadata = MetaData::read_from_buffered(bytes, false).map_err(|e| e.to_string())?;
    for header in &metadata.headers {
        let size = header.layer_size;
        check_size(size.width() as u64, size.height() as u64 * header.channels.list.len().max(1) as u64)?;
    }
    let image = exr::prelude::read().no_deep_data().largest_resolution_level().all_channels();
    let image = image.first_valid_layer().all_attributes().from_buffered(Cursor::new(bytes));
    let layer = image.map_err(|e| e.to_string())?.layer_data;
    let channel = |names: &[&str]| {
        layer.channel_data.list.iter().find(|c| names.iter().any(|n| c.name.to_string().eq_ignore_ascii_case(n)))
    };
    let grey = channel(&["Y", "L"]);
    let missing = || {
        let names: Vec<_> = layer.channel_data.list.iter().map(|c| c.name.to_string()).collect();
        format!("no channels R, G, B or Y in its first layer ({})", names.join(", "))
    };
    let red = channel(&["R"]).or(grey).ok_or_else(missing)?;
    let green = channel(&["G"]).or(grey).ok_or_else(missing)?;
    let blue = channel(&["B"]).or(grey).ok_or_else(missing)?;
    let alpha = channel(&["A"]);
    let (width, height) = (layer.size.width(), layer.size.height());
    let mut rgba = vec![[0.0, 0.0, 0.0, 1.0]; width * height];
    for (i, source) in [Some(red), Some(green), Some(blue), alpha].into_iter().enumerate() {
        for (pixel, value) in rgba.iter_mut().zip(source.iter().flat_map(|c| c.sample_data.values_as_f32())) {
            pixel[i] = value;
        }
    }
    Ok(Pixels { width: width as u32, height: height as u32, rgba, display_referred: false })
}

/// Inverse of the sRGB transfer function (IEC 61966-2-1).
pub fn srgb_to_linear(value: f32) -> f32 {
    if value <= 0.04045 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
}
