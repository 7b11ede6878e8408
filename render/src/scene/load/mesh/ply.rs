//! Stanford PLY, ascii and binary of either byte order, through `ply-rs-bw`.

use crate::scene::{Mesh, load::error::FileError};
use glam::{Vec2, Vec3};
use ply_rs_bw::parser::{Parser, Reader};
use ply_rs_bw::ply::{ElementDef, Encoding, Property, PropertyAccess, PropertyAccessResult};
use std::path::Path;

/// Parses the bytes of a PLY file; `path` serves error messages only.
///
/// Reads `x y z`, `nx ny nz`, `u v` (also `s t`, `texture_u texture_v`) of `vertex` and the index list of `face`;
/// polygons become fans; everything else is skipped. `turn_v` puts `1 − v` in place of `v`.
pub fn parse(bytes: &[u8], path: &Path, turn_v: bool) -> Result<Mesh, FileError> {
    let error = |e: ply_rs_bw::parser::ParseError| match e.line() {
        Some(line) => FileError::at(path, line, e.to_string().trim_start_matches(&format!("Line {line}: "))),
        None => FileError::new(path, e),
    };
    let mut reader = Reader::new(bytes);
    let header = Parser::<Vertex>::new().read_header(&mut reader).map_err(error)?;
    let mut mesh = Mesh::default();
    for (name, definition) in &header.elements {
        // Every element takes at least a byte, so that a count beyond the file's size is a lie.
        let bytes_each = smallest_size(definition, header.encoding);
        if definition.count.saturating_mul(bytes_each) > bytes.len() {
            let what =
                format!("the header promises {} `{name}` elements, more than the file can hold", definition.count);
            return Err(FileError::new(path, what));
        }
        match name.as_str() {
            "vertex" => {
                let vertices = Parser::<Vertex>::new().read_payload_for_element(&mut reader, definition, &header);
                take_vertices(&mut mesh, &vertices.map_err(error)?, definition, turn_v);
            }
            "face" => {
                let faces = Parser::<Face>::new().read_payload_for_element(&mut reader, definition, &header);
                for (i, face) in faces.map_err(error)?.iter().enumerate() {
                    let corners = face.0.as_deref().unwrap_or_default();
                    if corners.len() < 3 {
                        return Err(FileError::new(path, format_args!("face {i} has {} corners", corners.len())));
                    }
                    mesh.triangles.extend(corners[1..].windows(2).map(|w| [corners[0], w[0], w[1]]));
                }
            }
            _ => {
                Parser::<Skipped>::new().read_payload_for_element(&mut reader, definition, &header).map_err(error)?;
            }
        }
    }
    Ok(mesh)
}

/// Bytes an element takes at least; an ascii element takes a line.
fn smallest_size(definition: &ElementDef, encoding: Encoding) -> usize {
    match encoding {
        Encoding::Ascii => 1,
        Encoding::BinaryBigEndian | Encoding::BinaryLittleEndian => definition.properties.len().max(1),
    }
}

fn take_vertices(mesh: &mut Mesh, vertices: &[Vertex], definition: &ElementDef, turn_v: bool) {
    let has = |names: &[&str]| names.iter().all(|n| definition.properties.iter().any(|(k, _)| k == n));
    mesh.positions = vertices.iter().map(|v| v.position).collect();
    if has(&["nx", "ny", "nz"]) {
        mesh.normals = vertices.iter().map(|v| v.normal).collect();
    }
    if has(&["u", "v"]) || has(&["s", "t"]) || has(&["texture_u", "texture_v"]) {
        mesh.uvs = vertices.iter().map(|v| Vec2::new(v.uv.x, if turn_v { 1.0 - v.uv.y } else { v.uv.y })).collect();
    }
}

#[derive(Default)]
struct Vertex {
    position: Vec3,
    normal: Vec3,
    uv: Vec2,
}

impl PropertyAccess for Vertex {
    fn new() -> Self {
        Self::default()
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        let target = match name {
            "x" => &mut self.position.x,
            "y" => &mut self.position.y,
            "z" => &mut self.position.z,
            "nx" => &mut self.normal.x,
            "ny" => &mut self.normal.y,
            "nz" => &mut self.normal.z,
            "u" | "s" | "texture_u" => &mut self.uv.x,
            "v" | "t" | "texture_v" => &mut self.uv.y,
            _ => return PropertyAccessResult::Ignored,
        };
        let Some(value) = property.to_f32_lossy() else { return PropertyAccessResult::UnsupportedType };
        *target = value;
        PropertyAccessResult::Set
    }
}

/// Vertex indices of a face.
struct Face(Option<Vec<u32>>);

impl PropertyAccess for Face {
    fn new() -> Self {
        Self(None)
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        if !matches!(name, "vertex_indices" | "vertex_index") {
            return PropertyAccessResult::Ignored;
        }
        self.0 = match property {
            Property::ListUInt(indices) => Some(indices),
            other => other.to_u32_list(),
        };
        if self.0.is_some() { PropertyAccessResult::Set } else { PropertyAccessResult::UnsupportedType }
    }
}

/// An element nobody asked for.
struct Skipped;

impl PropertyAccess for Skipped {
    fn new() -> Self {
        Self
    }
}
