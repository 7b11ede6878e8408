//! The tests that cross crates, as a table of contents.

/// Reflection models: reciprocity, energy, sampling, precision, recipes.
mod models;
/// Damaged table files, for `tables`.
mod hostile;
/// The mean BRDF: truths, errors of every representation, limits, the file.
mod tables;
