//! glTF 2.0, `.gltf` and `.glb`: meshes, metallic-roughness materials, punctual lights, the camera.
//!
//! Units: emissive values become radiance as they are, which is what Blender's exporter writes; photometric units of
//! punctual lights are divided by 683 lm/W, which undoes Blender's conversion.

mod camera;
mod coat;
mod container;
mod data;
mod document;
mod glass;
mod material;
mod morph;
mod sides;
mod texture;
mod uri;

use super::error::{FileError, LoadError, brief};
use super::left_out;
use super::mesh::{Finish, Mirrored, finish};
use crate::scene::{Geometry, Group, Instance, Mesh, Scene, Shape};
use data::Data;
use document::SUPPORTED;
use glam::{DAffine3, DMat3, DMat4, DQuat, DVec3, Vec2, Vec3};
use gltf::mesh::Mode;
use gltf::scene::Transform;
use gltf::{Document, Node, Primitive, Semantic};
use std::collections::{BTreeMap, BTreeSet};
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
pub fn load(path: &Path, skip_missing: bool) -> Result<(Scene, Vec<String>), LoadError> {
    let bytes = super::error::read_file(path, MAX_FILE)?;
    // The library indexes without checks in places; what it relies on is checked before, and this is the net below.
    let result = catch_unwind(AssertUnwindSafe(|| {
        let (text, blob) = container::open(&bytes, path)?;
        let (document, animations) = document::parse(&text, path)?;
        let data = Data::new(path, &document, blob)?;
        let mut builder = Builder::new(&data, &document, skip_missing);
        builder.document(&document, animations)?;
        Ok((builder.scene, builder.warnings))
    }));
    result
        .unwrap_or_else(|_| Err(FileError::new(path, "damaged: the glTF library failed on it")))
        .map_err(LoadError::File)
}

/// A mesh with the weights of its morph targets.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Posed {
    mesh: usize,
    /// Bits of the weights, without the zeros at their end.
    weights: Vec<u32>,
}

/// A scene in the making.
struct Builder<'a> {
    data: &'a Data<'a>,
    document: &'a Document,
    scene: Scene,
    warnings: Vec<String>,
    /// What is found in many places: by kind, the first place and their number.
    notes: BTreeMap<&'static str, (String, usize)>,
    textures: texture::TextureCache,
    /// Materials already made, by their index in the file (`None` is glTF's default) and what they are on.
    materials: BTreeMap<(Option<usize>, material::On), material::Made>,
    /// Whether Blender's exporter wrote the file.
    by_blender: bool,
    /// Placements of every mesh.
    placements: BTreeMap<Posed, Vec<DAffine3>>,
    has_camera: bool,
    nodes: usize,
    skip_missing: bool,
    /// Files of textures that are missing.
    missing: Vec<String>,
}

impl<'a> Builder<'a> {
    fn new(data: &'a Data<'a>, document: &'a Document, skip_missing: bool) -> Self {
        let generator = document.as_json().asset.generator.as_ref();
        let mut builder = Self {
            warnings: Vec::new(),
            notes: BTreeMap::new(),
            data,
            document,
            scene: Scene::default(),
            textures: Default::default(),
            materials: BTreeMap::new(),
            by_blender: generator.is_some_and(|g| g.contains("Blender")),
            placements: BTreeMap::new(),
            has_camera: false,
            nodes: 0,
            skip_missing,
            missing: Vec::new(),
        };
        let unknown: BTreeSet<&str> = document.extensions_used().filter(|e| !SUPPORTED.contains(e)).collect();
        unknown.iter().for_each(|e| builder.warn(format_args!("the extension {e} is ignored")));
        builder
    }

    fn warn(&mut self, what: impl std::fmt::Display) {
        self.warnings.push(format!("{}: {}", self.data.path.display(), brief(what)));
    }

    /// A warning that comes once, however many places it is about.
    fn note(&mut self, what: &'static str, place: impl std::fmt::Display) {
        self.notes.entry(what).or_insert_with(|| (place.to_string(), 0)).1 += 1;
    }

