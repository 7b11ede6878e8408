//! The tests that cross crates, as a table of contents.
