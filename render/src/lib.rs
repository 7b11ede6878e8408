//! Renders glossy global illumination: scenes, ray tracing, a path tracer.

pub mod scene;
