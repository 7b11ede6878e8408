//! Loaders: Mitsuba XML and glTF 2.0 to a [`Scene`].

mod color;
mod dark;
mod error;
mod files;
mod gltf;
mod image;
/// The readers of mesh files, for fuzzing.
#[doc(hidden)]
pub mod mesh;
mod mitsuba;
mod similarity;
mod sky;
mod text;

use super::Scene;
use error::brief;
use std::path::Path;

pub use error::{FileError, LoadError, Place};
pub use sky::{Sky, SkySource};

/// How to load a scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Options {
    /// Values of the scene's parameters (`-D name=value`); they win over the scene's own.
    pub defines: Vec<(String, String)>,
    /// Leave out shapes whose mesh file is missing, and draw missing textures as an even grey of 0.5, with a warning
    /// for each of the two kinds.
    pub skip_missing: bool,
    /// Light from infinity; an error where the file has its own.
    pub environment: Option<Sky>,
}

/// Loads a scene, the format chosen by the extension: `xml` (Mitsuba), `gltf` or `glb`. Returns the scene, checked by
/// [`Scene::validate`], and warnings of one line each: what is drawn differently, or not used.
///
/// # Errors
/// Anything unreadable, and whatever would make the picture wrong; one line with file, place and element.
pub fn load(path: &Path, options: &Options) -> Result<(Scene, Vec<String>), LoadError> {
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
    let (mut scene, mut warnings, dark) = match extension.as_str() {
        "xml" => {
            let (scene, warnings) = mitsuba::load(path, options)?;
            (scene, warnings, dark::MITSUBA)
        }
        "gltf" | "glb" => {
            if let Some((name, _)) = options.defines.first() {
                return Err(FileError::new(path, format_args!("-D {name}: glTF scenes have no parameters")).into());
            }
            let (scene, warnings) = gltf::load(path, options.skip_missing)?;
            (scene, warnings, dark::GLTF)
        }
        _ => return Err(FileError::new(path, "not a scene: the extension must be xml, gltf or glb").into()),
    };
    if let Some(sky) = &options.environment {
        scene.environment = Some(sky.environment(&mut warnings)?);
    }
    if !scene.shines() {
        warnings.push(format!("{}: {dark}", path.display()));
    }
    scene.validate().map_err(|e| FileError::new(path, e))?;
    Ok((scene, warnings))
}

/// One line for all missing files of a kind, which names the first few.
fn left_out(what: &str, names: &[String]) -> Option<String> {
    let first = names.iter().take(3).map(brief).collect::<Vec<_>>().join(", ");
    let more = if names.len() > 3 { ", …" } else { "" };
    (!names.is_empty()).then(|| format!("--skip-missing: {} {what} {first}{more}", names.len()))
}
