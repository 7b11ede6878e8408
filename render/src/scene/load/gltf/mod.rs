//! glTF 2.0, `.gltf` and `.glb`: meshes, metallic-roughness materials, punctual lights, the camera.
//!
//! Units: emissive values become radiance as they are, which is what Blender's exporter writes; photometric units of
//! punctual lights are divided by 683 lm/W, which undoes Blender's conversion.

mod camera;
mod data;
mod material;
mod sides;

use super::error::{FileError, LoadError};
use super::mesh::{Finish, Mirrored, finish};
use crate::scene::{Geometry, Group, Instance, Mesh, Scene, Shape};
use data::Data;
use glam::{DAffine3, DMat4, Vec2, Vec3};
use gltf::mesh::Mode;
use gltf::{Document, Gltf, Node, Primitive, Semantic};
use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

/// Larger files are refused.
const MAX_FILE: u64 = 1 << 33;
/// Deeper node trees are taken for cycles.
const MAX_DEPTH: usize = 256;
/// A tree of more nodes is refused, so that nodes shared by many parents cannot grow without end.
const MAX_NODES: usize = 1 << 20;

/// Loads a glTF file. Returns the scene and warnings, each one line.
///
/// # Errors
/// The first thing that makes the file unreadable or the picture wrong.
pub fn load(path: &Path) -> Result<(Scene, Vec<String>), LoadError> {
    let bytes = super::error::read_file(path, MAX_FILE)?;
    // The library indexes without checks in places, so that a damaged file may make it panic.
    let result = catch_unwind(AssertUnwindSafe(|| {
        let (document, blob) = parse(&bytes, path)?;
        let data = Data::new(path, &document, blob)?;
        let mut builder = Builder::new(&data, &document);
        builder.document(&document)?;
        Ok((builder.scene, builder.warnings))
    }));
    result
        .unwrap_or_else(|_| Err(FileError::new(path, "damaged: the glTF library failed on it")))
        .map_err(LoadError::File)
}

fn parse(bytes: &[u8], path: &Path) -> Result<(Document, Option<Vec<u8>>), FileError> {
    let error = |e: gltf::Error| FileError::new(path, e);
    if bytes.starts_with(b"glTF") && bytes.get(8..12).is_none_or(|b| b < &12u32.to_le_bytes()[..] && b[1..] == [0; 3]) {
        return Err(FileError::new(path, "truncated GLB header"));
    }
    let Gltf { document, blob } = Gltf::from_slice_without_validation(bytes).map_err(error)?;
    let json = document.into_json();
    // The library's own validation looks at these accessors before it checks that they exist.
    let position = gltf::json::validation::Checked::Valid(Semantic::Positions);
    for primitive in json.meshes.iter().flat_map(|m| &m.primitives) {
        if primitive.attributes.get(&position).is_some_and(|a| a.value() >= json.accessors.len()) {
            return Err(FileError::new(path, "a primitive refers to a missing accessor"));
        }
    }
    for extension in &json.extensions_required {
        if !SUPPORTED.contains(&extension.as_str()) {
            return Err(FileError::new(path, format_args!("the extension {extension} is required, but not supported")));
        }
    }
    Ok((Document::from_json(json).map_err(error)?, blob))
}

/// Extensions a file may require.
const SUPPORTED: [&str; 6] = [
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_texture_transform",
];

/// A scene in the making.
struct Builder<'a> {
    data: &'a Data<'a>,
    scene: Scene,
    warnings: Vec<String>,
    textures: material::TextureCache,
    /// Materials already made, by their index in the file; `None` is glTF's default.
    materials: BTreeMap<Option<usize>, material::Made>,
    /// Placements of every mesh.
    placements: BTreeMap<usize, Vec<DAffine3>>,
    has_camera: bool,
    nodes: usize,
}

impl<'a> Builder<'a> {
    fn new(data: &'a Data<'a>, document: &Document) -> Self {
        let unknown = document.extensions_used().filter(|e| !SUPPORTED.contains(e));
        let unknown = unknown.map(|e| format!("{}: the extension {e} is ignored", data.path.display()));
        Self {
            warnings: unknown.collect(),
            data,
            scene: Scene::default(),
            textures: Default::default(),
            materials: BTreeMap::new(),
            placements: BTreeMap::new(),
            has_camera: false,
            nodes: 0,
        }
    }

    fn warn(&mut self, what: impl std::fmt::Display) {
        self.warnings.push(format!("{}: {what}", self.data.path.display()));
    }

    fn document(&mut self, document: &Document) -> Result<(), FileError> {
        let scene = document.default_scene().or_else(|| document.scenes().next());
        let scene = scene.ok_or_else(|| self.data.error("the file has no scene"))?;
        for node in scene.nodes() {
            self.node(&node, DAffine3::IDENTITY, 0)?;
        }
        for (mesh, placements) in std::mem::take(&mut self.placements) {
            let mesh = document.meshes().nth(mesh).ok_or_else(|| self.data.error("a mesh is missing"))?;
            self.mesh(&mesh, &placements)?;
        }
        if document.animations().len() > 0 || document.skins().len() > 0 {
            self.warn("animations and skins are ignored: everything is drawn in its rest pose");
        }
        if self.scene.lights.is_empty() && self.scene.shapes.iter().all(|s| s.emitter.is_none()) {
            self.warn("nothing in the file gives off light: the picture is black (glTF has no environment)");
        }
        if !self.has_camera {
            self.warn("the file has no camera: the picture is taken from a corner, with everything in it");
            self.frame_everything();
        }
        Ok(())
    }

