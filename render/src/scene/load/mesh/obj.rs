//! Wavefront OBJ: `v`, `vt`, `vn` and polygonal `f`; groups are ignored, and materials by those who take them from a
//! scene file.
//!
//! Our own reader because errors must name the line, and because files hold what the format does not allow.

use super::Parsed;
use super::corners::Corners;
use super::polygon::Splitter;
use super::text::{Lines, argument, integer, number, quote, skip_mark, words};
use crate::scene::{Mesh, load::error::FileError};
use glam::{Vec2, Vec3};
use std::path::Path;

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
    let mut source = Source::default();
    let mut built = Builder::default();
    let mut ignored = Ignored::default();
    let mut is_obj = None;
    for (number, line) in Lines::new(skip_mark(bytes, path)?) {
        let error = |what: String| FileError::at(path, number, what);
        let mut words = words(&line);
        let Some(word) = words.next().filter(|w| !w.starts_with(b"#")) else { continue };
        match word {
            b"v" => source.positions.push(source.position(words).map_err(error)?),
            b"vn" => source.normals.push(Vec3::from(floats(words, 3).map_err(error)?)),
            b"vt" => {
                let [u, v] = floats(words, 1).map_err(error)?;
                source.uvs.push(Vec2::new(u, if keep_v { v } else { 1.0 - v }));
            }
            b"f" => {
                built.face.clear();
                for word in words.take_while(|w| !w.starts_with(b"#")) {
                    let corner = source.corner(word).map_err(error)?;
                    built.corner(corner, &source);
                }
                built.close_face();
            }
            b"usemtl" => materials.begins.push((built.mesh.triangles.len(), argument(&line))),
            b"mtllib" => materials.files.push(argument(&line)),
            other if ignored.count(other) => {}
            _ => {
                is_obj.get_or_insert(false);
                continue;
            }
        }
        is_obj = Some(true);
    }
    if is_obj == Some(false) {
        return Err(FileError::new(path, "not an OBJ file: no line begins with a word of the format"));
    }
    Ok(built.finish(ignored))
}

/// The first `N` numbers of a line, of which `needed` must be there; the others are 0 where they are not.
fn floats<'a, const N: usize>(mut words: impl Iterator<Item = &'a [u8]>, needed: usize) -> Result<[f32; N], String> {
    let mut out = [0.0; N];
    for (i, value) in out.iter_mut().enumerate() {
        let Some(word) = words.next().filter(|w| i < needed || !w.starts_with(b"#")) else {
            if i < needed {
                return Err(format!("expected {needed} numbers, found {i}"));
            }
            break;
        };
        *value = number(word).ok_or_else(|| format!("{} is not a number", quote(word)))?;
    }
    Ok(out)
}

/// Attribute lists as they stand in the file.
#[derive(Default)]
struct Source {
    positions: Vec<Vec3>,
    uvs: Vec<Vec2>,
    normals: Vec<Vec3>,
}

/// Zero-based indices of a corner: position, texture coordinate, normal.
type Corner = (u32, Option<u32>, Option<u32>);

impl Source {
    /// The position of a line `v`; behind it there may be a weight or a colour.
    fn position<'a>(&self, words: impl Iterator<Item = &'a [u8]>) -> Result<Vec3, String> {
        let position = Vec3::from(floats(words, 3)?);
        if !position.is_finite() {
            return Err(format!("vertex {} lies at {position}: not finite", self.positions.len() + 1));
        }
        Ok(position)
    }

    /// Parses `p`, `p/t`, `p//n` or `p/t/n`; negative indices count from the end.
    fn corner(&self, word: &[u8]) -> Result<Corner, String> {
        let mut fields = word.split(|&b| b == b'/');
        let position = index(fields.next().unwrap_or_default(), self.positions.len(), "vertex")?;
        let uv = fields.next().filter(|f| !f.is_empty()).map(|f| index(f, self.uvs.len(), "texture coordinate"));
        let normal = fields.next().filter(|f| !f.is_empty()).map(|f| index(f, self.normals.len(), "normal"));
        Ok((position, uv.transpose()?, normal.transpose()?))
    }
}

#[inline]
fn index(field: &[u8], count: usize, what: &str) -> Result<u32, String> {
    let written = integer(field).ok_or_else(|| format!("{} is not an index", quote(field)))?;
    let zero_based = if written < 0 { written + count as i64 } else { written - 1 };
    if !(0..count as i64).contains(&zero_based) {
        return Err(format!("{what} {written} is out of range: {count} given so far"));
    }
    u32::try_from(zero_based).map_err(|_| format!("{what} {written} does not fit 32 bits"))
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
}

impl Builder {
    fn corner(&mut self, (position, uv, normal): Corner, source: &Source) {
        let (vertex, new) = self.corners.vertex(position, (uv, normal));
        self.face.push(vertex);
        if !new {
            return;
        }
        let Mesh { positions, uvs, normals, .. } = &mut self.mesh;
        // Attributes begin with the first corner that has one: those before it have none.
        if let Some(i) = uv {
            uvs.resize(positions.len(), Vec2::ZERO);
            uvs.push(source.uvs[i as usize]);
        }
        if let Some(i) = normal {
            normals.resize(positions.len(), Vec3::ZERO);
            normals.push(source.normals[i as usize]);
        }
        positions.push(source.positions[position as usize]);
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

/// Statements of the format that are not drawn.
#[derive(Default)]
struct Ignored {
    elements: Vec<(&'static str, usize)>,
}

impl Ignored {
    /// Whether the word is of the format; elements that would be seen are counted.
    fn count(&mut self, word: &[u8]) -> bool {
        const ELEMENTS: [&str; 5] = ["l", "p", "curv", "curv2", "surf"];
        const OTHERS: [&[u8]; 4] = [b"g", b"o", b"s", b"vp"];
        let Some(name) = ELEMENTS.iter().find(|name| name.as_bytes() == word) else { return OTHERS.contains(&word) };
        match self.elements.iter_mut().find(|(known, _)| known == name) {
            Some((_, count)) => *count += 1,
            None => self.elements.push((name, 1)),
        }
        true
    }

    fn warning(&self) -> Option<String> {
        let list: Vec<_> = self.elements.iter().map(|(name, count)| format!("{count} `{name}`")).collect();
        (!list.is_empty()).then(|| format!("lines, points and free-form surfaces are not drawn: {}", list.join(", ")))
    }
}
