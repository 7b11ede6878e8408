//! Faces and triangle strips.

use super::header::Element;
use super::values::Sink;
use crate::scene::Mesh;
use crate::scene::load::mesh::corners::Corners;
use crate::scene::load::mesh::polygon::Splitter;
use crate::scene::load::mesh::text::quote;
use glam::Vec2;

/// The list of vertices of a face or strip.
struct Indices {
    property: usize,
    /// How many vertices there are.
    count: usize,
    list: Vec<u32>,
    /// The first index of the element that is none.
    wrong: Option<f64>,
}

/// In place of an index that ends a strip.
const RESTART: u32 = u32::MAX;

impl Indices {
    fn new(element: &Element, count: usize) -> Result<Self, String> {
        let names = ["vertex_indices", "vertex_index"];
        let Some(property) = names.iter().find_map(|name| element.find(name, true)) else {
            let found: Vec<_> = element.properties.iter().take(4).map(|p| quote(&p.name)).collect();
            let found = if found.is_empty() { "no properties".into() } else { found.join(", ") };
            return Err(format!(
                "{} has no list `vertex_indices` or `vertex_index`, but {found}",
                quote(&element.name)
            ));
        };
        Ok(Self { property, count, list: Vec::new(), wrong: None })
    }

    fn push(&mut self, value: f64) {
        if value >= 0.0 && value < self.count as f64 && value.fract() == 0.0 {
            self.list.push(value as u32);
        } else if value == -1.0 {
            self.list.push(RESTART);
            self.wrong.get_or_insert(value);
        } else {
            self.wrong = self.wrong.filter(|&w| w != -1.0).or(Some(value));
        }
    }

    /// The list, once it is whole; strips may hold −1.
    fn take(&mut self, strip: bool) -> Result<&[u32], String> {
        match self.wrong {
            Some(wrong) if !(strip && wrong == -1.0) => {
                Err(format!("refers to vertex {wrong}, but there are only {}", self.count))
            }
            _ => Ok(&self.list),
        }
    }

    fn clear(&mut self) {
        self.list.clear();
        self.wrong = None;
    }
}

/// Polygons.
pub struct Faces<'a> {
    mesh: &'a mut Mesh,
    indices: Indices,
    wedges: Option<Wedges>,
    splitter: Splitter,
    small: usize,
}

impl<'a> Faces<'a> {
    /// Adds faces of this kind to the mesh, whose vertices are read.
    pub fn new(element: &Element, mesh: &'a mut Mesh, turn_v: bool) -> Result<Self, String> {
        let count = mesh.positions.len();
        let indices = Indices::new(element, count)?;
        let wedges = element.find("texcoord", true).map(|property| {
            mesh.uvs.resize(count, Vec2::ZERO);
            let (texture, own) = (element.find("texnumber", false), mesh.uvs.clone());
            Wedges { property, texture, turn_v, claimed: vec![false; count], own, ..Wedges::default() }
        });
        Ok(Self { mesh, indices, wedges, splitter: Splitter::default(), small: 0 })
    }

    /// What is not drawn as the file has it, for the user.
    pub fn warnings(&self) -> Vec<String> {
        let small = (self.small > 0).then(|| format!("{} faces of fewer than three corners are not drawn", self.small));
        let wedges = self.wedges.iter().flat_map(Wedges::warnings);
        small.into_iter().chain(self.splitter.warning()).chain(wedges).collect()
    }
}

impl Sink for Faces<'_> {
    fn value(&mut self, property: usize, value: f64) {
        if property == self.indices.property {
            self.indices.push(value);
        } else if let Some(wedges) = &mut self.wedges {
            wedges.value(property, value);
        }
    }

    fn end_element(&mut self) -> Result<(), String> {
        let face = self.indices.take(false)?;
        if face.len() < 3 {
            self.small += 1;
        } else if let Some(wedges) = &mut self.wedges {
            let face = wedges.vertices(face, self.mesh);
            self.splitter.split(face, &self.mesh.positions, &mut self.mesh.triangles);
        } else {
            self.splitter.split(face, &self.mesh.positions, &mut self.mesh.triangles);
        }
        self.indices.clear();
        if let Some(wedges) = &mut self.wedges {
            wedges.clear();
        }
        Ok(())
    }
}