    fn document(&mut self, document: &Document, animations: usize) -> Result<(), FileError> {
        let roots: Vec<Node> = match document.default_scene().or_else(|| document.scenes().next()) {
            Some(scene) => scene.nodes().collect(),
            // A file without a scene is a library: everything in it is drawn.
            None => {
                let inner: BTreeSet<usize> = document.nodes().flat_map(|n| n.children().map(|c| c.index())).collect();
                document.nodes().filter(|n| !inner.contains(&n.index())).collect()
            }
        };
        if roots.is_empty() {
            return Err(self.data.error("the file has no scene"));
        }
        for node in roots {
            self.node(&node, DAffine3::IDENTITY, 0)?;
        }
        for (posed, placements) in std::mem::take(&mut self.placements) {
            let mesh = document.meshes().nth(posed.mesh).ok_or_else(|| self.data.error("a mesh is missing"))?;
            let weights: Vec<f32> = posed.weights.into_iter().map(f32::from_bits).collect();
            self.mesh(&mesh, &weights, &placements)?;
        }
        if animations > 0 {
            self.warn("animations are ignored: everything is drawn in its rest pose");
        }
        for (what, (place, count)) in std::mem::take(&mut self.notes) {
            let more = if count > 1 { format!(" (and {} more)", count - 1) } else { String::new() };
            self.warn(format_args!("{place}{more}: {what}"));
        }
        self.warnings.extend(left_out("textures are an even grey: no", &self.missing));
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
        let local = self.local(node);
        let to_world = parent * local;
        if !to_world.is_finite() {
            return Err(self.data.error(format_args!("node {}: its transform is not finite", node.index())));
        }
        if let Some(mesh) = node.mesh() {
            // A scale of zero hides a mesh.
            if to_world.matrix3.determinant() != 0.0 {
                let weights = node.weights().or(mesh.weights()).unwrap_or_default();
                if weights.iter().any(|w| !w.is_finite()) {
                    return Err(self.data.error(format_args!("node {}: a weight is not finite", node.index())));
                }
                let used = weights.iter().rposition(|w| *w != 0.0).map_or(0, |last| last + 1);
                let weights = weights[..used].iter().map(|w| w.to_bits()).collect();
                self.placements.entry(Posed { mesh: mesh.index(), weights }).or_default().push(to_world);
            }
            if node.skin().is_some() {
                self.note("skins are ignored: the mesh is drawn as it was modelled", node_name(node));
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

    /// Transform of a node against its parent.
    fn local(&mut self, node: &Node) -> DAffine3 {
        let (translation, rotation, scale) = match node.transform() {
            Transform::Matrix { matrix } => {
                return DAffine3::from_mat4(DMat4::from_cols_array_2d(&matrix.map(|c| c.map(f64::from))));
            }
            Transform::Decomposed { translation, rotation, scale } => (translation, rotation, scale),
        };
        let rotation = DQuat::from_array(rotation.map(f64::from));
        let length = rotation.length();
        if length == 0.0 {
            self.note("a rotation of length zero is left out", node_name(node));
        } else if (length - 1.0).abs() > 1e-3 {
            self.note("the quaternion of a rotation is not of unit length: it is normalised", node_name(node));
        }
        let rotation = if length > 0.0 { rotation / length } else { DQuat::IDENTITY };
        let scale = DMat3::from_diagonal(DVec3::from(scale.map(f64::from)));
        let translation = DVec3::from(translation.map(f64::from));
        DAffine3 { matrix3: DMat3::from_quat(rotation) * scale, translation }
    }

    /// A mesh placed once becomes shapes of the world; placed more often, a group, unless it emits light.
    fn mesh(&mut self, mesh: &gltf::Mesh, weights: &[f32], placements: &[DAffine3]) -> Result<(), FileError> {
        let emits = mesh.primitives().any(|p| material::emits(&p.material()));
        if placements.len() > 1 && !emits {
            let shapes = self.primitives(mesh, weights, DAffine3::IDENTITY)?;
            let group = self.scene.groups.len() as u32;
            self.scene.groups.push(Group { shapes });
            let instances = placements.iter().map(|to_world| Instance { group, to_world: to_world.as_affine3a() });
            self.scene.instances.extend(instances);
            return Ok(());
        }
        for &to_world in placements {
            let shapes = self.primitives(mesh, weights, to_world)?;
            self.scene.shapes.extend(shapes);
        }
        Ok(())
    }

    fn primitives(&mut self, mesh: &gltf::Mesh, weights: &[f32], to_world: DAffine3) -> Result<Vec<Shape>, FileError> {
        let mut shapes = Vec::new();
        for primitive in mesh.primitives() {
            let what =
                format!("mesh {} ({}), primitive {}", mesh.index(), mesh.name().unwrap_or("-"), primitive.index());
            let on = material::On {
                solid: self.is_solid(mesh, &primitive)?,
                painted: primitive.get(&Semantic::Colors(0)).is_some(),
            };
            let made = self.material(&primitive.material(), on)?;
            let Some(geometry) = self.geometry(&primitive, weights, &made.uv_sets, &what)? else { continue };
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
    fn geometry(
        &mut self,
        primitive: &Primitive,
        weights: &[f32],
        uv_sets: &[u32],
        what: &str,
    ) -> Result<Option<Mesh>, FileError> {
        let data = self.data;
        let attribute = |semantic| primitive.get(&semantic);
        let positions = attribute(Semantic::Positions);
        let positions = positions.ok_or_else(|| data.error(format_args!("{what}: no positions")))?;
        let positions: Vec<Vec3> = data.vectors(&positions)?.into_iter().map(Vec3::from_array).collect();
        let mut mesh = Mesh { positions, ..Mesh::default() };
        if let Some(accessor) = attribute(Semantic::Normals) {
            mesh.normals = data.vectors(&accessor)?.into_iter().map(Vec3::from_array).collect();
        }
        let uvs = |slot: usize| match uv_sets.get(slot).and_then(|set| attribute(Semantic::TexCoords(*set))) {
            Some(accessor) => Ok(data.vectors(&accessor)?.into_iter().map(Vec2::from_array).collect()),
            None => Ok(Vec::new()),
        };
        (mesh.uvs, mesh.second_uvs) = (uvs(0)?, uvs(1)?);
        if let Some(accessor) = attribute(Semantic::Colors(0)) {
            mesh.colors = data.colors(&accessor)?;
        }
        let count = mesh.positions.len();
        let lengths = [mesh.normals.len(), mesh.uvs.len(), mesh.second_uvs.len(), mesh.colors.len()];
        if lengths.iter().any(|&n| n != 0 && n != count) {
            return Err(data.error(format_args!("{what}: attributes of different length")));
        }
        morph::apply(&mut mesh, primitive, weights, data, what)?;
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
                self.note("points and lines are not drawn", what);
                return Ok(None);
            }
        };
        Ok(Some(mesh))
    }
}

fn node_name(node: &Node) -> String {
    format!("node {} ({})", node.index(), node.name().unwrap_or("-"))
}
