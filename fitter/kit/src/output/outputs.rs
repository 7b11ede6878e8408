//! The outputs of a command, looked at before the work begins.

use super::place::{Place, folder_of};
use super::{OutputError, plain, temporary};
use std::fs::{self, OpenOptions};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// Whether a file can be made in a folder, found out by making one.
fn probe(folder: &Path) -> Result<(), String> {
    temporary(folder).map(drop).map_err(|e| format!("no file can be written into {}: {}", folder.display(), plain(&e)))
}

/// Looks at a place before any work is done for it.
fn check(path: &Path) -> Result<Option<PathBuf>, String> {
    let open =
        |p: &Path| OpenOptions::new().write(true).open(p).map(drop).map_err(|e| format!("cannot be written: {e}"));
    match Place::of(path)? {
        // Opening a pipe waits for its reader.
        Place::Special { pipe: true } => Ok(None),
        Place::Special { pipe: false } => open(path).map(|()| None),
        Place::File { path: target, old } => {
            if old.is_some() {
                open(&target)?;
            }
            probe(folder_of(&target))?;
            Ok(Some(target))
        }
    }
}

/// The outputs of a command, each apart from the others and from the inputs.
#[derive(Debug, Default)]
pub struct Outputs {
    /// Places resolved, as they were named, and whether it is an input.
    taken: Vec<(PathBuf, PathBuf, bool)>,
}

impl Outputs {
    /// None yet, of a command that reads these files.
    pub fn beside<'a>(inputs: impl IntoIterator<Item = &'a Path>) -> Self {
        let found = inputs.into_iter().filter_map(|path| Some((fs::canonicalize(path).ok()?, path.into(), true)));
        Self { taken: found.collect() }
    }

    /// Refuses a file that cannot be written, or that is written or read besides.
    ///
    /// # Errors
    /// What is wrong with the place.
    pub fn file(&mut self, path: &Path) -> Result<(), OutputError> {
        let fail = |what| OutputError { path: path.into(), what };
        let Some(target) = check(path).map_err(fail)? else { return Ok(()) };
        if let Some((_, other, input)) = self.taken.iter().find(|(taken, ..)| *taken == target) {
            let what = if *input { "is read by this command too" } else { "is written twice by this command" };
            let also = if other == path { String::new() } else { format!(", as {}", other.display()) };
            return Err(fail(format!("{what}{also}")));
        }
        self.taken.push((target, path.into(), false));
        Ok(())
    }

    /// The same for a file whose name must end in one of `extensions`, in any case. Devices and pipes have no such names.
    ///
    /// # Errors
    /// What is wrong with the place.
    pub fn file_of(&mut self, path: &Path, extensions: &[&str]) -> Result<(), OutputError> {
        let fits = path.extension().is_some_and(|e| extensions.iter().any(|x| e.eq_ignore_ascii_case(x)));
        if !fits && !matches!(Place::of(path), Ok(Place::Special { .. })) {
            let names: Vec<_> = extensions.iter().map(|e| format!(".{e}")).collect();
            let what = match names.split_last() {
                Some((last, rest)) if !rest.is_empty() => format!("the name must end in {} or {last}", rest.join(", ")),
                _ => format!("the name must end in {}", names.concat()),
            };
            return Err(OutputError { path: path.into(), what });
        }
        self.file(path)
    }
}

/// Refuses a folder into which no file can be written; one that is missing must be possible to make. Makes none.
///
/// # Errors
/// What is wrong with it.
pub fn check_folder(path: &Path) -> Result<(), OutputError> {
    let fail = |what| OutputError { path: path.into(), what };
    let mut nearest = path;
    loop {
        let folder = if nearest.as_os_str().is_empty() { Path::new(".") } else { nearest };
        match fs::metadata(folder) {
            Ok(found) if found.is_dir() => return probe(folder).map_err(fail),
            Ok(_) if nearest == path => return Err(fail("is a file, not a directory".into())),
            Ok(_) => return Err(fail(format!("{} is a file, not a directory", nearest.display()))),
            Err(e) if e.kind() == ErrorKind::NotFound || e.kind() == ErrorKind::NotADirectory => match nearest.parent()
            {
                Some(parent) => nearest = parent,
                None => return Err(fail(e.to_string())),
            },
            Err(e) => return Err(fail(e.to_string())),
        }
    }
}
