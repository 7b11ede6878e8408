//! The two containers of glTF: JSON alone, or GLB, chunks of JSON and binary data.

use crate::scene::load::error::FileError;
use crate::scene::load::text;
use std::path::Path;

/// Bytes before the first chunk of a GLB file.
const HEADER: usize = 12;

/// JSON and binary chunk of a file, told apart by its first bytes, not by its name.
pub fn open<'a>(bytes: &'a [u8], path: &Path) -> Result<(String, Option<&'a [u8]>), FileError> {
    if !bytes.starts_with(b"glTF") {
        return Ok((text::decode(bytes, path)?, None));
    }
    let error = |what: &str| FileError::new(path, what);
    let number = |at: usize| bytes.get(at..at + 4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]) as usize);
    let (Some(version), Some(length)) = (number(4), number(8)) else { return Err(error("truncated GLB header")) };
    if version != 2 {
        return Err(FileError::new(path, format_args!("GLB of version {version}: only version 2 is read")));
    }
    if length < HEADER || length > bytes.len() {
        let what = format!("truncated: {} bytes, but its header promises {length}", bytes.len());
        return Err(error(&what));
    }
    // The first chunk is JSON; of the others the first that is binary counts, and unknown ones are skipped.
    let (mut json, mut blob, mut at) = (None, None, HEADER);
    while at + 8 <= length {
        let (Some(size), Some(kind)) = (number(at), bytes.get(at + 4..at + 8)) else { break };
        let end = (at + 8).checked_add(size).filter(|end| *end <= bytes.len());
        let chunk = end.and_then(|end| bytes.get(at + 8..end));
        let chunk = chunk.ok_or_else(|| error("truncated: a chunk leaves the file"))?;
        match kind {
            b"JSON" if json.is_none() => json = Some(chunk),
            b"BIN\0" if blob.is_none() => blob = Some(chunk),
            _ => {}
        }
        at += 8 + size;
    }
    let json = json.ok_or_else(|| error("a GLB file without JSON"))?;
    // Blanks pad it; some writers use zeros.
    let used = json.iter().rposition(|b| *b != 0).map_or(0, |last| last + 1);
    Ok((text::decode(&json[..used], path)?, blob))
}
