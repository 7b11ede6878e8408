//! Positions, normals and texture coordinates of vertices.

use super::header::Element;
use super::values::Sink;
use crate::scene::Mesh;
use glam::{Vec2, Vec3};

/// Names of a texture coordinate, in pairs; the first pair of a file counts.
const TEXTURE: [[&str; 2]; 5] =
    [["u", "v"], ["s", "t"], ["texture_u", "texture_v"], ["texture_s", "texture_t"], ["u0", "v0"]];

/// Places in a vertex: position, normal, texture coordinate, and one for everything else.
const SLOTS: usize = 9;
const OTHER: usize = 8;

/// Reads vertices.
pub struct Vertices {
    pub mesh: Mesh,
    /// Where each property goes.
    slots: Vec<usize>,
    has_normals: bool,
    has_uvs: bool,
    turn_v: bool,
    vertex: [f32; SLOTS],
}

impl Vertices {
    /// Vertices of this kind; `turn_v` puts `1 − v` in place of `v`.
    pub fn new(element: &Element, turn_v: bool) -> Result<Self, String> {
        let find = |names: &[&'static str]| -> Result<Vec<usize>, String> {
            let missing = |name| format!("`vertex` has no property `{name}`");
            names.iter().map(|name| element.find(name, false).ok_or_else(|| missing(name))).collect()
        };
        let position = find(&["x", "y", "z"])?;
        let normal = find(&["nx", "ny", "nz"]).ok();
        let uv = TEXTURE.iter().find_map(|names| find(names).ok());
        let mut slots = vec![OTHER; element.properties.len()];
        for (first, properties) in [(0, Some(&position)), (3, normal.as_ref()), (6, uv.as_ref())] {
            for (i, &property) in properties.into_iter().flatten().enumerate() {
                slots[property] = first + i;
            }
        }
        let (has_normals, has_uvs) = (normal.is_some(), uv.is_some());
        Ok(Self { mesh: Mesh::default(), slots, has_normals, has_uvs, turn_v, vertex: [0.0; SLOTS] })
    }
}

impl Sink for Vertices {
    fn value(&mut self, property: usize, value: f64) {
        self.vertex[self.slots[property]] = value as f32;
    }

    fn end_element(&mut self) -> Result<(), String> {
        let [x, y, z, nx, ny, nz, u, v, _] = self.vertex;
        self.mesh.positions.push(Vec3::new(x, y, z));
        if self.has_normals {
            self.mesh.normals.push(Vec3::new(nx, ny, nz));
        }
        if self.has_uvs {
            self.mesh.uvs.push(Vec2::new(u, if self.turn_v { 1.0 - v } else { v }));
        }
        Ok(())
    }
}
