//! Files that scenes name.

use super::error::FileError;
use std::borrow::Cow;
use std::path::{Path, PathBuf};

/// Entries of a folder that are looked through for a name of another case.
const MAX_ENTRIES: usize = 10_000;

/// Folders in which file names are looked up: the scene's own first, then those of `path` elements.
pub struct Folders(pub Vec<PathBuf>);

impl Folders {
    /// `name` in the first folder that holds it, or beside `file`, where it is named; the first folder if it is
    /// nowhere, so that the error names a sensible path. Where there is no such file, backslashes are separators, as
    /// scenes of Windows have them.
    pub fn resolve(&self, file: &Path, name: &str) -> PathBuf {
        let all = |name: &str| self.all(file).map(|f| f.join(name)).find(|p| p.exists());
        let found = all(name).or_else(|| name.contains('\\').then(|| all(&name.replace('\\', "/"))).flatten());
        found.unwrap_or_else(|| self.0[0].join(name))
    }

    /// The error of a file that `file` calls `name`, with what it may be called instead, where it is missing.
    pub fn advise(&self, file: &Path, name: &str, error: FileError) -> FileError {
        if !error.missing {
            return error;
        }
        match self.similar(file, name) {
            Some(path) => error.advise(format_args!("did you mean {}?", path.display())),
            None => error,
        }
    }

    /// A file of this name but for the case of its letters, else one of the same last name in one of the folders.
    fn similar(&self, file: &Path, name: &str) -> Option<PathBuf> {
        let name = if name.contains('\\') { Cow::from(name.replace('\\', "/")) } else { Cow::from(name) };
        let last = name.rsplit('/').next().unwrap_or_default();
        [&*name, last].iter().filter(|n| !n.is_empty()).find_map(|name| {
            self.all(file).find_map(|folder| {
                name.split('/').filter(|n| !n.is_empty()).try_fold(folder.to_path_buf(), |path, n| entry(&path, n))
            })
        })
    }

    fn all<'a>(&'a self, file: &'a Path) -> impl Iterator<Item = &'a Path> {
        self.0.iter().map(PathBuf::as_path).chain(file.parent())
    }
}

/// What a folder holds under a name, whatever the case of its letters; the first in order of bytes.
fn entry(folder: &Path, name: &str) -> Option<PathBuf> {
    let same = folder.join(name);
    if same.exists() {
        return Some(same);
    }
    let folder_name = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let entries = std::fs::read_dir(folder_name).ok()?.take(MAX_ENTRIES).filter_map(|e| Some(e.ok()?.file_name()));
    let lower = name.to_lowercase();
    let found = entries.filter(|e| e.to_str().is_some_and(|e| e.to_lowercase() == lower)).min();
    found.map(|name| folder.join(name))
}
