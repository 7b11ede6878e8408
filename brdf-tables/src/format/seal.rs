//! The frame of a file: magic, version, header and payload under a checksum.

use super::{FormatError, MAX_HEADER};
use serde::Serialize;
use serde::de::DeserializeOwned;

fn config() -> impl bincode::config::Config {
    bincode::config::legacy().with_limit::<MAX_HEADER>()
}

/// The bytes of a file.
///
/// # Errors
/// If the header is longer than 1 MiB.
pub(crate) fn seal(
    magic: [u8; 8],
    version: u32,
    header: &impl Serialize,
    payload: &[u8],
) -> Result<Vec<u8>, FormatError> {
    let header = bincode::serde::encode_to_vec(header, config()).map_err(|e| FormatError::Header(e.to_string()))?;
    if header.len() > MAX_HEADER {
        return Err(FormatError::Header(format!("{} bytes, at most {MAX_HEADER} fit", header.len())));
    }
    let mut bytes = magic.to_vec();
    bytes.extend(version.to_le_bytes());
    bytes.extend((header.len() as u32).to_le_bytes());
    bytes.extend(header);
    bytes.extend(payload);
    bytes.extend(crc32fast::hash(&bytes).to_le_bytes());
    Ok(bytes)
}

/// What is within the frame.
pub(crate) struct Opened<'a, H> {
    pub version: u32,
    pub header: H,
    pub payload: &'a [u8],
}

/// Version, header and payload of the bytes of a file that begins with `magic`, if it is of a version that is `known`.
///
/// # Errors
/// Whatever is wrong with them but for the magic number, which gives `None`.
pub(crate) fn open<H: DeserializeOwned>(
    bytes: &[u8],
    magic: [u8; 8],
    known: impl Fn(u32) -> bool,
) -> Result<Option<Opened<'_, H>>, FormatError> {
    let length =
        |what, expected: usize| FormatError::Length { what, expected: expected as u64, found: bytes.len() as u64 };
    let word = |at: usize| bytes.get(at..at + 4).and_then(|b| b.first_chunk()).map(|b| u32::from_le_bytes(*b));
    if bytes.len() < 8 || bytes[..8] != magic {
        return Ok(None);
    }
    let version = word(8).ok_or_else(|| length("the version", 12))?;
    if !known(version) {
        return Err(FormatError::Version(version));
    }
    let size = word(12).ok_or_else(|| length("the header", 16))? as usize;
    if size > MAX_HEADER {
        return Err(FormatError::Header(format!("{size} bytes, at most {MAX_HEADER} are allowed")));
    }
    let end = bytes.len().saturating_sub(4);
    if end < 16 + size {
        return Err(length("the header", 20 + size));
    }
    let (expected, found) = (word(end).unwrap_or(0), crc32fast::hash(&bytes[..end]));
    if expected != found {
        return Err(FormatError::Checksum { expected, found });
    }
    let (header, used): (H, usize) = bincode::serde::decode_from_slice(&bytes[16..16 + size], config())
        .map_err(|e| FormatError::Header(e.to_string()))?;
    if used != size {
        return Err(FormatError::Header(format!("{used} of its {size} bytes are used")));
    }
    Ok(Some(Opened { version, header, payload: &bytes[16 + size..end] }))
}
