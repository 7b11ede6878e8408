//! What is wrong with a file of measured data, and where.

use core::fmt;
use std::path::{Path, PathBuf};

/// Where in a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Place {
    /// The file as a whole.
    File,
    /// A line of text, from 1.
    Line(usize),
    /// A byte, from 0.
    Byte(u64),
    /// A field of a tensor file.
    Field(String),
}

/// Why measured data are refused.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ReadError {
    /// The file, where there is one.
    pub file: Option<PathBuf>,
    /// Where in it.
    pub place: Place,
    /// What is wrong there.
    pub what: String,
}

impl ReadError {
    pub(crate) fn new(place: Place, what: impl Into<String>) -> Self {
        Self { file: None, place, what: what.into() }
    }

    /// The same, naming the file.
    #[cfg_attr(not(feature = "fs"), expect(dead_code, reason = "files are not read"))]
    pub(crate) fn within(self, file: &Path) -> Self {
        Self { file: Some(file.into()), ..self }
    }
}

impl fmt::Display for ReadError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let file = self.file.as_ref().map(|file| file.display().to_string());
        match (&file, &self.place) {
            (Some(file), Place::Line(line)) => write!(f, "{file}:{line}: ")?,
            (None, Place::Line(line)) => write!(f, "line {line}: ")?,
            (Some(file), _) => write!(f, "{file}: ")?,
            (None, _) => {}
        }
        match &self.place {
            Place::Byte(at) => write!(f, "byte {at}: ")?,
            Place::Field(name) => write!(f, "field `{name}`: ")?,
            Place::File | Place::Line(_) => {}
        }
        f.write_str(&self.what)
    }
}

impl std::error::Error for ReadError {}
