//! Loaders: Mitsuba XML and glTF 2.0 to a [`Scene`].

mod color;
mod error;
mod files;
mod gltf;
mod image;
/// The readers of mesh files, for fuzzing.
#[doc(hidden)]
pub mod mesh;
mod mitsuba;
mod similarity;
mod text;

use super::Scene;
use error::brief;
use std::path::Path;

pub use error::{FileError, LoadError, Place};

/// How to load a scene.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Options {
    /// Values of the scene's parameters (`-D name=value`); they win over the scene's own.
    pub defines: Vec<(String, String)>,
    /// Leave out shapes whose mesh file is missing, and draw missing textures as an even grey of 0.5, with a warning
    /// for each of the two kinds.
    pub skip_missing: bool,
}

/// Loads a scene, the format chosen by the extension: `xml` (Mitsuba), `gltf` or `glb`. Returns the scene, checked by
/// [`Scene::validate`], and warnings of one line each: what is drawn differently, or not used.
///
/// # Errors
/// Anything unreadable, and whatever would make the picture wrong; one line with file, place and element.
pub fn load(path: &Path, options: &Options) -> Result<(Scene, Vec<String>), LoadError> {
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
    let (scene, warnings) = match extension.as_str() {
        "xml" => mitsuba::load(path, options)?,
        "gltf" | "glb" => {
            if let Some((name, _)) = options.defines.first() {
                return Err(FileError::new(path, format_args!("-D {name}: glTF scenes have no parameters")).into());
            }
            gltf::load(path, options.skip_missing)?
        }
        _ => return Err(FileError::new(path, "not a scene: the extension must be xml, gltf or glb").into()),
    };
    scene.validate().map_err(|e| FileError::new(path, e))?;
    // Names in them may hold anything; a terminal obeys control characters.
    let warnings = warnings.into_iter().map(|w| w.replace(char::is_control, " ")).collect();
    Ok((scene, warnings))
}

/// One line for all missing files of a kind, which names the first few.
fn left_out(what: &str, names: &[String]) -> Option<String> {
    let first = names.iter().take(3).map(brief).collect::<Vec<_>>().join(", ");
    let more = if names.len() > 3 { ", …" } else { "" };
    (!names.is_empty()).then(|| format!("--skip-missing: {} {what} {first}{more}", names.len()))
}
