//! What URIs of glTF stand for: data inside them (RFC 2397), or files beside the scene.

use crate::scene::load::error::{FileError, read_file};
use crate::scene::load::files::Folders;
use base64::Engine;
use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use std::path::{Path, PathBuf};

/// Padding that is missing and bits that are left over do no harm.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &STANDARD,
    GeneralPurposeConfig::new()
        .with_decode_padding_mode(DecodePaddingMode::Indifferent)
        .with_decode_allow_trailing_bits(true),
);

const SCHEME: &str = "data:";

/// Content of a data URI; `None` for other URIs. The error never holds the data.
pub fn data(uri: &str) -> Option<Result<Vec<u8>, String>> {
    is_data(uri).then(|| decode(&uri.trim_start()[SCHEME.len()..]))
}

/// Whether a URI holds its data.
pub fn is_data(uri: &str) -> bool {
    uri.trim_start().get(..SCHEME.len()).is_some_and(|scheme| scheme.eq_ignore_ascii_case(SCHEME))
}

fn decode(rest: &str) -> Result<Vec<u8>, String> {
    let (head, body) = rest.split_once(',').ok_or("a data URI without a comma")?;
    let bytes = percent_decoded(body);
    let is_base64 = head.rsplit(';').next().is_some_and(|last| last.trim().eq_ignore_ascii_case("base64"));
    if !is_base64 || !head.contains(';') {
        return Ok(bytes);
    }
    // The alphabet made for URLs is taken too, and lines may be broken.
    let plain = |b: u8| match b {
        b'-' => b'+',
        b'_' => b'/',
        b => b,
    };
    let text: Vec<u8> = bytes.into_iter().filter(|b| !b.is_ascii_whitespace()).map(plain).collect();
    BASE64.decode(text).map_err(|e| format!("a data URI: {e}"))
}

/// Bytes of a text, its `%20` and the like undone.
fn percent_decoded(text: &str) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(text.len());
    let mut rest = text.as_bytes();
    while let Some((&first, tail)) = rest.split_first() {
        let digit = |i: usize| tail.get(i).and_then(|b| (*b as char).to_digit(16));
        match (first, digit(0), digit(1)) {
            (b'%', Some(high), Some(low)) => {
                bytes.push((high * 16 + low) as u8);
                rest = &tail[2..];
            }
            _ => {
                bytes.push(first);
                rest = tail;
            }
        }
    }
    bytes
}

/// Path of a file that a URI without data names in a glTF file at `path`.
pub fn path_of(path: &Path, uri: &str) -> Result<PathBuf, FileError> {
    place(path, &beside_it(path), uri)
}

fn beside_it(path: &Path) -> Folders {
    Folders(vec![path.parent().unwrap_or(Path::new("")).into()])
}

/// The name is tried as it is, too.
fn place(path: &Path, folders: &Folders, uri: &str) -> Result<PathBuf, FileError> {
    if let Some((scheme @ ("http" | "https" | "ftp"), _)) = uri.split_once(':') {
        return Err(FileError::new(path, format_args!("a file of the network ({scheme}) is not fetched")));
    }
    let uri = uri.strip_prefix("file://").unwrap_or(uri);
    let decoded = folders.resolve(path, &String::from_utf8_lossy(&percent_decoded(uri)));
    let plain = folders.resolve(path, uri);
    Ok(if decoded.exists() || !plain.exists() { decoded } else { plain })
}

/// Reads the file that a URI without data names.
pub fn file(path: &Path, uri: &str, limit: u64) -> Result<Vec<u8>, FileError> {
    beside(path, uri, |file| read_file(file, limit))
}

/// Reads, with `read`, the file that a URI without data names.
pub fn beside<T>(path: &Path, uri: &str, read: impl FnOnce(&Path) -> Result<T, FileError>) -> Result<T, FileError> {
    let folders = beside_it(path);
    read(&place(path, &folders, uri)?).map_err(|e| folders.advise(path, uri, e))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_spelling_of_data() {
        for uri in [
            "data:application/octet-stream;base64,/+8B",
            "DATA:Application/Octet-Stream;BASE64,/+8B",
            "data:;base64,/+8B",
            " data:text/plain;charset=utf-8;Base64,/+8B",
            "data:;base64 ,_-8B",
            "data:;base64,%2F%2b8B",
            "data:;base64,/+\n8B\r\n ",
            "data:;base64,%2F+8B%0A",
            "data:,%ff%EF%01",
            "data:text/plain;charset=utf-8,%FF%ef%01",
        ] {
            assert_eq!(data(uri).unwrap().unwrap(), [0xff, 0xef, 0x01], "{uri}");
        }
        for padding in ["", "=", "=="] {
            assert_eq!(data(&format!("data:;base64,/w{padding}")).unwrap().unwrap(), [0xff]);
        }
        assert_eq!(data("data:base64,QUJD").unwrap().unwrap(), b"QUJD");
        assert_eq!(data("data:,100%").unwrap().unwrap(), b"100%");
        assert!(data("data.bin").is_none() && data("é").is_none() && data("").is_none());
        assert_eq!(data("data:;base64").unwrap().unwrap_err(), "a data URI without a comma");
        let long = format!("data:;base64,{}!", "A".repeat(1000));
        assert!(data(&long).unwrap().unwrap_err().len() < 80);
    }
}
