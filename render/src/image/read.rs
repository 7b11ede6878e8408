//! EXR, PNG and HDR files as linear RGB. Sizes are checked before anything is allocated.

use super::write::{content, extension};
use super::{Image, ImageError, from_srgb};
use exr::prelude::{ReadChannels, ReadLayers};
use std::io::Cursor;
use std::path::Path;

/// Most pixels of a picture.
const MAX_PIXELS: u64 = 1 << 28;

/// Most bytes that all channels of an EXR may take.
const MAX_BYTES: u64 = 1 << 34;

/// Reads a picture.
///
/// # Errors
/// A file that cannot be read, is broken, is too large, or has no RGB channels.
pub fn read(path: &Path) -> Result<Image, ImageError> {
    let name = || path.display().to_string();
    let kind = extension(path);
    if !["exr", "png", "hdr"].contains(&kind.as_str()) {
        return Err(ImageError::Extension(name(), ".exr, .png or .hdr"));
    }
    let bytes = std::fs::read(path).map_err(|source| ImageError::Io { path: name(), source })?;
    let image = if kind == "exr" { read_exr(path, &bytes)? } else { read_other(path, &bytes, &kind)? };
    if image.pixels.iter().flatten().all(|x| x.is_finite()) {
        Ok(image)
    } else {
        Err(content(path, "a pixel is not finite"))
    }
}

fn read_exr(path: &Path, bytes: &[u8]) -> Result<Image, ImageError> {
    // The reader allocates what the header says: look at it first.
    let meta = exr::meta::MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(|e| content(path, e))?;
    let size =
        |h: &exr::meta::header::Header| (h.layer_size.area() as u64).saturating_mul(4 * h.channels.list.len() as u64);
    let total = meta.headers.iter().map(size).fold(0u64, u64::saturating_add);
    if total > MAX_BYTES || meta.headers.iter().any(|h| h.layer_size.area() as u64 > MAX_PIXELS) {
        return Err(content(path, format!("{total} bytes of pixels are too many")));
    }
    let create = |size: exr::math::Vec2<usize>, _: &_| Image {
        width: size.x() as u32,
        height: size.y() as u32,
        pixels: vec![[0.0; 3]; size.area()],
    };
    let set = |image: &mut Image, at: exr::math::Vec2<usize>, (r, g, b, _): (f32, f32, f32, f32)| {
        image.pixels[at.y() * image.width as usize + at.x()] = [r, g, b];
    };
    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .rgba_channels(create, set)
        .first_valid_layer()
        .all_attributes()
        .from_buffered(Cursor::new(bytes))
        .map_err(|e| content(path, e))?;
    Ok(image.layer_data.channel_data.pixels)
}

fn read_other(path: &Path, bytes: &[u8], kind: &str) -> Result<Image, ImageError> {
    let format = if kind == "png" { image::ImageFormat::Png } else { image::ImageFormat::Hdr };
    let mut reader = image::ImageReader::with_format(Cursor::new(bytes), format);
    let mut limits = image::Limits::default();
    limits.max_alloc = Some(MAX_BYTES);
    reader.limits(limits);
    let decoded = reader.decode().map_err(|e| content(path, e))?;
    let rgb = decoded.to_rgb32f();
    let linear = |x: f32| if kind == "png" { from_srgb(x) } else { x };
    let pixels = rgb.pixels().map(|p| p.0.map(linear)).collect();
    Ok(Image { width: rgb.width(), height: rgb.height(), pixels })
}
