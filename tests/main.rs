//! The tests that cross crates, as a table of contents.

/// Documents: what they name exists.
mod documents;
/// Damaged table files, for `tables`.
mod hostile;
/// Reflection models: reciprocity, energy, sampling, precision, recipes.
mod models;
/// Packages: licences, compilers, what a registry asks for.
mod packages;
/// The mean BRDF: truths, errors of every representation, limits, the file.
mod tables;
