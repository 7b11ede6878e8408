//! Loaders: Mitsuba XML and glTF 2.0 to a [`Scene`], and models for a quick look.

mod choose;
mod color;
mod dark;
mod error;
mod files;
mod framing;
mod gltf;
mod image;
/// The readers of mesh files, for fuzzing.
#[doc(hidden)]
pub mod mesh;
mod mitsuba;
mod model;
mod similarity;
mod sky;
mod text;
mod warnings;

use super::{Camera, FovAxis, Scene};
use error::brief;
use std::path::{Path, PathBuf};

pub use error::{FileError, LoadError, Place};
pub use gltf::LightUnits;
pub use sky::{Sky, SkySource};

/// How to load a scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Options {
    /// Values of the scene's parameters (`-D name=value`); they win over the scene's own.
    pub defines: Vec<(String, String)>,
    /// Leave out shapes whose mesh file is missing, and draw missing textures as an even grey of 0.5, with a warning
    /// for each of the two kinds.
    pub skip_missing: bool,
    /// The moment of a glTF file's animations, in seconds; without one, everything is drawn as its nodes stand in the file.
    pub animation_time: Option<f32>,
    /// Light from infinity; an error where the file has its own.
    pub environment: Option<Sky>,
    /// In which units the lamps of glTF are [default: "Standard", unless the numbers of a file by Blender tell others].
    pub light_units: Option<LightUnits>,
    /// The camera that takes the picture: its name, that of its node, or its number, counted from 0 in the order in which
    /// the file places them [default: the first].
    pub camera: Option<String>,
    /// The scene of a glTF file: its name, or its number, counted from 0 [default: the one that the file names].
    pub scene: Option<String>,
    /// Frames per second at which the animated camera of a glTF file is followed, for [`Loaded::track`].
    pub track: Option<f64>,
}

/// A scene, and what is not of the picture.
#[derive(Clone, Debug)]
pub struct Loaded {
    /// The scene, checked by [`Scene::validate`].
    pub scene: Scene,
    /// What is drawn differently, or not used: one line each; of many that are alike the first few.
    pub warnings: Vec<String>,
    /// The names of every camera of the file, in their order; one may have none, or two.
    pub cameras: Vec<Vec<String>>,
    /// Which of them takes the picture; `None` where there is none.
    pub camera: Option<usize>,
    /// Along which axis the camera's angle of view is given in the file.
    pub fov_axis: FovAxis,
    /// The camera that takes the picture at every frame of the animations, 0 at their start, where it was asked for.
    pub track: Vec<Camera>,
    /// The files that were read for it: scene text, meshes, materials, images, buffers.
    pub files: Vec<PathBuf>,
}

/// [`open`], without the cameras: the scene and warnings.
///
/// # Errors
/// As [`open`].
pub fn load(path: &Path, options: &Options) -> Result<(Scene, Vec<String>), LoadError> {
    open(path, options).map(|loaded| (loaded.scene, loaded.warnings))
}

/// Loads a scene, the format chosen by the extension: `xml` (Mitsuba), `gltf` or `glb`; `obj`, `ply` and `stl` are seen from
/// a corner under an even sky.
///
/// # Errors
/// Anything unreadable, and whatever would make the picture wrong; one line with file, place and element.
pub fn open(path: &Path, options: &Options) -> Result<Loaded, LoadError> {
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
    let refuse = |option: &str, what: &str| Err(FileError::new(path, format_args!("{option}: {what}")));
    let mut loaded = match extension.as_str() {
        "xml" => {
            if options.scene.is_some() {
                refuse("--scene", "Mitsuba scenes are one scene each")?;
            }
            if options.animation_time.is_some() {
                refuse("--frame, --time-of-animation", "only glTF scenes have animations")?;
            }
            if options.light_units.is_some() {
                refuse("--light-units", "Mitsuba scenes have units of their own")?;
            }
            if options.track.is_some() {
                refuse("camera:NAME@FPS", "only glTF scenes have animated cameras")?;
            }
            mitsuba::load(path, options)?
        }
        "gltf" | "glb" => {
            if let Some((name, _)) = options.defines.first() {
                refuse(&format!("-D {name}"), "glTF scenes have no parameters")?;
            }
            gltf::load(path, options)?
        }
        "obj" | "ply" | "stl" => model::load(path, &extension, options)?,
        other => return Err(FileError::new(path, not_a_scene(other)).into()),
    };
    let Loaded { scene, warnings, files, .. } = &mut loaded;
    files.push(path.into());
    if let Some(sky) = &options.environment {
        scene.environment = Some(sky.environment(warnings)?);
        if let SkySource::Picture(path) = &sky.source {
            files.push(path.clone());
        }
    }
    if matches!(extension.as_str(), "gltf" | "glb") && !scene.shines() {
        warnings.push(format!("{}: {}", path.display(), dark::GLTF));
    }
    scene.validate().map_err(|e| FileError::new(path, e))?;
    // Names in them may hold anything; a terminal obeys control characters.
    let plain = loaded.warnings.into_iter().map(|w| w.replace(char::is_control, " ")).collect();
    loaded.warnings = warnings::condense(plain);
    Ok(loaded)
}

/// What to do about a file of another kind, by its extension.
fn not_a_scene(extension: &str) -> String {
    let what = match extension {
        "blend" => "a file of Blender: export it as glTF (File > Export > glTF 2.0, with Punctual Lights and Cameras)",
        "fbx" => "FBX is not read: import it into Blender and export glTF (.glb)",
        "usd" | "usda" | "usdc" | "usdz" => "USD is not read: import it into Blender and export glTF (.glb)",
        "dae" | "3ds" | "abc" | "x3d" => "this format is not read: import it into Blender and export glTF (.glb)",
        "pbrt" => "scenes of pbrt are not read: export glTF (.glb) or Mitsuba XML",
        "" => "not a scene: no extension that tells what it is",
        _ => "not a scene",
    };
    format!("{what}; the extension must be xml (Mitsuba), gltf or glb, or obj, ply or stl for a quick look at a model")
}

/// One line for all missing files of a kind, which names the first few.
fn left_out(what: &str, names: &[String]) -> Option<String> {
    let first = names.iter().take(3).map(brief).collect::<Vec<_>>().join(", ");
    let more = if names.len() > 3 { ", …" } else { "" };
    (!names.is_empty()).then(|| format!("--skip-missing: {} {what} {first}{more}", names.len()))
}
