//! Mistakes as exceptions, with the line that the command prints.

use brdf_tables::FormatError;
use fitter::fit::FitError;
use fitter::recipe::RecipeError;
use kit::output::OutputError;
use pyo3::PyErr;
use pyo3::exceptions::{PyFileNotFoundError, PyOSError, PyPermissionError, PyValueError};
use std::io;

pyo3::create_exception!(
    brdf_tables,
    BrdfTablesError,
    PyValueError,
    "Bad input: a recipe, a table or numbers outside of the domain. The message is one line that says what and where."
);

/// Bad input.
pub fn bad(line: impl ToString) -> PyErr {
    BrdfTablesError::new_err(line.to_string())
}

/// What the system says of a file as Python does, all else as bad input.
fn of_file(line: String, cause: Option<&io::Error>) -> PyErr {
    match cause.map(io::Error::kind) {
        Some(io::ErrorKind::NotFound) => PyFileNotFoundError::new_err(line),
        Some(io::ErrorKind::PermissionDenied) => PyPermissionError::new_err(line),
        Some(_) => PyOSError::new_err(line),
        None => bad(line),
    }
}

/// A recipe or a file of measured data that is no material.
pub fn recipe(error: &RecipeError) -> PyErr {
    match error {
        RecipeError::Read { source, .. } => of_file(error.to_string(), Some(source)),
        // Their reader keeps no more than the line.
        RecipeError::Measured(read) if read.file.as_ref().is_some_and(|file| !file.exists()) => {
            PyFileNotFoundError::new_err(error.to_string())
        }
        _ => bad(error),
    }
}

/// Bytes that are no table; `file` is their name, if they have one.
pub fn format(file: Option<&str>, error: &FormatError) -> PyErr {
    let line = file.map_or_else(|| error.to_string(), |file| format!("{file}: {error}"));
    let cause = if let FormatError::Io(error) = error { Some(error) } else { None };
    of_file(line, cause)
}

/// A file that cannot be written.
pub fn output(error: &OutputError) -> PyErr {
    PyOSError::new_err(error.to_string())
}

/// A fit that cannot be.
pub fn fit(recipe: &str, error: &FitError) -> PyErr {
    bad(match error {
        FitError::NoLobes { .. } => error.to_string(),
        error => format!("{recipe}: {error}"),
    })
}
