//! EXR, PNG and HDR files as linear RGB. Sizes are checked before anything is allocated.

use super::write::{SPP, content, extension};
use super::{Image, ImageError, from_srgb};
use crate::z_test::Noise;
use exr::meta::attribute::{AttributeValue, Text};
use exr::prelude::{ReadChannels, ReadLayers, ReadSpecificChannel};
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

/// Reads the layer `variance` of an EXR by `render image`; `None` where there is none.
///
/// # Errors
/// As [`read`].
pub fn read_noise(path: &Path) -> Result<Option<Noise>, ImageError> {
    if extension(path) != "exr" {
        return Ok(None);
    }
    let bytes = std::fs::read(path).map_err(|source| ImageError::Io { path: path.display().to_string(), source })?;
    let meta = check_size(path, &bytes)?;
    let names = ["variance.R", "variance.G", "variance.B"];
    let Some(header) = meta.headers.first() else { return Ok(None) };
    let has = |name: &&str| header.channels.list.iter().any(|c| c.name.eq(name));
    let (true, Some(&AttributeValue::I32(spp))) =
        (names.iter().all(has), header.own_attributes.other.get(&Text::from(SPP)))
    else {
        return Ok(None);
    };
    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .specific_channels()
        .required(names[0])
        .required(names[1])
        .required(names[2])
        .collect_pixels(
            |size, _| blank(size),
            |image: &mut Image, at, (r, g, b): (f32, f32, f32)| {
                image.pixels[at.y() * image.width as usize + at.x()] = [r, g, b];
            },
        )
        .first_valid_layer()
        .all_attributes()
        .from_buffered(Cursor::new(&bytes[..]))
        .map_err(|e| content(path, e))?;
    let variance = image.layer_data.channel_data.pixels;
    if spp < 1 || !variance.pixels.iter().flatten().all(|v| *v >= 0.0 && v.is_finite()) {
        return Err(content(path, "the variance is not one"));
    }
    Ok(Some(Noise { variance, spp: spp as u32 }))
}

fn blank(size: exr::math::Vec2<usize>) -> Image {
    Image { width: size.x() as u32, height: size.y() as u32, pixels: vec![[0.0; 3]; size.area()] }
}

/// The reader allocates what the header says: look at it first.
fn check_size(path: &Path, bytes: &[u8]) -> Result<exr::meta::MetaData, ImageError> {
    let meta = exr::meta::MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(|e| content(path, e))?;
    let size =
        |h: &exr::meta::header::Header| (h.layer_size.area() as u64).saturating_mul(4 * h.channels.list.len() as u64);
    let total = meta.headers.iter().map(size).fold(0u64, u64::saturating_add);
    if total > MAX_BYTES || meta.headers.iter().any(|h| h.layer_size.area() as u64 > MAX_PIXELS) {
        return Err(content(path, format!("{total} bytes of pixels are too many")));
    }
    Ok(meta)
}

fn read_exr(path: &Path, bytes: &[u8]) -> Result<Image, ImageError> {
    check_size(path, bytes)?;
    let create = |size: exr::math::Vec2<usize>, _: &_| blank(size);
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
