//! `shape`: elementary shapes, mesh files (parsed in parallel), groups and instances.

use super::Builder;
use super::object::Object;
use super::objects::ObjectId;
use crate::scene::load::error::{FileError, LoadError, Place, read_file};
use crate::scene::load::mesh::{Finish, MAX_COORDINATE, Parsed, check_positions, finish, obj, ply, serialized};
use crate::scene::load::similarity::similarity;
use crate::scene::{
    AreaEmitter, ColorTexture, Geometry, Group, Instance, Material, MaterialId, Mesh, Rgb, Shape, Sphere,
};
use glam::DVec3;
use rayon::prelude::*;
use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::Arc;

/// Larger mesh files are refused.
const MAX_FILE: u64 = 1 << 33;

/// How to read a mesh file.
enum Format {
    Obj { keep_v: bool },
    Ply { turn_v: bool },
    Serialized { index: usize },
}

/// A mesh file to read.
struct MeshFile {
    place: Place,
    path: PathBuf,
    bytes: Arc<Vec<u8>>,
    format: Format,
    finish: Finish,
}

/// What a `shape` element stands for, before files are parsed.
enum Source {
    Ready(Geometry),
    File(MeshFile),
}

struct Pending {
    source: Source,
    material: MaterialId,
    emitter: Option<AreaEmitter>,
}

impl Builder<'_> {
    /// The shapes of the top level.
    pub(super) fn shapes(&mut self, ids: &[ObjectId]) -> Result<(), LoadError> {
        let objects = self.objects;
        let mut solid = Vec::new();
        for &id in ids {
            match objects[id].plugin.as_str() {
                // Drawn by instances only.
                "shapegroup" => {}
                "instance" => self.instance(&objects[id])?,
                _ => solid.push(id),
            }
        }
        self.scene.shapes = self.load(&solid)?;
        Ok(())
    }

    fn load(&mut self, ids: &[ObjectId]) -> Result<Vec<Shape>, LoadError> {
        let objects = self.objects;
        let mut files = HashMap::new();
        let mut pending = Vec::new();
        for &id in ids {
            pending.extend(self.pending(&objects[id], &mut files)?.map(|p| (id, p)));
        }
        // Each file is dropped with the last mesh that it holds.
        drop(files);
        // The first error in file order wins, so that the message does not depend on timing.
        let done: Vec<_> = pending.into_par_iter().map(|(id, p)| (id, p.finish())).collect();
        let mut shapes = Vec::new();
        for (id, result) in done {
            let (shape, warnings) = result?;
            let object = &objects[id];
            for warning in warnings {
                self.warn(object, warning);
            }
            if matches!(&shape.geometry, Geometry::Mesh(m) if m.triangles.is_empty()) {
                self.warn(object, "the mesh has no triangles: nothing is drawn");
                continue;
            }
            shapes.push(shape);
        }
        Ok(shapes)
    }

    /// `None` for a shape that is left out because its file is missing.
    fn pending(
        &mut self,
        object: &Object,
        files: &mut HashMap<PathBuf, Arc<Vec<u8>>>,
    ) -> Result<Option<Pending>, LoadError> {
        let objects = self.objects;
        let source = source(self, object, files)?;
        let emitter = match object.children_of(objects, "emitter").next() {
            Some((emitter, _)) => Some(self.area_emitter(&objects[emitter])?),
            None => None,
        };
        for class in ["medium", "subsurface", "sensor"] {
            if object.children_of(objects, class).next().is_some() {
                self.warn(object, format_args!("`{class}` is not supported: the shape is drawn without it"));
            }
        }
        let mut materials = object.children_of(objects, "bsdf");
        let material = match (materials.next(), materials.next()) {
            (Some((material, _)), None) => self.material(material)?,
            (None, _) => self.default_material(emitter.is_some()),
            (Some(_), Some(_)) => return Err(object.error("a shape has one bsdf, and this has two")),
        };
        let Some(source) = source else {
            self.missing_meshes.push(object.require_text("filename")?.into());
            return Ok(None);
        };
        Ok(Some(Pending { source, material, emitter }))
    }

    /// A shape without material is grey, or black if it is a lamp.
    fn default_material(&mut self, emits: bool) -> MaterialId {
        if let Some(&done) = self.default_materials.get(&emits) {
            return done;
        }
        let reflectance = ColorTexture::Constant(Rgb::splat(if emits { 0.0 } else { 0.5 }));
        let new = self.push_material(Material::Diffuse { reflectance }, "default".into());
        self.default_materials.insert(emits, new);
        new
    }

    fn instance(&mut self, object: &Object) -> Result<(), LoadError> {
        let objects = self.objects;
        let to_world = object.transform("to_world")?.as_affine3a();
        if !to_world.is_finite() || !to_world.inverse().is_finite() {
            return Err(object.error("the transform is too large or too small for single precision"));
        }
        let mut inside = object.children_of(objects, "shape");
        let (Some((group, _)), None) = (inside.next(), inside.next()) else {
            return Err(object.error("an instance refers to exactly one shapegroup"));
        };
        let group = self.group(group)?;
        self.scene.instances.push(Instance { group, to_world });
        Ok(())
    }

    fn group(&mut self, id: ObjectId) -> Result<u32, LoadError> {
        if let Some(&done) = self.groups.get(&id) {
            return Ok(done);
        }
        let objects = self.objects;
        let object = &objects[id];
        if object.plugin != "shapegroup" {
            return Err(object.error(format!("an instance needs a `shapegroup`, not a `{}`", object.plugin)));
        }
        let ids: Vec<_> = object.children_of(objects, "shape").map(|(id, _)| id).collect();
        for &id in &ids {
            let shape = &objects[id];
            if matches!(shape.plugin.as_str(), "instance" | "shapegroup") {
                return Err(shape.error("groups inside groups are not supported"));
            }
            if shape.children_of(objects, "emitter").next().is_some() {
                return Err(shape.error("a shape inside a group cannot emit light"));
            }
        }
        let shapes = self.load(&ids)?;
        let new = self.scene.groups.len() as u32;
        self.scene.groups.push(Group { shapes });
        self.groups.insert(id, new);
        Ok(new)
    }
}

