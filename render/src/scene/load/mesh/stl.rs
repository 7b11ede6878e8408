//! STL, binary and text.
//!
//! Our own reader: those there are take a binary file for text where its header begins with `solid`, as many do, and text
//! only as one program writes it.

use super::Parsed;
use super::text::{Lines, number, quote, skip_mark, words};
use crate::scene::{Mesh, load::error::FileError};
use glam::Vec3;
use std::path::Path;

/// Bytes before the triangles of a binary file: a text, and the number of triangles.
const HEADER: usize = 84;
/// Bytes of a triangle: a normal, three corners, two bytes of anything.
const TRIANGLE: usize = 50;

/// Parses the bytes of an STL file; `path` serves error messages only. Normals are those of the triangles, not the
/// file's, which often has none.
///
/// # Errors
/// A file that is cut off, coordinates that are none, naming the line; a file of something else, or without triangles.
pub fn parse(bytes: &[u8], path: &Path) -> Result<Parsed, FileError> {
    let positions = match binary(bytes) {
        Some(positions) => positions,
        None if is_text(bytes) => text(skip_mark(bytes, path)?, path)?,
        None => {
            let promised = bytes.get(HEADER - 4..HEADER).map_or(0, |n| u32::from_le_bytes([n[0], n[1], n[2], n[3]]));
            let held = bytes.len().saturating_sub(HEADER) / TRIANGLE;
            let what =
                format!("not an STL file, or cut off: {promised} triangles are promised, of which it holds {held}");
            return Err(FileError::new(path, what));
        }
    };
    if positions.is_empty() {
        return Err(FileError::new(path, "no triangles"));
    }
    let triangles = (0..positions.len() as u32 / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let mesh = Mesh { triangles, positions, ..Mesh::default() };
    Ok(Parsed { face_normals: true, ..Parsed::new(mesh, []) })
}

/// Text begins with `solid`, and holds no zeros, which a binary file with such a header does.
fn is_text(bytes: &[u8]) -> bool {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes).trim_ascii_start();
    bytes.get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"solid")) && !bytes.contains(&0)
}

/// Corners of a binary file; `None` where it does not hold what it promises, or is text of that length.
fn binary(bytes: &[u8]) -> Option<Vec<Vec3>> {
    let (count, body) = (bytes.get(HEADER - 4..HEADER)?, &bytes[HEADER..]);
    let size = (u32::from_le_bytes(count.try_into().ok()?) as usize).checked_mul(TRIANGLE)?;
    // Text promises hundreds of millions of triangles here.
    let body = body.get(..size)?;
    let number = |b: &[u8]| f32::from_le_bytes([b[0], b[1], b[2], b[3]]);
    let corner = |b: &[u8]| Vec3::new(number(b), number(&b[4..]), number(&b[8..]));
    Some(body.chunks_exact(TRIANGLE).flat_map(|t| [corner(&t[12..]), corner(&t[24..]), corner(&t[36..])]).collect())
}

/// Corners of a text: the three numbers after every `vertex`.
fn text(bytes: &[u8], path: &Path) -> Result<Vec<Vec3>, FileError> {
    let mut positions = Vec::new();
    for (line_number, line) in Lines::new(bytes) {
        let mut words = words(&line);
        while let Some(word) = words.next() {
            if word.eq_ignore_ascii_case(b"solid") || word.eq_ignore_ascii_case(b"endsolid") {
                // A name follows, which may be anything.
                break;
            }
            if !word.eq_ignore_ascii_case(b"vertex") {
                continue;
            }
            let mut corner = [0.0; 3];
            for value in &mut corner {
                let word = words.next().unwrap_or_default();
                let what = || FileError::at(path, line_number, format_args!("{} is no coordinate", quote(word)));
                *value = number(word).ok_or_else(what)?;
            }
            positions.push(Vec3::from_array(corner));
        }
    }
    if !positions.len().is_multiple_of(3) {
        return Err(FileError::new(path, format_args!("{} corners: triangles have three each", positions.len())));
    }
    Ok(positions)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn corners(bytes: &[u8]) -> Result<Vec<Vec3>, String> {
        parse(bytes, Path::new("f")).map(|p| p.mesh.positions).map_err(|e| e.to_string())
    }

    #[test]
    fn binary_and_text() {
        let expected = vec![Vec3::ZERO, Vec3::X, Vec3::new(0.0, 2.5, -1.0)];
        let body: Vec<u8> = [0.0f32; 3]
            .into_iter()
            .chain(expected.iter().flat_map(|p| p.to_array()))
            .flat_map(f32::to_le_bytes)
            .chain([0, 0])
            .collect();
        for head in ["", "solid of a program that writes binary"] {
            let mut header = head.as_bytes().to_vec();
            header.resize(80, b' ');
            let file = [&header[..], &1u32.to_le_bytes(), &body].concat();
            assert_eq!(corners(&file).unwrap(), expected);
            assert_eq!(corners(&[&file[..], b"more"].concat()).unwrap(), expected);
            let cut = corners(&file[..100]).unwrap_err();
            assert!(cut.contains("cut off"), "{cut}");
        }
        for solid in ["solid", "SOLID vertex 1\r\n", "  solid x\n"] {
            let text = format!(
                "{solid}\nFACET normal 0 0 1 outer loop\nvertex 0 0 0\r\nvertex 1 0 0 Vertex 0 2.5 -1\nendloop endfacet\nendsolid vertex"
            );
            assert_eq!(corners(text.as_bytes()).unwrap(), expected, "{solid}");
        }
        assert_eq!(corners(b"solid\nvertex 1 x 3").unwrap_err(), "f:2: `x` is no coordinate");
        assert_eq!(corners(b"solid\nvertex 1 2").unwrap_err(), "f:2: `` is no coordinate");
        assert_eq!(corners(b"solid\nvertex 1 2 3").unwrap_err(), "f: 1 corners: triangles have three each");
        assert_eq!(corners(b"solid\nendsolid").unwrap_err(), "f: no triangles");
        assert!(corners(b"").unwrap_err().contains("not an STL file"));
        let huge = [&[b' '; 80][..], &u32::MAX.to_le_bytes()].concat();
        assert!(corners(&huge).unwrap_err().contains("4294967295 triangles are promised, of which it holds 0"));
    }
}
