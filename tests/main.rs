//! The tests that cross crates, as a table of contents.

/// Reflection models: reciprocity, energy, sampling, precision, recipes.
mod models;
