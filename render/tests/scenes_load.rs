//! The scene loaders, from outside.
//!
//! - `text`: parameters, includes, references, transforms, numbers, and where errors point
//! - `spectra`: colours
//! - `camera`: sensor, film, filter
//! - `materials`: scattering models, textures, emitters
//! - `meshes`: every mesh format, good, damaged and hostile
//! - `images`: every image format, good, damaged and hostile
//! - `files`: missing files, their names and encodings
//! - `gltf`: glTF, good, damaged and hostile
//! - `gltf_variety`: glTF as others write it
//! - `own`: the project's own scenes in `tests/scenes`
//! - `shared`: real scenes of the optional folder `../shared/scenes`

#[path = "scenes_load/camera.rs"]
mod camera;
#[path = "scenes_load/files.rs"]
mod files;
#[path = "scenes_load/gltf.rs"]
mod gltf;
#[path = "scenes_load/gltf_variety.rs"]
mod gltf_variety;
#[path = "scenes_load/images.rs"]
mod images;
#[path = "scenes_load/materials.rs"]
mod materials;
#[path = "scenes_load/meshes.rs"]
mod meshes;
#[path = "scenes_load/own.rs"]
mod own;
#[path = "scenes_load/shared.rs"]
mod shared;
#[path = "scenes_load/spectra.rs"]
mod spectra;
#[path = "scenes_load/text.rs"]
mod text;

use render::scene::{Scene, load};
use std::path::PathBuf;
use tempfile::TempDir;

/// A folder with the files of one test.
struct Folder(TempDir);

type Loaded = Result<(Scene, Vec<String>), String>;

impl Folder {
    fn new() -> Self {
        Self(TempDir::new().expect("a temporary folder"))
    }

    fn with(self, name: &str, content: impl AsRef<[u8]>) -> Self {
        let path = self.0.path().join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, content).unwrap();
        self
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Loads a file; the folder is taken off error messages, which must be one line.
    fn load(&self, name: &str, defines: &[(&str, &str)]) -> Loaded {
        let defines = defines.iter().map(|(n, v)| (n.to_string(), v.to_string())).collect();
        self.load_with(name, &load::Options { defines, ..load::Options::default() })
    }

    fn load_with(&self, name: &str, options: &load::Options) -> Loaded {
        let folder = format!("{}/", self.0.path().display());
        let loaded = load::load(&self.path(name), options).map_err(|e| e.to_string().replace(&folder, ""));
        loaded.as_ref().map_err(|e| assert!(!e.contains('\n'), "{e}")).ok();
        loaded.map(|(scene, warnings)| (scene, warnings.into_iter().map(|w| w.replace(&folder, "")).collect()))
    }

    /// Loads a scene of version 3 with a camera and `body`.
    fn scene(self, body: &str) -> Loaded {
        self.with("scene.xml", scene_text("3.0.0", body)).load("scene.xml", &[])
    }
}

/// A scene file; `body` starts in line 2.
fn scene_text(version: &str, body: &str) -> String {
    format!("<scene version=\"{version}\"><sensor type=\"perspective\"/>\n{body}\n</scene>")
}

/// Loads a scene of version 3.
fn scene(body: &str) -> Scene {
    let (scene, warnings) = Folder::new().scene(body).unwrap_or_else(|e| panic!("{e}"));
    assert!(warnings.is_empty(), "{warnings:#?}");
    scene
}

/// The error of a scene of version 3.
fn error(body: &str) -> String {
    Folder::new().scene(body).expect_err("an error is expected")
}

/// The only warning of a scene of version 3.
fn warning(body: &str) -> String {
    let (_, warnings) = Folder::new().scene(body).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(warnings.len(), 1, "{warnings:#?}");
    warnings.into_iter().next().unwrap()
}
