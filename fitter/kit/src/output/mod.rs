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
use std::io::{self, BufWriter, Cursor, Seek, Write};
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
    write_as(path, bytes, Kept::OnDisk)
}

/// [`write()`] without waiting for the disk, for what will soon be written again: whoever reads it finds it whole, and a process
/// that is killed leaves it whole; a machine that loses its power may not.
///
/// # Errors
/// As [`write()`].
pub fn write_draft(path: &Path, bytes: &[u8]) -> Result<(), OutputError> {
    write_as(path, bytes, Kept::ByTheSystem)
}

/// Where a file is when its writing is said to be done.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Kept {
    OnDisk,
    ByTheSystem,
}

fn write_as(path: &Path, bytes: &[u8], kept: Kept) -> Result<(), OutputError> {
    let fail = |what| OutputError { path: path.into(), what };
    let written = match Place::of(path).map_err(fail)? {
        Place::Special { .. } => OpenOptions::new()
            .append(true)
            .open(path)
            .and_then(|mut file| file.write_all(bytes).and_then(|()| file.flush())),
        Place::File { path: target, old } => replace(&target, old, bytes, kept),
    };
    written.map_err(|e| fail(plain(&e)))
}

fn replace(target: &Path, old: Option<fs::Metadata>, bytes: &[u8], kept: Kept) -> io::Result<()> {
    let file = temporary(folder_of(target))?;
    let _pending = Pending::new(file.path());
    file.as_file().write_all(bytes)?;
    finish(file, target, old, kept)
}

/// Puts a file that is written into its place.
fn finish(file: NamedTempFile, target: &Path, old: Option<fs::Metadata>, kept: Kept) -> io::Result<()> {
    if let Some(old) = old {
        file.as_file().set_permissions(old.permissions())?;
    }
    if kept == Kept::OnDisk {
        // Some systems say only now that there is no room.
        file.as_file().sync_all()?;
    }
    file.persist(target).map(drop).map_err(|e| e.error)
}

/// Writes a file whole or not at all, piece by piece: what `write` makes need not fit into memory. A device or a pipe gets it when
/// all of it is there.
///
/// # Errors
/// A place that cannot be written, or not all of it, and those of `write`: what was there is then still there.
pub fn write_with<E: From<OutputError>>(
    path: &Path,
    write: impl FnOnce(&mut dyn WriteSeek) -> Result<(), E>,
) -> Result<(), E> {
    let fail = |what| OutputError { path: path.into(), what };
    let io = |e: io::Error| fail(plain(&e));
    let Place::File { path: target, old } = Place::of(path).map_err(fail)? else {
        let mut bytes = Cursor::new(Vec::new());
        write(&mut bytes)?;
        return Ok(self::write(path, &bytes.into_inner())?);
    };
    let file = temporary(folder_of(&target)).map_err(io)?;
    let _pending = Pending::new(file.path());
    let mut buffered = BufWriter::with_capacity(1 << 20, file.as_file());
    write(&mut buffered)?;
    buffered.flush().map_err(io)?;
    drop(buffered);
    finish(file, &target, old, Kept::OnDisk).map_err(io)?;
    Ok(())
}

/// What a file is written to: forwards, and back to where its beginning was left open.
pub trait WriteSeek: Write + Seek {}

impl<T: Write + Seek> WriteSeek for T {}

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
