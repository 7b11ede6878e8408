//! Images of scenes, by the reader of all pictures.

use super::error::{FileError, read_file};
use crate::image::{self, ImageError};
use std::path::Path;

pub use crate::image::{Pixels, from_srgb as srgb_to_linear};

/// Larger image files are refused.
const MAX_FILE: u64 = 1 << 31;

/// Reads an image file, recognised by its first bytes.
pub fn read(path: &Path) -> Result<Pixels, FileError> {
    decode(&read_file(path, MAX_FILE)?, path)
}

/// Decodes an image in memory; `path` serves error messages only.
pub fn decode(bytes: &[u8], path: &Path) -> Result<Pixels, FileError> {
    image::decode(bytes, path).map_err(|error| match error {
        ImageError::Content { reason, .. } => FileError::new(path, reason),
        other => FileError::new(path, other),
    })
}
