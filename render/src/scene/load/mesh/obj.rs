//! Wavefront OBJ: `v`, `vt`, `vn` and polygonal `f`; groups and materials are ignored, as the scene file assigns them.
//!
//! Our own reader because errors must name the line.

use crate::scene::{Mesh, load::error::FileError};
use glam::{Vec2, Vec3};
use std::path::Path;

/// Parses the bytes of an OBJ file; `path` serves error messages only.
///
/// Corners that agree in position, texture coordinate and normal share a vertex. Polygons become fans. `v` of texture
/// coordinates is turned over (OBJ has its origin at the bottom, this crate at the top) unless `keep_v`.
pub fn parse(bytes: &[u8], path: &Path, keep_v: bool) -> Result<Mesh, FileError> {
    let mut source = Source::default();
    let mut mesh = Mesh::default();
    let mut corners = Corners::default();
    let mut fan = Vec::new();
    for (number, line) in bytes.split(|&b| b == b'\n').enumerate() {
        let error = |what: String| FileError::at(path, number + 1, what);
        let line = str::from_utf8(line).map_err(|_| error("not UTF-8 text".into()))?;
        let mut words = line.split_ascii_whitespace();
        match words.next() {
            Some("v") => source.positions.push(Vec3::from(floats(words).map_err(error)?)),
            Some("vn") => source.normals.push(Vec3::from(floats(words).map_err(error)?)),
            Some("vt") => {
                let [u, v] = floats(words).map_err(error)?;
                source.uvs.push(Vec2::new(u, if keep_v { v } else { 1.0 - v }));
            }
            Some("f") => {
                fan.clear();
                for word in words.take_while(|w| !w.starts_with('#')) {
                    let corner = source.corner(word).map_err(error)?;
                    fan.push(corners.vertex(corner, &source, &mut mesh));
                }
                if fan.len() < 3 {
                    return Err(error(format!("a face of {} corners", fan.len())));
                }
                mesh.triangles.extend(fan[1..].windows(2).map(|w| [fan[0], w[0], w[1]]));
            }
            _ => {}
        }
    }
    // A face without normals (or coordinates) in a file that has them elsewhere leaves a hole that cannot be filled.
    for (attribute, name) in [(&mut mesh.normals.len(), "normals"), (&mut mesh.uvs.len(), "texture coordinates")] {
        if *attribute != 0 && *attribute != mesh.positions.len() {
            return Err(FileError::new(path, format_args!("some faces have {name} and some have not")));
        }
    }
    Ok(mesh)
}

/// The first `N` numbers of a line; all must be finite.
fn floats<'a, const N: usize>(mut words: impl Iterator<Item = &'a str>) -> Result<[f32; N], String> {
    let mut out = [0.0; N];
    for (i, value) in out.iter_mut().enumerate() {
        let word = words.next().ok_or_else(|| format!("expected {N} numbers, found {i}"))?;
        *value = word.parse::<f32>().map_err(|_| format!("`{word}` is not a number"))?;
        if !value.is_finite() {
            return Err(format!("`{word}` is not finite"));
        }
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
    /// Parses `p`, `p/t`, `p//n` or `p/t/n`; negative indices count from the end.
    fn corner(&self, word: &str) -> Result<Corner, String> {
        let mut fields = word.split('/');
        let position = index(fields.next().unwrap_or_default(), self.positions.len(), "vertex")?;
        let uv = fields.next().filter(|f| !f.is_empty()).map(|f| index(f, self.uvs.len(), "texture coordinate"));
        let normal = fields.next().filter(|f| !f.is_empty()).map(|f| index(f, self.normals.len(), "normal"));
        Ok((position, uv.transpose()?, normal.transpose()?))
    }
}

fn index(field: &str, count: usize, what: &str) -> Result<u32, String> {
    let written: i64 = field.parse().map_err(|_| format!("`{field}` is not an index"))?;
    let zero_based = if written < 0 { written + count as i64 } else { written - 1 };
    if !(0..count as i64).contains(&zero_based) {
        return Err(format!("{what} {written} is out of range: {count} given so far"));
    }
    u32::try_from(zero_based).map_err(|_| format!("{what} {written} does not fit 32 bits"))
}

/// Vertices already made, chained by position: `first[p]` heads the list of the vertices at position `p`.
#[derive(Default)]
struct Corners {
    first: Vec<u32>,
    next: Vec<u32>,
    key: Vec<(Option<u32>, Option<u32>)>,
}

const END: u32 = u32::MAX;

impl Corners {
    fn vertex(&mut self, (position, uv, normal): Corner, source: &Source, mesh: &mut Mesh) -> u32 {
        if self.first.len() < source.positions.len() {
            self.first.resize(source.positions.len(), END);
        }
        let head = self.first[position as usize];
        let mut vertex = head;
        while vertex != END {
            if self.key[vertex as usize] == (uv, normal) {
                return vertex;
            }
            vertex = self.next[vertex as usize];
        }
        let new = self.key.len() as u32;
        self.key.push((uv, normal));
        self.next.push(head);
        self.first[position as usize] = new;
        mesh.positions.push(source.positions[position as usize]);
        mesh.uvs.extend(uv.map(|i| source.uvs[i as usize]));
        mesh.normals.extend(normal.map(|i| source.normals[i as usize]));
        new
    }
}
