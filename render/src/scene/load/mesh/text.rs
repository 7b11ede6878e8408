//! What the text of mesh files has in common: marks, line ends, words and numbers, as other programs write them.

use crate::scene::load::error::FileError;
use std::borrow::Cow;
use std::path::Path;

/// The bytes behind a byte order mark of UTF-8; UTF-16 is refused by name.
pub fn skip_mark<'a>(bytes: &'a [u8], path: &Path) -> Result<&'a [u8], FileError> {
    if bytes.starts_with(b"\xff\xfe") || bytes.starts_with(b"\xfe\xff") {
        return Err(FileError::new(path, "UTF-16 text is not supported: save the file as UTF-8"));
    }
    Ok(bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes))
}

/// The words of a line.
pub fn words(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    let mut rest = line;
    std::iter::from_fn(move || {
        let start = rest.iter().position(|b| !b.is_ascii_whitespace())?;
        let word = &rest[start..];
        let end = word.iter().position(u8::is_ascii_whitespace).unwrap_or(word.len());
        rest = &word[end..];
        Some(&word[..end])
    })
}

/// What follows the first word of a line; names may hold blanks.
pub fn argument(line: &[u8]) -> String {
    let line = line.trim_ascii();
    let end = line.iter().position(u8::is_ascii_whitespace).unwrap_or(line.len());
    String::from_utf8_lossy(line[end..].trim_ascii()).into_owned()
}

/// A word as a message shows it: short, one line, whatever it holds.
pub fn quote(word: &[u8]) -> String {
    const LONGEST: usize = 40;
    let shown: String = String::from_utf8_lossy(word).chars().take(LONGEST).flat_map(char::escape_debug).collect();
    if word.len() > LONGEST { format!("`{shown}…`") } else { format!("`{shown}`") }
}

/// A decimal number; also NaN and infinity as C libraries print them (`-nan(ind)`, `1.#INF`).
#[inline]
pub fn number<T: std::str::FromStr>(word: &[u8]) -> Option<T> {
    let text = str::from_utf8(word).ok()?;
    text.parse().ok().or_else(|| not_finite(text))
}

#[cold]
fn not_finite<T: std::str::FromStr>(text: &str) -> Option<T> {
    let (sign, size) = if let Some(size) = text.strip_prefix('-') { ("-", size) } else { ("", text) };
    let size = size.trim_start_matches('+').to_ascii_lowercase();
    if size.starts_with("1.#inf") {
        format!("{sign}inf").parse().ok()
    } else if size.starts_with("nan") || size.starts_with("1.#") {
        "nan".parse().ok()
    } else {
        None
    }
}

/// A whole number, or what `number` makes of it.
#[inline]
pub fn integer(word: &[u8]) -> Option<i64> {
    // Indices are most of a mesh file's text: the common ones take no detour.
    const SHORT: usize = 18;
    let digit = |n, byte: &u8| byte.is_ascii_digit().then(|| 10 * n + i64::from(byte - b'0'));
    let common = if (1..=SHORT).contains(&word.len()) { word.iter().try_fold(0, digit) } else { None };
    common.or_else(|| number(word))
}

/// Number, counted from 1, of the line in which the byte at `offset` stands.
pub fn line_number(bytes: &[u8], offset: usize) -> usize {
    let before = &bytes[..offset.min(bytes.len())];
    let ends = |i: usize, b: u8| b == b'\n' || (b == b'\r' && bytes.get(i + 1) != Some(&b'\n'));
    1 + before.iter().enumerate().filter(|&(i, &b)| ends(i, b)).count()
}

/// Lines with their numbers, counted from 1. LF, CR LF and CR alone end a line; a line that ends with `\` goes on in
/// the next one, unless it holds a comment (comments may end with the name of a folder).
pub struct Lines<'a> {
    rest: &'a [u8],
    number: usize,
}

impl<'a> Lines<'a> {
    pub fn new(bytes: &'a [u8]) -> Self {
        Self { rest: bytes, number: 0 }
    }

    /// How many lines of the file were read.
    pub fn read(&self) -> usize {
        self.number
    }

