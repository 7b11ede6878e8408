//! A note in a picture file: what a program wants to know again of it.

use super::ImageError;
use super::write::{content, extension};
use exr::meta::MetaData;
use std::path::Path;

/// Keyword of a note in PNG.
const KEYWORD: &[u8] = b"Comment\0";
/// Where the header of a PNG ends, and what begins it.
const PNG_HEADER: usize = 33;
const PNG: &[u8] = b"\x89PNG\r\n\x1a\n";

/// Adds a note to the bytes of a PNG.
pub(super) fn into_png(png: &mut Vec<u8>, note: &str) {
    let mut chunk = b"tEXt".to_vec();
    chunk.extend(KEYWORD);
    chunk.extend(note.bytes());
    let length = (chunk.len() - 4) as u32;
    let checksum = crc32fast::hash(&chunk);
    let chunk = length.to_be_bytes().into_iter().chain(chunk).chain(checksum.to_be_bytes());
    png.splice(PNG_HEADER..PNG_HEADER, chunk);
}

/// The note of the bytes of a PNG.
fn of_png(bytes: &[u8]) -> Option<String> {
    let mut rest = bytes.strip_prefix(PNG)?;
    while let Some((head, after)) = rest.split_first_chunk::<8>() {
        let length = u32::from_be_bytes([head[0], head[1], head[2], head[3]]) as usize;
        let (data, after) = after.split_at_checked(length)?;
        if &head[4..] == b"tEXt"
            && let Some(note) = data.strip_prefix(KEYWORD)
        {
            return String::from_utf8(note.to_vec()).ok();
        }
        rest = after.get(4..)?;
    }
    None
}

/// The note of an OpenEXR or PNG file, by its name; `None` where it has none, or no such form.
///
/// # Errors
/// A file that cannot be read.
pub fn read_note(path: &Path) -> Result<Option<String>, ImageError> {
    let bytes = std::fs::read(path).map_err(|error| ImageError::Io { path: path.display().to_string(), error })?;
    if extension(path) != "exr" {
        return Ok(of_png(&bytes));
    }
    let meta = MetaData::read_from_buffered(&bytes[..], false).map_err(|e| content(path, e))?;
    let text = meta.headers.first().and_then(|header| header.own_attributes.comments.as_ref());
    Ok(text.map(ToString::to_string))
}
