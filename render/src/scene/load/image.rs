//! Images of scenes, by the reader of all pictures.

use super::error::FileError;
use crate::image::{self, ImageError};
use std::path::Path;

pub use crate::image::{Pixels, from_srgb as srgb_to_linear};

/// Reads an image file, recognised by its first bytes.
pub fn read(path: &Path) -> Result<Pixels, FileError> {
    image::read_pixels(path).map_err(|e| file_error(path, e))
}

/// Decodes an image in memory; `path` serves error messages only.
pub fn decode(bytes: &[u8], path: &Path) -> Result<Pixels, FileError> {
    image::decode(bytes, path).map_err(|e| file_error(path, e))
}

fn file_error(path: &Path, error: ImageError) -> FileError {
    match error {
        ImageError::Io { source, .. } => FileError::new(path, format_args!("cannot read: {source}")),
        ImageError::Content { reason, .. } => FileError::new(path, reason),
        other => FileError::new(path, other),
    }
}