/// `None` where the file is missing and may be.
fn source(
    builder: &mut Builder,
    object: &Object,
    files: &mut HashMap<PathBuf, Arc<Vec<u8>>>,
) -> Result<Option<Source>, LoadError> {
    let to_world = object.transform("to_world")?;
    let flip = object.boolean_or("flip_normals", false)?;
    let placed = to_world.as_affine3a();
    let mesh = |m: Mesh| {
        check_positions(&m).map_err(|what| object.error(what))?;
        Ok(Some(Source::Ready(Geometry::Mesh(if flip { m.flipped() } else { m }))))
    };
    let format = match object.plugin.as_str() {
        "rectangle" => return mesh(Mesh::rectangle(placed)),
        "cube" => return mesh(Mesh::cube(placed)),
        "disk" => return mesh(Mesh::disk(placed)),
        "cylinder" => {
            let p0 = object.vector("p0")?.unwrap_or(DVec3::ZERO).as_vec3();
            let p1 = object.vector("p1")?.unwrap_or(DVec3::Z).as_vec3();
            let radius = object.number_or("radius", 1.0)? as f32;
            if p0 == p1 || radius <= 0.0 {
                return Err(object.error("a cylinder needs a radius > 0 and two different end points"));
            }
            return mesh(Mesh::cylinder(p0, p1, radius, placed));
        }
        "sphere" => return Ok(Some(Source::Ready(Geometry::Sphere(sphere(object, flip)?)))),
        "obj" => Format::Obj { keep_v: !object.boolean_or("flip_tex_coords", true)? },
        "ply" => Format::Ply { turn_v: object.boolean_or("flip_tex_coords", false)? },
        "serialized" => Format::Serialized { index: object.count_or("shape_index", 0)? as usize },
        other => return Err(object.error(format!("the shape `{other}` is not supported"))),
    };
    let face_normals = object.boolean_or("face_normals", false)?;
    let name = object.require_text("filename")?;
    let path = builder.objects.path(object, name);
    let bytes = match files.get(&path) {
        Some(bytes) => bytes.clone(),
        None => match read_file(&path, MAX_FILE) {
            Ok(read) => {
                builder.files.push(path.clone());
                files.entry(path.clone()).or_insert(Arc::new(read)).clone()
            }
            Err(error) if error.missing && builder.skip_missing => return Ok(None),
            Err(error) => {
                let skip = error.missing.then_some("--skip-missing draws the rest");
                let error = skip.into_iter().fold(error, FileError::advise);
                return Err(builder.objects.asset(object, name, error));
            }
        },
    };
    let finish = Finish { to_world: placed, face_normals, flip_normals: flip, ..Finish::default() };
    Ok(Some(Source::File(MeshFile { place: object.place.clone(), path, bytes, format, finish })))
}

fn sphere(object: &Object, inward: bool) -> Result<Sphere, LoadError> {
    let to_world = object.transform("to_world")?;
    let (rotation, scale) = similarity(to_world.matrix3)
        .ok_or_else(|| object.error("a sphere cannot be scaled differently along different axes"))?;
    let center = object.vector("center")?.unwrap_or(DVec3::ZERO);
    let radius = object.number_or("radius", 1.0)? * scale;
    let center = to_world.transform_point3(center).as_vec3a();
    if radius <= 0.0 || radius > MAX_COORDINATE.into() || center.abs().max_element() > MAX_COORDINATE {
        return Err(object.error(format!("a sphere of radius {radius} around {center}")));
    }
    Ok(Sphere { center, radius: radius as f32, rotation: rotation.as_mat3().into(), inward })
}

impl Pending {
    /// Parses the file; returns also what is to be said about it.
    fn finish(self) -> Result<(Shape, Vec<String>), LoadError> {
        let (geometry, warnings) = match self.source {
            Source::Ready(geometry) => (geometry, Vec::new()),
            Source::File(file) => {
                let (mesh, warnings) =
                    file.parse().map_err(|error| LoadError::Asset { place: file.place.clone(), error })?;
                (Geometry::Mesh(mesh), warnings)
            }
        };
        Ok((Shape { geometry, material: self.material, emitter: self.emitter }, warnings))
    }
}

impl MeshFile {
    fn parse(&self) -> Result<(Mesh, Vec<String>), FileError> {
        let Parsed { mesh, face_normals, mut warnings } = match self.format {
            Format::Obj { keep_v } => obj::parse(&self.bytes, &self.path, keep_v)?,
            Format::Ply { turn_v } => ply::parse(&self.bytes, &self.path, turn_v)?,
            Format::Serialized { index } => serialized::parse(&self.bytes, index, &self.path)?,
        };
        let how = Finish { face_normals: self.finish.face_normals || face_normals, ..self.finish };
        let (mesh, dropped) = finish(mesh, how, &self.path)?;
        if dropped > 0 {
            warnings.push(format!("{dropped} triangles without area are not drawn"));
        }
        Ok((mesh, warnings))
    }
}
