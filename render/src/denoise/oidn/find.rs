//! Where the library is.

use super::functions::Functions;
use crate::denoise::DenoiseError;
use libloading::Library;
use std::path::{Path, PathBuf};

/// Names it file or folder.
pub const VARIABLE: &str = "OIDN_LIBRARY";

/// What the library is called, without version; a version stands behind it, or before the last dot.
const NAME: &str = if cfg!(windows) {
    "OpenImageDenoise.dll"
} else if cfg!(target_os = "macos") {
    "libOpenImageDenoise.dylib"
} else {
    "libOpenImageDenoise.so"
};

/// Names under which a system finds it.
const INSTALLED: &[&str] = if cfg!(windows) {
    &[NAME]
} else if cfg!(target_os = "macos") {
    &["libOpenImageDenoise.2.dylib", NAME]
} else {
    &["libOpenImageDenoise.so.2", NAME]
};

/// Loads it from a file or folder, from where [`VARIABLE`] says, or from where the system finds it; tells which file it was.
pub(super) fn load(named: Option<&Path>) -> Result<(Functions, PathBuf), DenoiseError> {
    let of_variable = std::env::var_os(VARIABLE).filter(|value| !value.is_empty()).map(PathBuf::from);
    match named.map(Path::to_path_buf).or(of_variable) {
        Some(place) => {
            let path = file(&place)?;
            let loaded = open(&path).map_err(|reason| DenoiseError::Library { path: path.clone(), reason })?;
            Ok((loaded, path))
        }
        None => {
            let found = INSTALLED.iter().find_map(|name| open(Path::new(name)).ok().map(|f| (f, PathBuf::from(name))));
            found.ok_or(DenoiseError::NotFound)
        }
    }
}

/// The library at a place: the file itself, or that of the newest version in a folder.
fn file(place: &Path) -> Result<PathBuf, DenoiseError> {
    let missing = |_| DenoiseError::Missing(place.to_path_buf());
    let place = place.canonicalize().map_err(missing)?;
    if !place.is_dir() {
        return Ok(place);
    }
    let entries = place.read_dir().map_err(missing)?.filter_map(Result::ok);
    let named = entries.filter_map(|entry| {
        let name = entry.file_name().into_string().ok()?;
        Some((version(&name)?, name))
    });
    match named.max() {
        Some((_, name)) => Ok(place.join(name)),
        None => Err(DenoiseError::NotInFolder(place, NAME)),
    }
}

/// The numbers in the name of the library; `None` for another file.
fn version(name: &str) -> Option<Vec<u32>> {
    let (stem, extension) = NAME.rsplit_once('.')?;
    let rest = name.strip_prefix(stem)?;
    // `.so.2.5.1` or `.2.5.1.dylib`
    let numbers = rest.strip_prefix('.')?.split('.').filter(|part| *part != extension);
    let has_extension = rest.split('.').any(|part| part == extension);
    has_extension.then_some(())?;
    numbers.map(|part| part.parse().ok()).collect()
}

/// Loads a library and looks its functions up.
fn open(path: &Path) -> Result<Functions, String> {
    // SAFETY: the user says that this is Open Image Denoise, or the system has it under that name; loading it runs what it does
    // when it is loaded.
    unsafe {
        let library = Library::new(path).map_err(|error| format!("cannot be loaded: {error}"))?;
        Functions::of(library)
    }
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;

    #[test]
    fn the_newest_version_of_a_folder_is_taken() {
        assert_eq!(version("libOpenImageDenoise.so"), Some(vec![]));
        assert_eq!(version("libOpenImageDenoise.so.2.5.1"), Some(vec![2, 5, 1]));
        for other in
            ["libOpenImageDenoise_core.so.2.5.1", "libOpenImageDenoise.so.old", "libOpenImageDenoise.2", "x.so"]
        {
            assert_eq!(version(other), None, "{other}");
        }
        let folder = tempfile::tempdir().unwrap();
        assert!(matches!(file(folder.path()), Err(DenoiseError::NotInFolder(..))));
        assert!(matches!(file(&folder.path().join("x")), Err(DenoiseError::Missing(_))));
        for name in ["libOpenImageDenoise.so.2.5.1", "libOpenImageDenoise.so.2.10.0", "libOpenImageDenoise_core.so.9"] {
            std::fs::write(folder.path().join(name), "no library").unwrap();
        }
        assert!(file(folder.path()).unwrap().ends_with("libOpenImageDenoise.so.2.10.0"));
    }
}
