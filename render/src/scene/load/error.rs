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
        write!(f, "{}:{}:{}: {}", shown(&self.file), self.line, self.column, self.element)
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
    /// Whether there is no such file.
    pub missing: bool,
}

impl FileError {
    /// An error of the whole file.
    pub fn new(path: &Path, what: impl fmt::Display) -> Self {
        Self { path: path.into(), line: None, what: brief(what), missing: false }
    }

    /// An error at a line, counted from 1.
    pub fn at(path: &Path, line: usize, what: impl fmt::Display) -> Self {
        Self { line: Some(line), ..Self::new(path, what) }
    }

    fn unreadable(path: &Path, error: &std::io::Error) -> Self {
        let missing = matches!(error.kind(), std::io::ErrorKind::NotFound | std::io::ErrorKind::NotADirectory);
        Self { missing, ..Self::new(path, format_args!("cannot read: {error}")) }
    }

    /// The same error with advice after it.
    pub(crate) fn advise(mut self, advice: impl fmt::Display) -> Self {
        self.what = format!("{}; {}", self.what, brief(advice));
        self
    }
}

impl fmt::Display for FileError {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self.line {
            Some(line) => write!(f, "{}:{line}: {}", shown(&self.path), self.what),
            None => write!(f, "{}: {}", shown(&self.path), self.what),
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
    #[error("{place}: {}", brief(what))]
    Element {
        /// Where.
        place: Place,
        /// What is wrong, one line.
        what: String,
    },
    /// A file that an element names.
    #[error("{place}: {error}")]
    Asset {
        /// The element.
        place: Place,
        /// The file's own error; no `source`, which would be printed twice.
        error: FileError,
    },
}

/// More of a text than this, in characters, does not go into a message.
const MAX_TEXT: usize = 300;
/// The same for what has no blanks: a data URI.
const MAX_WORD: usize = 100;
/// The same for a path.
const MAX_PATH: usize = 512;

/// Text of a file or of a library as part of a message: in one line, and never a whole file or data URI.
pub(crate) fn brief(text: impl fmt::Display) -> String {
    let text = text.to_string();
    let words = text.split(|c: char| c.is_whitespace() || c.is_control()).filter(|w| !w.is_empty());
    cut(&words.map(|w| cut(w, MAX_WORD)).collect::<Vec<_>>().join(" "), MAX_TEXT)
}

fn cut(text: &str, limit: usize) -> String {
    match text.char_indices().nth(limit) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text.to_string(),
    }
}

/// A path as part of a message: a scene may call for names with line breaks, or of any length.
fn shown(path: &Path) -> String {
    cut(&path.display().to_string().replace(char::is_control, "?"), MAX_PATH)
}

/// Reads a regular file of at most `limit` bytes.
pub(crate) fn read_file(path: &Path, limit: u64) -> Result<Vec<u8>, FileError> {
    let metadata = std::fs::metadata(path).map_err(|e| FileError::unreadable(path, &e))?;
    if !metadata.is_file() {
        return Err(FileError::new(path, "not a file"));
    }
    if metadata.len() > limit {
        return Err(FileError::new(path, format_args!("{} bytes, more than the {limit} accepted", metadata.len())));
    }
    std::fs::read(path).map_err(|e| FileError::unreadable(path, &e))
}
