//! Wavefront OBJ: `v`, `vt`, `vn` and polygonal `f`; groups are ignored, and materials by those who take them from a
//! scene file.
//!
//! Our own reader because errors must name the line, and because files hold what the format does not allow. The text is
//! read in pieces, many at a time; what depends on all that came before (indices, shared vertices) follows in order.

mod chunk;

use super::Parsed;
use super::corners::Corners;
use super::polygon::Splitter;
use super::text::{skip_mark, whole_lines};
use crate::scene::{Mesh, load::error::FileError};
use chunk::{ABSENT, Chunk, Corner, Counts, Ignored, KINDS, Wrong};
use glam::{Vec2, Vec3};
use rayon::prelude::*;
use std::path::Path;

/// Bytes of a piece, about.
const PIECE: usize = 1 << 21;

/// Parses the bytes of an OBJ file; `path` serves error messages only.
///
/// Corners that agree in position, texture coordinate and normal share a vertex. Names and comments may hold any bytes.
/// A corner without texture coordinates, in a file that has some, gets (0, 0), one without a normal a zero vector.
/// `v` of texture coordinates is turned over (OBJ has its origin at the bottom, this crate at the top) unless `keep_v`.
///
/// # Errors
/// Numbers and indices that are none, naming the line; a file of something else.
pub fn parse(bytes: &[u8], path: &Path, keep_v: bool) -> Result<Parsed, FileError> {
    parse_with(bytes, path, keep_v, &mut Materials::default())
}

/// What an OBJ file says of materials.
#[derive(Debug, Default)]
pub struct Materials {
    /// Files that hold them, as named.
    pub files: Vec<String>,
    /// From which triangle on which material holds.
    pub begins: Vec<(usize, String)>,
}

/// [`parse`], with the materials.
///
/// # Errors
/// As [`parse`].
pub fn parse_with(bytes: &[u8], path: &Path, keep_v: bool, materials: &mut Materials) -> Result<Parsed, FileError> {
    parse_pieces(bytes, path, keep_v, materials, PIECE)
}

fn parse_pieces(
    bytes: &[u8],
    path: &Path,
    keep_v: bool,
    materials: &mut Materials,
    piece: usize,
) -> Result<Parsed, FileError> {
    let pieces = whole_lines(skip_mark(bytes, path)?, piece);
    let chunks: Vec<Chunk> = pieces.into_par_iter().map(|piece| Chunk::read(piece, keep_v)).collect();
    let mut built = Builder::default();
    let (mut line, mut is_obj, mut ignored) = (0, None, Ignored::default());
    for mut chunk in chunks {
        is_obj = if is_obj == Some(true) { is_obj } else { chunk.is_obj.or(is_obj) };
        let lines = chunk.lines;
        ignored.append(std::mem::take(&mut chunk.ignored));
        built.add(chunk, materials).map_err(|(within, what)| FileError::at(path, line + within, what))?;
        line += lines;
    }
    if is_obj == Some(false) {
        return Err(FileError::new(path, "not an OBJ file: no line begins with a word of the format"));
    }
    Ok(built.finish(ignored))
}

/// The mesh as far as its faces are read.
#[derive(Default)]
struct Builder {
    mesh: Mesh,
    corners: Corners<(Option<u32>, Option<u32>)>,
    splitter: Splitter,
    /// Vertices of the face being read.
    face: Vec<u32>,
    small_faces: usize,
    /// Attribute lists as they stand in the file.
    positions: Vec<Vec3>,
    uvs: Vec<Vec2>,
    normals: Vec<Vec3>,
}

impl Builder {
    /// Adds the next piece. An error is of a line of it.
    fn add(&mut self, chunk: Chunk, materials: &mut Materials) -> Result<(), (usize, String)> {
        let before: Counts = [self.positions.len(), self.uvs.len(), self.normals.len()];
        let held: Counts = [chunk.positions.len(), chunk.uvs.len(), chunk.normals.len()];
        let sum = |counts: Counts| [0, 1, 2].map(|kind| before[kind] + counts[kind]);
        // Faces may refer to what comes after them in the piece: no index passes that is not given yet.
        self.positions.extend(chunk.positions);
        self.uvs.extend(chunk.uvs);
        self.normals.extend(chunk.normals);
        materials.files.extend(chunk.files);
        let (mut begins, mut given) = (chunk.begins.into_iter().peekable(), chunk.given.iter().peekable());
        let (mut start, mut counts) = (0, before);
        for (i, face) in chunk.faces.iter().enumerate() {
            while let Some((_, name)) = begins.next_if(|(first, _)| *first <= i) {
                materials.begins.push((self.mesh.triangles.len(), name));
            }
            if let Some((_, new)) = given.next_if(|(first, _)| *first == i) {
                counts = sum(*new);
            }
            self.face.clear();
            for corner in &chunk.corners[start..face.end] {
                self.corner(corner, &counts).map_err(|what| (face.line, what))?;
            }
            start = face.end;
            self.close_face();
        }
        materials.begins.extend(begins.map(|(_, name)| (self.mesh.triangles.len(), name)));
        let Some((line, wrong)) = chunk.wrong else { return Ok(()) };
        // The corners before the wrong one of its face are wrong before it.
        counts = sum(held);
        for corner in &chunk.corners[start..] {
            self.corner(corner, &counts).map_err(|what| (line, what))?;
        }
        let what = match wrong {
            Wrong::Anyway(what) => what,
            Wrong::Index { kind, written } => out_of_range(kind, written, &counts),
            Wrong::Position(at) => format!("vertex {} lies at {at}: not finite", counts[0] + 1),
        };
        Err((line, what))
    }

