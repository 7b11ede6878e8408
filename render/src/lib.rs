//! Renders glossy global illumination: scenes, ray tracing, a path tracer.

pub mod bvh;
pub mod ray;
pub mod scene;
