//! EXR with layers, PNG as the sRGB view. Files appear whole or not at all.

use super::{Image, ImageError, to_srgb};
use crate::film::{Picture, Pixel};
use crate::scene::Rgb;
use exr::meta::attribute::AttributeValue;
use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image as ExrImage, Layer, LayerAttributes, SmallVec, WritableImage,
};
use rayon::prelude::*;
use std::io::{Cursor, Write};
use std::path::Path;

impl Picture {
    /// The whole light, as a picture.
    pub fn image(&self) -> Image {
        let scale = 1.0 / self.spp.max(1) as f32;
        let pixels = self.pixels.iter().map(|p| (p.sum.sum() * scale).to_array()).collect();
        Image { width: self.width, height: self.height, pixels }
    }
}

/// Writes a rendering: `.exr` with all layers, or `.png` as seen on an sRGB screen.
///
/// # Errors
/// Another extension, or a file that cannot be written.
pub fn write_picture(path: &Path, picture: &Picture) -> Result<(), ImageError> {
    match extension(path).as_str() {
        "exr" => write_whole(path, &exr_bytes(path, picture)?),
        "png" => write_png(path, &picture.image()),
        _ => Err(ImageError::Extension(path.display().to_string(), ".exr or .png")),
    }
}

/// Writes the sRGB view of a picture.
///
/// # Errors
/// A file that cannot be written.
pub fn write_png(path: &Path, image: &Image) -> Result<(), ImageError> {
    let bytes: Vec<u8> = image.pixels.iter().flatten().map(|x| (255.0 * to_srgb(*x) + 0.5) as u8).collect();
    let mut out = Cursor::new(Vec::new());
    image::write_buffer_with_format(
        &mut out,
        &bytes,
        image.width,
        image.height,
        image::ExtendedColorType::Rgb8,
        image::ImageFormat::Png,
    )
    .map_err(|e| content(path, e))?;
    write_whole(path, &out.into_inner())
}

/// Lower-case extension of a path.
pub(super) fn extension(path: &Path) -> String {
    path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase()
}

pub(super) fn content(path: &Path, reason: impl ToString) -> ImageError {
    ImageError::Content { path: path.display().to_string(), reason: reason.to_string() }
}

/// Writes any file whole or not at all: beside the target, then renames.
///
/// # Errors
/// A file that cannot be written.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), ImageError> {
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let write = || {
        let mut file = tempfile::NamedTempFile::new_in(folder)?;
        file.write_all(bytes)?;
        // Temporary files are private; the picture gets the permissions any new file would have.
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            file.as_file().set_permissions(std::fs::Permissions::from_mode(0o644))?;
        }
        file.persist(path).map_err(|e| e.error)
    };
    write().map(drop).map_err(|error| ImageError::Io { path: path.display().to_string(), error })
}

/// Attribute of an EXR: samples per pixel.
pub(super) const SPP: &str = "spp";

/// Name and sum of a coloured layer.
type ColorLayer = (&'static str, fn(&Pixel) -> Rgb);

/// What a channel holds of a pixel.
type PixelValue<'a> = Box<dyn Fn(&Pixel) -> f32 + Sync + 'a>;

/// Layers of the EXR: the light by its way, and what the first surface is.
fn exr_bytes(path: &Path, picture: &Picture) -> Result<Vec<u8>, ImageError> {
    let scale = 1.0 / picture.spp.max(1) as f32;
    let layers: [ColorLayer; 7] = [
        ("", |p| p.sum.sum()),
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
    if picture.passes > 1 {
        for (i, channel) in ["R", "G", "B"].into_iter().enumerate() {
            let variance = move |p: &Pixel| picture.variance(p).unwrap_or_default()[i];
            values.push((format!("variance.{channel}"), Box::new(variance)));
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
    let channels: SmallVec<[AnyChannel<FlatSamples>; 4]> = values.par_iter().map(channel).collect::<Vec<_>>().into();
    let mut attributes = LayerAttributes::default();
    // One attribute of our own: the order of several would change from run to run.
    attributes.other.insert(SPP.into(), AttributeValue::I32(picture.spp as i32));
    let size = (picture.width as usize, picture.height as usize);
    let layer = Layer::new(size, attributes, Encoding::SMALL_LOSSLESS, AnyChannels::sort(channels));
    let mut out = Cursor::new(Vec::new());
    ExrImage::from_layer(layer).write().to_buffered(&mut out).map_err(|e| content(path, e))?;
    Ok(out.into_inner())
}
