//! Renders glossy global illumination: scenes, ray tracing, a path tracer.

pub mod bsdf;
pub mod bvh;
pub mod camera;
pub mod film;
pub mod frame;
pub mod image;
pub mod integrator;
pub mod light;
pub mod metric;
pub mod ray;
pub mod sampler;
pub mod scene;
pub mod world;
pub mod z_test;
