//! Tables for shaders: the look-up as WGSL functions, and tables as the bytes of a storage buffer.
//!
//! Any engine that compiles WGSL can include the text of [`source`] in a module of its own, and bind one buffer of `u32`, which
//! [`Tables`] fills. The functions to call:
//!
//! ```wgsl
//! fn mean_brdf(table: u32, axis: vec3f, solid_angle: f32, wo: vec3f) -> f32
//! fn mean_brdf_schlick(table: u32, f0: f32, axis: vec3f, solid_angle: f32, wo: vec3f) -> f32
//! fn mean_brdf_diffuse(table: u32) -> vec3f
//! fn mean_brdf_specular(table: u32) -> vec3f
//! fn mean_brdf_projected_solid_angle(axis: vec3f, solid_angle: f32) -> f32
//! ```
//!
//! `table` is what [`Tables::push`] returned; directions are unit vectors in the local frame (z = normal), `solid_angle` in (0, 2π]
//! sr, `axis.z` ≥ 0. The first is [`Table::specular_values`], the second [`Table::values_with_fresnel`] for Schlick's reflectance;
//! then albedo and strength of the material, and the irradiance of a cap over its radiance. Every other name begins with `mb_` or
//! `Mb`. The functions use no built-in transcendental function, whose precision WGSL leaves open to the fourth digit.
//!
//! ```
//! use brdf_tables::wgsl::{Buffer, Tables, source};
//! use brdf_tables::Table;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let mut tables = Tables::new();
//! let phong = tables.push(&Table::from_bytes(include_bytes!("../../../tables/phong-100.tbl"))?)?;
//! let shader = source(&Buffer::Bound { group: 0, binding: 3 }) + &format!("
//!     @fragment
//!     fn shade() -> @location(0) vec4f {{
//!         let e = 2.0; // irradiance of a light that fills a cap of 0.1 sr, W/m²
//!         let f = mean_brdf({phong}u, vec3f(0.6, 0.0, 0.8), 0.1, vec3f(-0.6, 0.0, 0.8));
//!         return vec4f(vec3f(e * f), 1.0);
//!     }}");
//! let storage_buffer: &[u8] = tables.bytes();
//! # assert!(shader.contains("@group(0) @binding(3)") && storage_buffer.len() % 4 == 0);
//! # Ok(())
//! # }
//! ```

mod model;
mod source;
mod words;

pub use source::{Buffer, source};
pub use words::{Tables, WgslError};

#[cfg(doc)]
use crate::table::Table;