    /// Collects the meshes of a node and those below it, and takes its light and camera.
    fn node(&mut self, node: &Node, parent: DAffine3, depth: usize) -> Result<(), FileError> {
        self.nodes += 1;
        if depth > MAX_DEPTH || self.nodes > MAX_NODES {
            return Err(self.data.error(format_args!("node {}: the node tree is endless", node.index())));
        }
        let local = DMat4::from_cols_array_2d(&node.transform().matrix().map(|c| c.map(f64::from)));
        let to_world = parent * DAffine3::from_mat4(local);
        if !to_world.is_finite() {
            return Err(self.data.error(format_args!("node {}: its transform is not finite", node.index())));
        }
        if let Some(mesh) = node.mesh() {
            // A scale of zero hides a mesh.
            if to_world.matrix3.determinant() != 0.0 {
                self.placements.entry(mesh.index()).or_default().push(to_world);
            }
        }
        if let Some(light) = node.light() {
            self.light(&light, to_world)?;
        }
        if let Some(camera) = node.camera() {
            self.camera(&camera, to_world)?;
        }
        node.children().try_for_each(|child| self.node(&child, to_world, depth + 1))
    }

    /// A mesh placed once becomes shapes of the world; placed more often, a group, unless it emits light.
    fn mesh(&mut self, mesh: &gltf::Mesh, placements: &[DAffine3]) -> Result<(), FileError> {
        let mut emits = false;
        for primitive in mesh.primitives() {
            emits |= self.material(&primitive.material())?.emitter.is_some();
        }
        if placements.len() > 1 && !emits {
            let shapes = self.primitives(mesh, DAffine3::IDENTITY)?;
            let group = self.scene.groups.len() as u32;
            self.scene.groups.push(Group { shapes });
            let instances = placements.iter().map(|to_world| Instance { group, to_world: to_world.as_affine3a() });
            self.scene.instances.extend(instances);
            return Ok(());
        }
        for &to_world in placements {
            let shapes = self.primitives(mesh, to_world)?;
            self.scene.shapes.extend(shapes);
        }
        Ok(())
    }

    fn primitives(&mut self, mesh: &gltf::Mesh, to_world: DAffine3) -> Result<Vec<Shape>, FileError> {
        let mut shapes = Vec::new();
        for primitive in mesh.primitives() {
            let what =
                format!("mesh {} ({}), primitive {}", mesh.index(), mesh.name().unwrap_or("-"), primitive.index());
            let made = self.material(&primitive.material())?;
            let Some(geometry) = self.geometry(&primitive, made.uv_set, &what)? else { continue };
            let flat = geometry.normals.is_empty();
            let how = Finish {
                to_world: to_world.as_affine3a(),
                face_normals: flat,
                mirrored: Mirrored::Image,
                ..Finish::default()
            };
            let (geometry, dropped) = finish(geometry, how, self.data.path)
                .map_err(|e| self.data.error(format_args!("{what}: {}", e.what)))?;
            if dropped > 0 {
                self.warn(format_args!("{what}: {dropped} triangles without area are not drawn"));
            }
            if geometry.triangles.is_empty() {
                continue;
            }
            let lamp = made.emitter.is_some() && primitive.material().double_sided();
            let back = if lamp { sides::behind(&geometry) } else { None };
            for mesh in std::iter::once(geometry).chain(back) {
                let geometry = Geometry::Mesh(mesh);
                shapes.push(Shape { geometry, material: made.id, emitter: made.emitter.clone() });
            }
        }
        Ok(shapes)
    }

    /// Triangles of a primitive; `None` for points and lines.
    fn geometry(&mut self, primitive: &Primitive, uv_set: u32, what: &str) -> Result<Option<Mesh>, FileError> {
        let data = self.data;
        let attribute = |semantic| primitive.get(&semantic);
        let positions = attribute(Semantic::Positions);
        let positions = positions.ok_or_else(|| data.error(format_args!("{what}: no positions")))?;
        let positions: Vec<Vec3> = data.vectors(&positions)?.into_iter().map(Vec3::from_array).collect();
        let mut mesh = Mesh { positions, ..Mesh::default() };
        if let Some(accessor) = attribute(Semantic::Normals) {
            mesh.normals = data.vectors(&accessor)?.into_iter().map(Vec3::from_array).collect();
        }
        if let Some(accessor) = attribute(Semantic::TexCoords(uv_set)) {
            mesh.uvs = data.vectors(&accessor)?.into_iter().map(Vec2::from_array).collect();
        }
        let count = mesh.positions.len();
        if [mesh.normals.len(), mesh.uvs.len()].iter().any(|&n| n != 0 && n != count) {
            return Err(data.error(format_args!("{what}: attributes of different length")));
        }
        if attribute(Semantic::Colors(0)).is_some() {
            self.warn(format_args!("{what}: vertex colours are ignored"));
        }
        let corners = match primitive.indices() {
            Some(accessor) => data.indices(&accessor)?,
            None => (0..count as u32).collect(),
        };
        mesh.triangles = match primitive.mode() {
            Mode::Triangles => corners.as_chunks().0.to_vec(),
            // Every other triangle of a strip is wound the other way.
            Mode::TriangleStrip => {
                let triangle =
                    |(i, w): (usize, &[u32])| if i % 2 == 0 { [w[0], w[1], w[2]] } else { [w[1], w[0], w[2]] };
                corners.windows(3).enumerate().map(triangle).collect()
            }
            Mode::TriangleFan => {
                corners.get(1..).unwrap_or_default().windows(2).map(|w| [corners[0], w[0], w[1]]).collect()
            }
            Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip => {
                self.warn(format_args!("{what}: points and lines are not drawn"));
                return Ok(None);
            }
        };
        Ok(Some(mesh))
    }
}
