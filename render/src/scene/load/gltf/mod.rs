//! glTF 2.0, `.gltf` and `.glb`: meshes, metallic-roughness materials, punctual lights, the camera; skins, morph targets
//! and instances, as the nodes stand in the file or at a moment of its animations.
//!
//! Units: emissive values become radiance as they are, which is what Blender's exporter writes; those of punctual lights
//! are the matter of [`LightUnits`].

mod animation;
mod camera;
mod coat;
mod container;
mod data;
mod document;
mod glass;
mod instancing;
mod keys;
mod lamps;
mod material;
mod morph;
mod placement;
mod pose;
mod scenes;
mod sheen;
mod sides;
mod skin;
mod texture;
mod track;
mod uri;

use super::choose::choose;
use super::error::{FileError, LoadError, brief};
use super::mesh::{Finish, Mirrored, finish};
use super::{Loaded, Options, left_out};
use crate::scene::{FovAxis, Geometry, Group, Instance, Mesh, Scene, Shape};
use animation::Animations;
use data::Data;
use document::SUPPORTED;
use glam::{DAffine3, Vec2, Vec3};
use gltf::mesh::Mode;
use gltf::{Document, Node, Primitive, Semantic};
pub use lamps::LightUnits;
use placement::Posed;
use pose::Pose;
use std::collections::{BTreeMap, BTreeSet};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

/// Larger files are refused.
const MAX_FILE: u64 = 1 << 33;
/// Deeper node trees are taken for cycles.
const MAX_DEPTH: usize = 256;
/// A tree of more nodes is refused, so that nodes shared by many parents cannot grow without end.
const MAX_NODES: usize = 1 << 20;

/// Loads a glTF file.
///
/// # Errors
/// The first thing that makes the file unreadable or the picture wrong.
pub fn load(path: &Path, options: &Options) -> Result<Loaded, LoadError> {
    let bytes = super::error::read_file(path, MAX_FILE)?;
    // The library indexes without checks in places; what it relies on is checked before, and this is the net below.
    let result = catch_unwind(AssertUnwindSafe(|| {
        let (text, blob) = container::open(&bytes, path)?;
        let text = scenes::with_nodes(text);
        let (document, animations) = document::parse(&text, path, options.skip_missing)?;
        let data = Data::new(path, &document, blob)?;
        let mut builder = Builder::new(&data, &document, options);
        match options.animation_time {
            Some(time) => builder.animate(&text, time)?,
            None if animations > 0 && options.track.is_none() => {
                builder.warn("animations are ignored: --frame or --time-of-animation picks a moment of them");
            }
            None => {}
        }
        let (cameras, camera) = builder.document(&document, options)?;
        let track = match options.track {
            Some(fps) => builder.track(&text, fps)?,
            None => Vec::new(),
        };
        let files = data.files(&document, builder.images_read());
        Ok(Loaded {
            scene: builder.scene,
            warnings: builder.warnings,
            cameras,
            camera,
            files,
            fov_axis: FovAxis::Y,
            track,
        })
    }));
    result
        .unwrap_or_else(|_| Err(FileError::new(path, "damaged: the glTF library failed on it")))
        .map_err(LoadError::File)
}

/// The names of all cameras, and which one takes the picture.
type Cameras = (Vec<Vec<String>>, Option<usize>);

/// A scene in the making.
struct Builder<'a> {
    document: &'a Document,
    data: &'a Data<'a>,
    scene: Scene,
    warnings: Vec<String>,
    /// What is found in many places: by kind, the first place and their number.
    notes: BTreeMap<&'static str, (String, usize)>,
    textures: texture::TextureCache,
    /// Materials already made, by their index in the file (`None` is glTF's default) and what they are on.
    materials: BTreeMap<(Option<usize>, material::On), material::Made>,
    pose: Pose,
    /// Transforms of the joints of every skin.
    skins: BTreeMap<usize, Vec<DAffine3>>,
    /// Placements of every mesh.
    placements: BTreeMap<Posed, Vec<DAffine3>>,
    cameras: Vec<camera::Placed<'a>>,
    /// That which takes the picture, and its node.
    camera: Option<(gltf::Camera<'a>, usize)>,
    /// Whether Blender wrote the file.
    blender: bool,
    units: LightUnits,
    nodes: usize,
    instances: usize,
    skip_missing: bool,
    /// Files of textures that are missing.
    missing: Vec<String>,
}

