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
#[path = "support/lamp_shapes.rs"]
mod lamp_shapes;
#[path = "cached/lamps.rs"]
mod lamps;
#[path = "cached/lens.rs"]
mod lens;
#[path = "cached/library.rs"]
mod library;
#[path = "cached/live.rs"]
mod live;
#[path = "cached/mixtures.rs"]
mod mixtures;
#[path = "cached/pictures.rs"]
mod pictures;
#[path = "support/pieces.rs"]
mod pieces;
#[path = "cached/spacing.rs"]
mod spacing;
#[path = "cached/splat.rs"]
mod splat;
#[path = "cached/strips.rs"]
mod strips;
#[path = "cached/textures.rs"]
mod textures;
#[path = "cached/translation.rs"]
mod translation;
#[path = "cached/walk.rs"]
mod walk;