    /// Adds a corner to the face, where so much is given.
    #[inline]
    fn corner(&mut self, written: &Corner, counts: &Counts) -> Result<(), String> {
        let position = index(0, written[0], counts)?.unwrap_or_default();
        let (uv, normal) = (index(1, written[1], counts)?, index(2, written[2], counts)?);
        let (vertex, new) = self.corners.vertex(position, (uv, normal));
        self.face.push(vertex);
        if !new {
            return Ok(());
        }
        let Mesh { positions, uvs, normals, .. } = &mut self.mesh;
        // Attributes begin with the first corner that has one: those before it have none.
        if let Some(i) = uv {
            uvs.resize(positions.len(), Vec2::ZERO);
            uvs.push(self.uvs[i as usize]);
        }
        if let Some(i) = normal {
            normals.resize(positions.len(), Vec3::ZERO);
            normals.push(self.normals[i as usize]);
        }
        positions.push(self.positions[position as usize]);
        Ok(())
    }

    fn close_face(&mut self) {
        if self.face.len() < 3 {
            self.small_faces += 1;
        } else {
            self.splitter.split(&self.face, &self.mesh.positions, &mut self.mesh.triangles);
        }
    }

    fn finish(mut self, ignored: Ignored) -> Parsed {
        let count = self.mesh.positions.len();
        if !self.mesh.uvs.is_empty() {
            self.mesh.uvs.resize(count, Vec2::ZERO);
        }
        if !self.mesh.normals.is_empty() {
            self.mesh.normals.resize(count, Vec3::ZERO);
        }
        let small = (self.small_faces > 0)
            .then(|| format!("{} faces of fewer than three corners are not drawn", self.small_faces));
        Parsed::new(self.mesh, small.into_iter().chain(self.splitter.warning()).chain(ignored.warning()))
    }
}

/// The index from zero that a corner means; negative ones count from the end of what is given.
#[inline]
fn index(kind: usize, written: i32, counts: &Counts) -> Result<Option<u32>, String> {
    if written == ABSENT {
        return Ok(None);
    }
    let (count, written) = (counts[kind] as i64, i64::from(written));
    let zero_based = if written < 0 { written + count } else { written - 1 };
    if !(0..count).contains(&zero_based) {
        return Err(out_of_range(kind, written, counts));
    }
    // Indices are written in 31 bits, and no file holds more.
    Ok(Some(zero_based as u32))
}

#[cold]
fn out_of_range(kind: usize, written: i64, counts: &Counts) -> String {
    format!("{} {written} is out of range: {} given so far", KINDS[kind], counts[kind])
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\r\nv 1 1 0\nvt 0 0\nvt 1 0\nvn 0 0 1\nusemtl one\n\
        f 1/1/1 2/2/1 3//1\nf -3 -2 -1\nv 0 1 0 # more\nv 2 2 \\\n 0\nusemtl two\nf -1/-1 -2/-2/-1 1\nl 1 2\np 1\nl 2 3\n\
        f 1 2\nusemtl three\n";

    fn read(text: &str, piece: usize) -> Result<(Parsed, Materials), String> {
        let mut materials = Materials::default();
        let parsed = parse_pieces(text.as_bytes(), Path::new("m"), false, &mut materials, piece);
        parsed.map(|parsed| (parsed, materials)).map_err(|e| e.to_string())
    }

    #[test]
    fn pieces_of_any_size_make_one_mesh() {
        let (whole, materials) = read(TEXT, usize::MAX).unwrap();
        assert_eq!(whole.mesh.triangles, [[0, 1, 2], [3, 4, 5], [6, 7, 3]]);
        assert_eq!(materials.begins, [(0, "one".into()), (2, "two".into()), (3, "three".into())]);
        let warnings =
            ["1 faces of fewer than three corners", "lines, points and free-form surfaces are not drawn: 2 `l`, 1 `p`"];
        assert!(whole.warnings.iter().zip(warnings).all(|(w, start)| w.starts_with(start)), "{:?}", whole.warnings);
        for piece in 1..TEXT.len() {
            let (parsed, same) = read(TEXT, piece).unwrap();
            assert_eq!((&parsed.mesh, &parsed.warnings), (&whole.mesh, &whole.warnings), "{piece}");
            assert_eq!((same.files, same.begins), (materials.files.clone(), materials.begins.clone()), "{piece}");
        }
    }

    #[test]
    fn the_first_error_has_its_line_whatever_the_pieces() {
        for (text, error) in [
            ("f 9 x", "m:21: vertex 9 is out of range: 5 given so far"),
            ("f 1 2 3/3\nv x", "m:21: texture coordinate 3 is out of range: 2 given so far"),
            ("f 1 2 -6", "m:21: vertex -6 is out of range: 5 given so far"),
            ("f 0 1 2", "m:21: vertex 0 is out of range: 5 given so far"),
            ("f 1 99999999999 x", "m:21: vertex 99999999999 is out of range: 5 given so far"),
            ("f 1 1//-2147483648", "m:21: normal -2147483648 is out of range: 1 given so far"),
            ("v 0 0 0\nv 1 nan 0\nv", "m:22: vertex 7 lies at [1, NaN, 0]: not finite"),
            ("v 0 0\nf 9", "m:21: expected 3 numbers, found 2"),
            ("# f\n\nf 1 2 3,\nf 9", "m:23: `3,` is not an index"),
        ] {
            for piece in [1, 5, 20, 60, usize::MAX] {
                assert_eq!(read(&format!("{TEXT}{text}\n"), piece).unwrap_err(), error, "{piece}");
            }
        }
        for piece in [1, usize::MAX] {
            assert!(read("these are\nno words\n", piece).unwrap_err().starts_with("m: not an OBJ file"));
        }
    }
}
