//! Renders glossy global illumination: scenes, ray tracing, a path tracer, and caches of glossy light.

pub mod bsdf;
pub mod bvh;
pub mod cache;
pub mod camera;
pub mod color;
pub mod denoise;
pub mod film;
pub mod frame;
pub mod glossy;
#[cfg(feature = "gpu")]
pub mod gpu;
pub mod hemisphere;
pub mod image;
pub mod inspect;
pub mod integrator;
pub mod light;
#[cfg(feature = "formats")]
pub mod live;
mod math;
pub mod memory;
pub mod metric;
pub mod outlines;
pub mod picture;
pub mod ray;
pub mod record;
pub mod sampler;
pub mod scene;
mod simd;
#[cfg(feature = "fit")]
pub mod tables;
pub mod walk;
pub mod world;
