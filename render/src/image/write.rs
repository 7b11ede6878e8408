//! Renderings: OpenEXR with layers, or a format for display.

use super::ImageError;
use super::screen::{self, Format};
use super::view::Display;
use crate::picture::{Picture, Pixel};
use crate::scene::Rgb;
use exr::meta::attribute::AttributeValue;
use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image as ExrImage, Layer, LayerAttributes, SmallVec, WritableImage,
};
use kit::output;
use rayon::prelude::*;
use std::io::Cursor;
use std::path::Path;

/// How a rendering is written.
#[derive(Clone, Debug, Default)]
pub struct Look {
    /// For formats that screens show; OpenEXR keeps the light as it is.
    pub display: Display,
    /// Whether the picture has alpha: the share of a pixel's samples that met a surface.
    pub alpha: bool,
    /// A line that [`super::read_note`] finds in OpenEXR and PNG.
    pub note: Option<String>,
}

/// Writes a rendering: `.exr` with all layers, or a [`Format`] for display.
///
/// # Errors
/// Another extension, or a file that cannot be written.
pub fn write_picture(path: &Path, picture: &Picture, look: &Look) -> Result<(), ImageError> {
    if extension(path) == "exr" {
        return write_whole(path, &exr_bytes(path, picture, look)?);
    }
    let extensions = ".exr, .png, .jpg, .jpeg or .webp";
    let format = Format::of(path).ok_or_else(|| ImageError::Extension(path.display().to_string(), extensions))?;
    let alpha: Option<Vec<f32>> = look.alpha.then(|| picture.pixels.iter().map(|p| picture.alpha(p)).collect());
    screen::write(path, format, &picture.image(), alpha.as_deref(), look)
}

/// Lower-case extension of a path.
pub(super) fn extension(path: &Path) -> String {
    path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase()
}

pub(super) fn content(path: &Path, reason: impl ToString) -> ImageError {
    ImageError::Content { path: path.display().to_string(), reason: reason.to_string() }
}

/// Writes any file whole or not at all.
///
/// # Errors
/// A file that cannot be written.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), ImageError> {
    Ok(output::write(path, bytes)?)
}

/// Attribute of an EXR: samples per pixel.
pub(super) const SPP: &str = "spp";

/// Name and sum of a coloured layer.
type ColorLayer = (&'static str, fn(&Pixel) -> Rgb);

/// What a channel holds of a pixel.
type PixelValue<'a> = Box<dyn Fn(&Pixel) -> f32 + Sync + 'a>;

/// Layers of the EXR: the light by its way, and what the first surface is.
fn exr_bytes(path: &Path, picture: &Picture, look: &Look) -> Result<Vec<u8>, ImageError> {
    let scale = 1.0 / picture.spp.max(1) as f32;
    // What is denoised is the picture; the rest is noisy, and so is what it says of itself.
    let (whole, variance_layer) =
        if picture.denoised.is_some() { ("noisy.", "noisy.variance.") } else { ("", "variance.") };
    let layers: [ColorLayer; 7] = [
        (whole, |p| p.sum.sum()),
        ("emission.", |p| p.sum.emission),
        ("direct.diffuse.", |p| p.sum.direct.diffuse),
        ("direct.glossy.", |p| p.sum.direct.glossy),
        ("indirect.diffuse.", |p| p.sum.indirect.diffuse),
        ("indirect.glossy.", |p| p.sum.indirect.glossy),
        ("albedo.", |p| p.sum.albedo),
    ];
    let mut values: Vec<(String, PixelValue)> = Vec::new();
    for (layer, color) in layers {
        for (i, channel) in ["R", "G", "B"].into_iter().enumerate() {
            values.push((format!("{layer}{channel}"), Box::new(move |p| color(p)[i] * scale)));
        }
    }
    if look.alpha {
        values.push(("A".into(), Box::new(|p: &Pixel| picture.alpha(p))));
    }
    if picture.passes > 1 {
        for (i, channel) in ["R", "G", "B"].into_iter().enumerate() {
            let variance = move |p: &Pixel| picture.variance(p).unwrap_or_default()[i];
            values.push((format!("{variance_layer}{channel}"), Box::new(variance)));
        }
    }
    for (i, channel) in ["X", "Y", "Z"].into_iter().enumerate() {
        values.push((format!("normal.{channel}"), Box::new(move |p| p.sum.normal.normalize_or_zero()[i])));
    }
    // The mean depth of the samples that met a surface.
    let depth = |p: &Pixel| if p.surfaces > 0 { p.sum.distance / p.surfaces as f32 } else { f32::INFINITY };
    values.push(("depth.Z".into(), Box::new(depth)));
    let channel = |(name, value): &(String, PixelValue)| {
        AnyChannel::new(name.as_str(), FlatSamples::F32(picture.pixels.iter().map(value).collect()))
    };
    let mut channels: SmallVec<[AnyChannel<FlatSamples>; 4]> =
        values.par_iter().map(channel).collect::<Vec<_>>().into();
    for (i, name) in ["R", "G", "B"].into_iter().enumerate() {
        if let Some(pixels) = &picture.denoised {
            channels.push(AnyChannel::new(name, FlatSamples::F32(pixels.iter().map(|p| p[i]).collect())));
        }
    }
    let mut attributes = LayerAttributes::default();
    // One attribute of our own: the order of several would change from run to run.
    attributes.other.insert(SPP.into(), AttributeValue::I32(picture.spp as i32));
    attributes.comments = look.note.as_deref().map(Into::into);
    let size = (picture.width as usize, picture.height as usize);
    // A part of a film lies where it lies in the whole.
    attributes.layer_position = exr::math::Vec2(picture.corner[0] as i32, picture.corner[1] as i32);
    let layer = Layer::new(size, attributes, Encoding::SMALL_LOSSLESS, AnyChannels::sort(channels));
    let mut out = Cursor::new(Vec::new());
    ExrImage::from_layer(layer).write().to_buffered(&mut out).map_err(|e| content(path, e))?;
    Ok(out.into_inner())
}