/// Texture coordinates of the corners of faces. Corners of a vertex that differ in them become different vertices.
#[derive(Default)]
struct Wedges {
    property: usize,
    texture: Option<usize>,
    turn_v: bool,
    /// What the vertices have themselves, for faces without coordinates.
    own: Vec<Vec2>,
    /// Corners so far, by position and bits of the coordinates, and the vertices that they became.
    corners: Corners<[u32; 2]>,
    vertices: Vec<u32>,
    claimed: Vec<bool>,
    /// Texture coordinates of the face being read.
    uvs: Vec<f32>,
    face: Vec<u32>,
    first_texture: Option<f64>,
    several_textures: bool,
    misfits: usize,
}

impl Wedges {
    fn value(&mut self, property: usize, value: f64) {
        if property == self.property {
            self.uvs.push(value as f32);
        } else if Some(property) == self.texture {
            self.several_textures |= value != *self.first_texture.get_or_insert(value);
        }
    }

    /// The vertices of a face with coordinates; those that are new are added to the mesh.
    fn vertices(&mut self, face: &[u32], mesh: &mut Mesh) -> &[u32] {
        let fits = self.uvs.len() == 2 * face.len();
        self.misfits += usize::from(!fits && !self.uvs.is_empty());
        self.face.clear();
        for (i, &v) in face.iter().enumerate() {
            let uv = match self.uvs.get(2 * i..2 * i + 2) {
                Some(&[u, v]) if fits => Vec2::new(u, if self.turn_v { 1.0 - v } else { v }),
                _ => self.own[v as usize],
            };
            let (corner, new) = self.corners.vertex(v, uv.to_array().map(f32::to_bits));
            if new {
                let vertex = if std::mem::replace(&mut self.claimed[v as usize], true) {
                    mesh.positions.push(mesh.positions[v as usize]);
                    mesh.normals.extend(mesh.normals.get(v as usize).copied());
                    mesh.uvs.push(uv);
                    mesh.positions.len() as u32 - 1
                } else {
                    mesh.uvs[v as usize] = uv;
                    v
                };
                self.vertices.push(vertex);
            }
            self.face.push(self.vertices[corner as usize]);
        }
        &self.face
    }

    fn clear(&mut self) {
        self.uvs.clear();
    }

    fn warnings(&self) -> impl Iterator<Item = String> {
        let textures = "faces refer to several textures by `texnumber`: drawn with the shape's".into();
        let misfits = format!("`texcoord` of {} faces does not fit their corners and is not used", self.misfits);
        let said = [(self.several_textures, textures), (self.misfits > 0, misfits)];
        said.into_iter().filter_map(|(so, what): (bool, String)| so.then_some(what))
    }
}

/// Triangle strips, each a list of vertices in which −1 begins anew.
pub struct Strips<'a> {
    mesh: &'a mut Mesh,
    indices: Indices,
}

impl<'a> Strips<'a> {
    /// Adds strips of this kind to the mesh, whose vertices are read.
    pub fn new(element: &Element, mesh: &'a mut Mesh) -> Result<Self, String> {
        let indices = Indices::new(element, mesh.positions.len())?;
        Ok(Self { mesh, indices })
    }
}

impl Sink for Strips<'_> {
    fn value(&mut self, property: usize, value: f64) {
        if property == self.indices.property {
            self.indices.push(value);
        }
    }

    fn end_element(&mut self) -> Result<(), String> {
        for strip in self.indices.take(true)?.split(|&i| i == RESTART) {
            for (i, w) in strip.windows(3).enumerate() {
                let [a, b, c] = if i % 2 == 0 { [w[0], w[1], w[2]] } else { [w[1], w[0], w[2]] };
                // Repeated vertices lead a strip to another place.
                if a != b && b != c && c != a {
                    self.mesh.triangles.push([a, b, c]);
                }
            }
        }
        self.indices.clear();
        Ok(())
    }
}
