//! Text of files, in the encoding that they have.

use super::error::FileError;
use encoding_rs::{Encoding, REPLACEMENT, UTF_8, UTF_16BE, UTF_16LE, WINDOWS_1252};
use std::path::Path;

/// Decodes text. A byte order mark decides, else what an XML declaration says. Without either it is UTF-8, or
/// Windows-1252 (which contains ISO-8859-1) where it is no valid UTF-8: names and comments of old scenes are.
///
/// # Errors
/// An encoding that is not known, or characters that the encoding does not have.
pub fn decode(bytes: &[u8], path: &Path) -> Result<String, FileError> {
    let (encoding, bytes) = match Encoding::for_bom(bytes) {
        Some((encoding, length)) => (encoding, &bytes[length..]),
        None if bytes.starts_with(b"<\0") => (UTF_16LE, bytes),
        None if bytes.starts_with(b"\0<") => (UTF_16BE, bytes),
        None => (declared(bytes, path)?.unwrap_or(UTF_8), bytes),
    };
    match encoding.decode_without_bom_handling_and_without_replacement(bytes) {
        Some(text) => Ok(text.into_owned()),
        None if encoding == UTF_8 => Ok(WINDOWS_1252.decode_without_bom_handling(bytes).0.into_owned()),
        None => Err(FileError::new(path, format_args!("damaged {} text", encoding.name()))),
    }
}

/// The encoding that an XML declaration names.
fn declared(bytes: &[u8], path: &Path) -> Result<Option<&'static Encoding>, FileError> {
    let declaration = bytes.strip_prefix(b"<?xml").and_then(|rest| rest.split(|&b| b == b'>').next());
    let declaration = declaration.unwrap_or_default();
    let declaration = String::from_utf8_lossy(&declaration[..declaration.len().min(200)]);
    let Some((_, value)) = declaration.split_once("encoding") else { return Ok(None) };
    let value = value.trim_start().strip_prefix('=').unwrap_or_default().trim_start();
    let label =
        value.chars().next().filter(|c| matches!(c, '"' | '\'')).and_then(|quote| value[1..].split(quote).next());
    let Some(label) = label else { return Ok(None) };
    match Encoding::for_label(label.as_bytes()) {
        // A declaration that can be read byte by byte is not in UTF-16, whatever it says.
        Some(encoding) if [UTF_16LE, UTF_16BE].contains(&encoding) => Ok(None),
        Some(encoding) if encoding != REPLACEMENT => Ok(Some(encoding)),
        _ => Err(FileError::new(path, format_args!("the encoding `{label}` is not known"))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(bytes: &[u8]) -> Result<String, String> {
        decode(bytes, Path::new("f")).map_err(|e| e.to_string())
    }

    #[test]
    fn marks_and_declarations() {
        let utf16 = |big: bool, mark: bool| -> Vec<u8> {
            let units = mark.then_some(0xfeff).into_iter().chain("<a>ü</a>".encode_utf16());
            units.flat_map(|u| if big { u.to_be_bytes() } else { u.to_le_bytes() }).collect()
        };
        for (big, mark) in [(false, false), (false, true), (true, false), (true, true)] {
            assert_eq!(text(&utf16(big, mark)).unwrap(), "<a>ü</a>");
        }
        assert_eq!(text("\u{feff}ü".as_bytes()).unwrap(), "ü");
        assert_eq!(text("ü".as_bytes()).unwrap(), "ü");
        assert_eq!(text(b"500 1 # \xb5m").unwrap(), "500 1 # µm");
        let latin = |label: &str| [format!("<?xml version='1.0' encoding='{label}'?>").as_bytes(), b"\xe9"].concat();
        for label in ["ISO-8859-1", "latin1", "windows-1252", "iso-8859-15", "utf-8"] {
            assert!(text(&latin(label)).unwrap().ends_with('é'), "{label}");
        }
        assert!(text(&latin("koi8-r")).unwrap().ends_with('И'));
        assert!(text(b"<?xml version='1.0' encoding = \"utf-16\" ?>a").unwrap().ends_with('a'));
        assert_eq!(text(&latin("x-user")).unwrap_err(), "f: the encoding `x-user` is not known");
        assert_eq!(text(&latin("shift_jis")).unwrap_err(), "f: damaged Shift_JIS text");
        for broken in ["<?xml", "<?xml encoding", "<?xml encoding=", "<?xml encoding='", "<?xml encoding=é>"] {
            assert_eq!(text(broken.as_bytes()).unwrap_or_default().is_empty(), broken.ends_with('\''), "{broken}");
        }
    }
}
