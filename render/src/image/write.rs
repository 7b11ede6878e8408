//! Renderings: OpenEXR with layers, or a format for display.

use super::ImageError;
use super::layers::{self, Part};
use super::screen::{self, Format};
use super::view::Display;
use crate::picture::Picture;
use kit::output;
use std::path::Path;

/// How a rendering is written.
#[derive(Clone, Debug)]
pub struct Look {
    /// For formats that screens show; OpenEXR keeps the light as it is.
    pub display: Display,
    /// Whether the picture has alpha: the share of a pixel's samples that met a surface.
    pub alpha: bool,
    /// A line that [`super::read_note`] finds in OpenEXR and PNG.
    pub note: Option<String>,
    /// Layers of OpenEXR beside the picture.
    pub parts: Vec<Part>,
}

impl Default for Look {
    /// With all layers.
    fn default() -> Self {
        Self { display: Display::default(), alpha: false, note: None, parts: Part::ALL.to_vec() }
    }
}

/// Writes a rendering: `.exr` with all layers, or a [`Format`] for display.
///
/// # Errors
/// Another extension, or a file that cannot be written.
pub fn write_picture(path: &Path, picture: &Picture, look: &Look) -> Result<(), ImageError> {
    if extension(path) == "exr" {
        return layers::write(path, picture, look);
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
