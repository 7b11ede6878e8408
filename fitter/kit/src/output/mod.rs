//! Files that a command writes: looked at before the work begins, then written whole or not at all.
//!
//! A file is written beside its place and renamed. Links are followed, so the file that a link names is replaced and the
//! link stays. Devices and pipes (`/dev/stdout`) are written to directly.

mod outputs;
mod place;
#[cfg(test)]
mod tests;

use crate::pending::Pending;
pub use outputs::{Outputs, check_folder};
use place::{Place, folder_of};
use std::fs::{self, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

/// Why a place cannot be written; one line that names it.
#[derive(Debug, thiserror::Error)]
#[error("{}: {what}", .path.display())]
pub struct OutputError {
    /// As the person named it.
    pub path: PathBuf,
    /// What is wrong.
    pub what: String,
}

/// Writes a file whole or not at all.
///
/// # Errors
/// A place that cannot be written, or not all of it: what was there is then still there.
pub fn write(path: &Path, bytes: &[u8]) -> Result<(), OutputError> {
    let fail = |what| OutputError { path: path.into(), what };
    let written = match Place::of(path).map_err(fail)? {
        Place::Special { .. } => OpenOptions::new()
            .append(true)
            .open(path)
            .and_then(|mut file| file.write_all(bytes).and_then(|()| file.flush())),
        Place::File { path: target, old } => replace(&target, old, bytes),
    };
    written.map_err(|e| fail(plain(&e)))
}

fn replace(target: &Path, old: Option<fs::Metadata>, bytes: &[u8]) -> io::Result<()> {
    let file = temporary(folder_of(target))?;
    let _pending = Pending::new(file.path());
    file.as_file().write_all(bytes)?;
    if let Some(old) = old {
        file.as_file().set_permissions(old.permissions())?;
    }
    // Some systems say only now that there is no room.
    file.as_file().sync_all()?;
    file.persist(target).map(drop).map_err(|e| e.error)
}

/// A file beside its place, with the permissions of any new file.
fn temporary(folder: &Path) -> io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".burnish-").suffix(".tmp");
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder.tempfile_in(folder)
}

/// What the system says, without the path that `tempfile` adds.
fn plain(error: &io::Error) -> String {
    match error.raw_os_error() {
        Some(code) => io::Error::from_raw_os_error(code).to_string(),
        None => error.get_ref().and_then(|e| e.source()).map_or_else(|| error.kind().to_string(), ToString::to_string),
    }
}
