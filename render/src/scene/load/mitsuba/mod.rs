//! Mitsuba scene files, versions 0.3 – 0.6 (camelCase) and 2 – 3 (snake_case).

mod camera;
mod composite;
mod emitter;
mod ior;
mod material;
mod measured;
mod object;
mod objects;
mod principled;
mod recipe;
mod shape;
mod spectrum;
mod texture;
mod transform;
mod upgrade;
mod value;
mod xml;

use super::choose::{choose, list};
use super::error::{LoadError, brief};
use super::image::Images;
use super::{Loaded, Options, SkySource, left_out};
use crate::scene::{FovAxis, IntegratorSettings, MaterialId, Scene, TextureId};
use object::Object;
use objects::{ObjectId, Objects};
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// Loads a scene file.
///
/// # Errors
/// The first thing that makes the scene unreadable or the picture wrong.
pub fn load(path: &Path, options: &Options) -> Result<Loaded, LoadError> {
    let mut document = xml::read(path, &options.defines)?;
    let mut warnings = std::mem::take(&mut document.warnings);
    warnings.extend(document.unused_defines.iter().map(|name| format!("-D {name}: the scene has no such parameter")));
    let files = std::mem::take(&mut document.files);
    let objects = Objects::new(document)?;
    let mut builder = Builder::new(&objects, options);
    builder.files = files;
    let (cameras, camera) = builder.scene()?;
    warnings.append(&mut builder.warnings);
    warnings.extend(left_out("shapes are left out: no", &builder.missing_meshes));
    warnings.extend(left_out("textures are an even grey: no", &builder.missing_textures));
    let Builder { scene, files, fov_axis, .. } = builder;
    warnings.extend(objects.unused());
    Ok(Loaded { scene, warnings, cameras, camera: Some(camera), files, fov_axis, track: Vec::new() })
}

/// A scene in the making.
struct Builder<'a> {
    objects: &'a Objects,
    scene: Scene,
    warnings: Vec<String>,
    /// Materials and textures already made, by the object they come from.
    materials: HashMap<ObjectId, MaterialId>,
    textures: HashMap<(ObjectId, texture::Decode), TextureId>,
    /// Material of shapes that name none, by whether they emit.
    default_materials: HashMap<bool, MaterialId>,
    groups: HashMap<ObjectId, u32>,
    images: Images<PathBuf>,
    skip_missing: bool,
    /// The sky from outside, which the file must not have then.
    sky: Option<&'a SkySource>,
    /// The sensor that is asked for.
    camera: Option<&'a str>,
    /// Files of shapes that are left out, and of textures.
    missing_meshes: Vec<String>,
    missing_textures: Vec<String>,
    /// Files that were read.
    files: Vec<PathBuf>,
    /// Along which the sensor gives its field of view.
    fov_axis: FovAxis,
}

impl<'a> Builder<'a> {
    fn new(objects: &'a Objects, options: &'a Options) -> Self {
        Self {
            objects,
            scene: Scene::default(),
            warnings: Vec::new(),
            materials: HashMap::new(),
            textures: HashMap::new(),
            default_materials: HashMap::new(),
            groups: HashMap::new(),
            images: Images::new(options.skip_missing),
            skip_missing: options.skip_missing,
            sky: options.environment.as_ref().map(|sky| &sky.source),
            camera: options.camera.as_deref(),
            missing_meshes: Vec::new(),
            missing_textures: Vec::new(),
            files: Vec::new(),
            fov_axis: FovAxis::default(),
        }
    }

    fn warn(&mut self, object: &Object, what: impl std::fmt::Display) {
        self.warnings.push(format!("{}: {}", object.place, brief(what)));
    }

    /// Everything at the top level. Returns the names of all sensors, and which one takes the picture.
    fn scene(&mut self) -> Result<(Vec<Vec<String>>, usize), LoadError> {
        let objects = self.objects;
        let root = &objects[objects.root()];
        let sensors: Vec<&Object> = root.children_of(objects, "sensor").map(|(id, _)| &objects[id]).collect();
        let names: Vec<Vec<&str>> = sensors.iter().map(|s| s.id.as_deref().into_iter().collect()).collect();
        let chosen = match self.camera {
            Some(wanted) => choose("sensor", wanted, &names).map_err(|what| root.error(format!("--camera: {what}")))?,
            None => 0,
        };
        let sensor = sensors.get(chosen).ok_or_else(|| root.error("the scene has no sensor"))?;
        self.sensor(sensor)?;
        if let (None, Some(second)) = (self.camera, sensors.get(1)) {
            let what = format!("only the first sensor takes a picture; --camera chooses from {}", list(&names));
            self.warn(second, what);
        }
        for (integrator, _) in root.children_of(objects, "integrator") {
            self.integrator(&objects[integrator])?;
        }
        for (emitter, _) in root.children_of(objects, "emitter") {
            self.emitter(&objects[emitter])?;
        }
        // Materials, textures and media at the top level wait for references.
        for class in ["bsdf", "texture", "medium"] {
            root.children_of(objects, class).for_each(drop);
        }
        let shapes: Vec<ObjectId> = root.children_of(objects, "shape").map(|(id, _)| id).collect();
        self.announce_images(&shapes);
        self.shapes(&shapes)?;
        let names = names.into_iter().map(|own| own.into_iter().map(String::from).collect()).collect();
        Ok((names, chosen))
    }

    fn integrator(&mut self, object: &Object) -> Result<(), LoadError> {
        let depth = object.number("max_depth")?;
        let whole = depth.is_none_or(|d| d.fract() == 0.0 && (-1.0..f64::from(u32::MAX)).contains(&d));
        if !whole {
            return Err(object.error("`max_depth` must be -1 or a whole number ≥ 0"));
        }
        let settings = &mut self.scene.integrator;
        settings.max_depth = match depth {
            Some(d) if d >= 0.0 => d as u32,
            _ => u32::MAX,
        };
        settings.rr_depth = object.count_or("rr_depth", IntegratorSettings::default().rr_depth)?;
        settings.hide_emitters = object.boolean_or("hide_emitters", false)?;
        match object.plugin.as_str() {
            "path" => object.ignore(&["strict_normals"]),
            "direct" => settings.max_depth = 2,
            other => self.warn(object, format_args!("`{other}` is not known: path tracing is used instead")),
        }
        Ok(())
    }
}
