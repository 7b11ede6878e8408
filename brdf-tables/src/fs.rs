//! Tables and families in files.

use crate::family::Family;
use crate::format::{FormatError, MAX_FILE};
use crate::table::Table;
use std::fs::File;
use std::io::{Read, Write};
use std::path::Path;

/// The bytes of a file, unless it is larger than any of ours.
fn read(path: &Path) -> Result<Vec<u8>, FormatError> {
    let mut bytes = Vec::new();
    File::open(path)?.take(MAX_FILE + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > MAX_FILE {
        return Err(FormatError::TooLarge);
    }
    Ok(bytes)
}

impl Family {
    /// Loads a family.
    ///
    /// # Errors
    /// As [`Family::from_bytes`], or the file cannot be read.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, FormatError> {
        Self::from_bytes(&read(path.as_ref())?)
    }
}

impl Table {
    /// Loads a table.
    ///
    /// # Errors
    /// As [`Table::from_bytes`], or the file cannot be read.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, FormatError> {
        Self::from_bytes(&read(path.as_ref())?)
    }

    /// Writes the table to a temporary file beside `path`, then renames it: an interrupted run leaves no broken file.
    ///
    /// # Errors
    /// The file cannot be written; `path` is then as it was.
    pub fn save(&self, path: impl AsRef<Path>) -> Result<(), FormatError> {
        let path = path.as_ref();
        let mut name = path.file_name().unwrap_or_default().to_os_string();
        name.push(format!(".{}.tmp", std::process::id()));
        let temporary = path.with_file_name(name);
        let bytes = self.to_bytes()?;
        let write = || -> std::io::Result<()> {
            let mut file = File::create(&temporary)?;
            file.write_all(&bytes)?;
            file.sync_all()?;
            std::fs::rename(&temporary, path)
        };
        write().map_err(|error| {
            // The rename did not happen; what is left of the temporary file is of no use.
            let _ = std::fs::remove_file(&temporary);
            error.into()
        })
    }
}
