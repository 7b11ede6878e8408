//! The caches: records against the sums they stand for, pictures against the path tracer, and the places where such
//! methods fail.

#[path = "cached/common.rs"]
mod common;
#[path = "cached/failure.rs"]
mod failure;
#[path = "cached/file.rs"]
mod file;
#[path = "cached/furnace.rs"]
mod furnace;
#[path = "cached/gltf.rs"]
mod gltf;
#[path = "cached/harmonics.rs"]
mod harmonics;
#[path = "cached/library.rs"]
mod library;
#[path = "cached/pictures.rs"]
mod pictures;
#[path = "cached/spacing.rs"]
mod spacing;
#[path = "cached/translation.rs"]
mod translation;