impl<'a> Builder<'a> {
    fn new(data: &'a Data<'a>, document: &'a Document, options: &Options) -> Self {
        let mut builder = Self {
            warnings: Vec::new(),
            notes: BTreeMap::new(),
            document,
            data,
            scene: Scene::default(),
            textures: texture::TextureCache::new(options.skip_missing),
            materials: BTreeMap::new(),
            pose: Pose::of_nodes(document),
            skins: BTreeMap::new(),
            placements: BTreeMap::new(),
            cameras: Vec::new(),
            camera: None,
            blender: document.as_json().asset.generator.as_ref().is_some_and(|g| g.contains("Blender I/O")),
            units: LightUnits::Standard,
            nodes: 0,
            instances: 0,
            skip_missing: options.skip_missing,
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

    /// Puts the nodes where the animations, from the JSON of the file, have them at a time in seconds.
    fn animate(&mut self, text: &str, time: f32) -> Result<(), FileError> {
        let mut animations = Animations::read(text, self.document, self.data)?;
        std::mem::take(&mut animations.notes).into_iter().for_each(|(what, place)| self.note(what, place));
        if animations.is_empty() {
            self.warn("nothing in the file moves: it looks the same at any time");
        }
        self.pose = animations.pose(time, &self.pose);
        Ok(())
    }

    fn document(&mut self, document: &'a Document, options: &Options) -> Result<Cameras, FileError> {
        let (units, guessed) = LightUnits::of(document, self.blender);
        self.units = options.light_units.unwrap_or(units);
        let chosen = match &options.scene {
            Some(wanted) => {
                let names: Vec<Vec<&str>> = document.scenes().map(|s| s.name().into_iter().collect()).collect();
                let index = choose("scene", wanted, &names);
                let index = index.map_err(|what| self.data.error(format_args!("--scene: {what}")))?;
                document.scenes().nth(index)
            }
            None => document.default_scene().or_else(|| document.scenes().next()),
        };
        let roots: Vec<Node> = match chosen {
            Some(scene) => scene.nodes().collect(),
            // A file without a scene is a library: everything in it is drawn.
            None => {
                let inner: BTreeSet<usize> = document.nodes().flat_map(|n| n.children().map(|c| c.index())).collect();
                document.nodes().filter(|n| !inner.contains(&n.index())).collect()
            }
        };
        if roots.is_empty() {
            return Err(self
                .data
                .error("the file has no scene, or an empty one: export the objects that the picture shows"));
        }
        for node in roots {
            self.node(&node, DAffine3::IDENTITY, true, 0)?;
        }
        let placements = std::mem::take(&mut self.placements);
        let all: Vec<gltf::Mesh> = document.meshes().collect();
        let drawn: Vec<gltf::Mesh> = placements.keys().filter_map(|posed| all.get(posed.mesh).cloned()).collect();
        self.announce_images(&drawn);
        for (posed, placements) in placements {
            let mesh = document.meshes().nth(posed.mesh).ok_or_else(|| self.data.error("a mesh is missing"))?;
            self.mesh(&mesh, &posed, &placements)?;
        }
        for (what, (place, count)) in std::mem::take(&mut self.notes) {
            let more = if count > 1 { format!(" (and {} more)", count - 1) } else { String::new() };
            self.warn(format_args!("{place}{more}: {what}"));
        }
        self.warnings.extend(left_out("textures are an even grey: no", &self.missing));
        if options.light_units.is_some() && self.scene.lights.is_empty() {
            self.warn("--light-units: the file has no lamps");
        }
        self.judge_lamps(guessed, options);
        self.take_picture(options.camera.as_deref())
    }

    /// Collects the meshes of a node and those below it, and takes its light and camera.
    fn node(&mut self, node: &Node<'a>, parent: DAffine3, visible: bool, depth: usize) -> Result<(), FileError> {
        self.nodes += 1;
        if depth > MAX_DEPTH || self.nodes > MAX_NODES {
            return Err(self.data.error(format_args!("node {}: the node tree is endless", node.index())));
        }
        // What hangs on a hidden node is hidden, too.
        let visible = visible && node.extension_value("KHR_node_visibility").is_none_or(|e| e["visible"] != false);
        if let Some(complaint) = self.pose.nodes[node.index()].place.complaint() {
            self.note(complaint, node_name(node));
        }
        let to_world = parent * self.pose.to_parent(node.index());
        if !to_world.is_finite() {
            return Err(self.data.error(format_args!("node {}: its transform is not finite", node.index())));
        }
        if let Some(mesh) = node.mesh().filter(|_| visible) {
            self.place(node, &mesh, to_world)?;
        }
        if let Some(light) = node.light().filter(|_| visible) {
            self.light(&light, to_world)?;
        }
        self.camera(node, to_world);
        node.children().try_for_each(|child| self.node(&child, to_world, visible, depth + 1))
    }

    /// A mesh placed once becomes shapes of the world; placed more often, a group, unless it emits light.
    fn mesh(&mut self, mesh: &gltf::Mesh, posed: &Posed, placements: &[DAffine3]) -> Result<(), FileError> {
        let emits = mesh.primitives().any(|p| material::emits(&p.material()));
        if placements.len() > 1 && !emits {
            let shapes = self.primitives(mesh, posed, DAffine3::IDENTITY)?;
            let group = self.scene.groups.len() as u32;
            self.scene.groups.push(Group { shapes });
            let instances = placements.iter().map(|to_world| Instance { group, to_world: to_world.as_affine3a() });
            self.scene.instances.extend(instances);
            return Ok(());
        }
        for &to_world in placements {
            let shapes = self.primitives(mesh, posed, to_world)?;
            self.scene.shapes.extend(shapes);
        }
        Ok(())
    }

    fn primitives(&mut self, mesh: &gltf::Mesh, posed: &Posed, to_world: DAffine3) -> Result<Vec<Shape>, FileError> {
        let mut shapes = Vec::new();
        for primitive in mesh.primitives() {
            let what =
                format!("mesh {} ({}), primitive {}", mesh.index(), mesh.name().unwrap_or("-"), primitive.index());
            let on = material::On {
                solid: self.is_solid(mesh, &primitive)?,
                painted: primitive.get(&Semantic::Colors(0)).is_some(),
            };
            let made = self.material(&primitive.material(), on)?;
            let Some(geometry) = self.geometry(&primitive, posed, &made.uv_sets, &what)? else { continue };
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
            let back = made.back.and_then(|back| sides::behind(&geometry, back));
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
        posed: &Posed,
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
        morph::apply(&mut mesh, primitive, &posed.weights(), data, what)?;
        let corners = match primitive.indices() {
            Some(accessor) => data.integers::<1>(&accessor)?.into_flattened(),
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
        if let Some(joints) = posed.skin.and_then(|skin| self.skins.get(&skin)) {
            let free = skin::apply(&mut mesh, primitive, joints, data, what)?;
            if free > 0 {
                self.note("vertices without weights follow their first joint", what);
            }
        }
        Ok(Some(mesh))
    }
}

fn node_name(node: &Node) -> String {
    format!("node {} ({})", node.index(), node.name().unwrap_or("-"))
}
