//! What can go wrong while loading, and where.

use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Place of an element in scene text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// File the element stands in (an included file, where it came from one).
    pub file: Arc<Path>,
    /// Line, counted from 1.
    pub line: u32,
    /// Column in characters, counted from 1.
    pub column: u32,
    /// The element as written, without its children: `<shape type="obj" id="dragon">`.
    pub element: Arc<str>,
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{}:{}:{}: {}", self.file.display(), self.line, self.column, self.element)
    }
}

/// A file that cannot be read or whose content is wrong: scene text that is no XML, mesh, image, buffer.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub struct FileError {
    /// The file.
    pub path: PathBuf,
    /// Line in the file, counted from 1, where it has lines.
    pub line: Option<usize>,
    /// What is wrong, one line.
    pub what: String,
}

impl FileError {
    /// An error of the whole file.
    pub fn new(path: &Path, what: impl fmt::Display) -> Self {
        Self { path: path.into(), line: None, what: one_line(what) }
    }

    /// An error at a line, counted from 1.
    pub fn at(path: &Path, line: usize, what: impl fmt::Display) -> Self {
        Self { line: Some(line), ..Self::new(path, what) }
    }
}

impl fmt::Display for FileError {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self.line {
            Some(line) => write!(f, "{}:{line}: {}", self.path.display(), self.what),
            None => write!(f, "{}: {}", self.path.display(), self.what),
        }
    }
}

/// Why a scene was not loaded. Displays as one line that names file, place and element.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum LoadError {
    /// The scene file itself.
    #[error(transparent)]
    File(#[from] FileError),
    /// An element of the scene text.
    #[error("{place}: {what}")]
    Element {
        /// Where.
        place: Place,
        /// What is wrong, one line.
        what: String,
    },
    /// A file that an element names.
    #[error("{place}: {source}")]
    Asset {
        /// The element.
        place: Place,
        /// The file's own error.
        source: FileError,
    },
}

/// Joins the lines of a library's message into one.
fn one_line(what: impl fmt::Display) -> String {
    what.to_string().split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Reads a regular file of at most `limit` bytes.
pub(crate) fn read_file(path: &Path, limit: u64) -> Result<Vec<u8>, FileError> {
    let metadata = std::fs::metadata(path).map_err(|e| FileError::new(path, format_args!("cannot read: {e}")))?;
    if !metadata.is_file() {
        return Err(FileError::new(path, "not a file"));
    }
    if metadata.len() > limit {
        return Err(FileError::new(path, format_args!("{} bytes, more than the {limit} accepted", metadata.len())));
    }
    std::fs::read(path).map_err(|e| FileError::new(path, format_args!("cannot read: {e}")))
}
