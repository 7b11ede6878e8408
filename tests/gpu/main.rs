//! What runs on a graphics card, or on what stands in for one; skipped, saying so, where there is none.

/// Pictures from records.
mod card;
/// Hemispheres drawn onto planes.
mod hemispheres;
/// Look-ups of tables.
mod shaders;
