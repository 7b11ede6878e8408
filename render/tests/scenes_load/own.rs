//! The project's own scenes.