    /// The next line as it stands in the file.
    fn physical(&mut self) -> &'a [u8] {
        self.number += 1;
        let end = memchr::memchr2(b'\n', b'\r', self.rest).unwrap_or(self.rest.len());
        let (line, rest) = self.rest.split_at(end);
        self.rest = rest.strip_prefix(b"\r\n").unwrap_or(rest.get(1..).unwrap_or_default());
        line
    }
}

impl<'a> Iterator for Lines<'a> {
    type Item = (usize, Cow<'a, [u8]>);

    fn next(&mut self) -> Option<Self::Item> {
        if self.rest.is_empty() {
            return None;
        }
        let line = self.physical();
        let number = self.number;
        if continued(line).is_none() || line.contains(&b'#') {
            return Some((number, line.into()));
        }
        let (mut joined, mut last) = (Vec::new(), line);
        while let Some(part) = continued(last) {
            joined.extend_from_slice(part);
            joined.push(b' ');
            last = self.physical();
        }
        joined.extend_from_slice(last);
        Some((number, joined.into()))
    }
}

/// Cuts text between lines into pieces of about `size` bytes that can be read one without the other: no line goes on from
/// one into the next.
pub fn whole_lines(text: &[u8], size: usize) -> Vec<&[u8]> {
    let mut pieces = Vec::new();
    let mut rest = text;
    while !rest.is_empty() {
        let mut within = size.clamp(1, rest.len()) - 1;
        if within > 0 && rest[within - 1..].starts_with(b"\r\n") {
            within -= 1;
        }
        let start = memchr::memrchr2(b'\n', b'\r', &rest[..within]).map_or(0, |end| end + 1);
        let mut lines = Lines::new(&rest[start..]);
        while continued(lines.physical()).is_some() {}
        let (piece, after) = rest.split_at(rest.len() - lines.rest.len());
        pieces.push(piece);
        rest = after;
    }
    pieces
}

/// A line without the `\` at its end, if there is one.
fn continued(line: &[u8]) -> Option<&[u8]> {
    line.trim_ascii_end().strip_suffix(b"\\")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_end_of_line_counts_once() {
        let text = b"a\nb\r\nc\rd\\\r\ne \\ \nf\n# g\\\nh\\";
        let lines: Vec<_> = Lines::new(text).map(|(n, l)| (n, String::from_utf8_lossy(&l).into_owned())).collect();
        let expected = [(1, "a"), (2, "b"), (3, "c"), (4, "d e  f"), (7, "# g\\"), (8, "h ")];
        assert_eq!(lines, expected.map(|(n, l)| (n, l.to_owned())));
        assert_eq!(line_number(text, text.len()), 8);
    }

    #[test]
    fn pieces_end_with_lines() {
        let text = b"a\nbc\r\nd \\\ne\r\rf\\\r\ng";
        for size in 1..=text.len() + 1 {
            let pieces = whole_lines(text, size);
            assert_eq!(pieces.concat(), text, "{size}");
            let lines = pieces.iter().flat_map(|piece| Lines::new(piece)).map(|(_, line)| line.into_owned());
            let whole: Vec<_> = Lines::new(text).map(|(_, line)| line.into_owned()).collect();
            assert_eq!(lines.collect::<Vec<_>>(), whole, "{size}");
        }
        assert_eq!(whole_lines(text, 1), [&b"a\n"[..], b"bc\r\n", b"d \\\ne\r", b"\r", b"f\\\r\ng"]);
        assert!(whole_lines(b"", 1).is_empty());
    }

    #[test]
    fn numbers_as_they_are_printed() {
        for (word, value) in [("1.", 1.0), (".5", 0.5), ("+3", 3.0), ("1E5", 1e5), ("-1.#INF", f32::NEG_INFINITY)] {
            assert_eq!(number::<f32>(word.as_bytes()), Some(value), "{word}");
        }
        for word in ["nan", "-nan(ind)", "NaN", "1.#QNAN", "-1.#IND00"] {
            assert!(number::<f32>(word.as_bytes()).is_some_and(f32::is_nan), "{word}");
        }
        for word in ["1,5", "", "x", "1.5x", "\u{b2}"] {
            assert_eq!(number::<f32>(word.as_bytes()), None, "{word}");
        }
        assert_eq!(quote(b"\xff\x1b[1m"), "`\u{fffd}\\u{1b}[1m`");
    }
}
