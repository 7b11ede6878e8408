//! Loaders: Mitsuba XML and glTF 2.0 to a [`Scene`].

mod color;
mod error;
mod gltf;
mod image;
/// The readers of mesh files, for fuzzing.
#[doc(hidden)]
pub mod mesh;
mod mitsuba;
mod similarity;

use super::Scene;
use std::path::Path;

pub use error::{FileError, LoadError, Place};

/// Loads a scene, the format chosen by the extension: `xml` (Mitsuba), `gltf` or `glb`. `defines` are the
/// values of the scene's parameters (`-D name=value`). Returns the scene, checked by [`Scene::validate`], and warnings
/// of one line each: what is drawn differently, or not used.
///
/// # Errors
/// Anything unreadable, and whatever would make the picture wrong; one line with file, place and element.
pub fn load(path: &Path, defines: &[(String, String)]) -> Result<(Scene, Vec<String>), LoadError> {
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
    let (scene, warnings) = match extension.as_str() {
        "xml" => mitsuba::load(path, defines)?,
        "gltf" | "glb" => {
            if let Some((name, _)) = defines.first() {
                return Err(FileError::new(path, format_args!("-D {name}: glTF scenes have no parameters")).into());
            }
            gltf::load(path)?
        }
        _ => return Err(FileError::new(path, "not a scene: the extension must be xml, gltf or glb").into()),
    };
    scene.validate().map_err(|e| FileError::new(path, e))?;
    Ok((scene, warnings))
}
