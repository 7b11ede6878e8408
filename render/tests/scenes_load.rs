//! The scene loaders, from outside.
//!
//! - `shared`: real scenes of the optional folder `../shared/scenes`

#[path = "scenes_load/shared.rs"]
mod shared;
