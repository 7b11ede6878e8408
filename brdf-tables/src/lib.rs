//! Mean BRDFs over spherical caps, looked up from small fitted tables.
//!
//! A cache for glossy light multiplies the irradiance E of an equivalent area light source by the mean BRDF
//! F(θe, Ω; ωo) over its solid angle ("A Radiance Cache Method for Highly Glossy Surfaces", 2015, eqs. 8–9). This crate
//! holds what a renderer links for that: load a [`Table`] once, put the sources that light a point into a [`CapBatch`], and
//! ask [`Table::specular_values`] for all of them at once, without allocation.
//!
//! ```
//! use brdf_tables::{CapBatch, Table};
//! use glam::Vec3;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! // Once per material: a file made by `fitter fit`, or bytes that the program holds (`Table::load` reads a path).
//! let table = Table::from_bytes(include_bytes!("../../tables/phong-100.tbl"))?;
//!
//! // Once per shading point: its sources as caps, unit axis in the local frame (z = normal) and solid angle in sr.
//! let mut caps = CapBatch::with_capacity(2);
//! caps.push(Vec3::new(0.6, 0.0, 0.8), 0.10)?;
//! caps.push(Vec3::new(0.0, 0.8, 0.6), 0.05)?;
//! let irradiance = [2.0, 1.0]; // W·m⁻²
//!
//! // Once per view: F of every source in sr⁻¹, then L = Σ E F, here of the specular part at unit strength.
//! let wo = Vec3::new(-0.6, 0.0, 0.8);
//! let mut mean = [0.0; 2];
//! table.specular_values(&caps, wo, &mut mean);
//! let radiance: f32 = irradiance.iter().zip(mean).map(|(e, f)| e * f).sum();
//! assert!((radiance - 16.2).abs() < 0.1, "{radiance} W/(m² sr)");
//! # Ok(())
//! # }
//! ```
//!
//! - The root names what a renderer needs; [`cap`], [`frame`] hold the geometry. The local frame has z along the normal;
//!   directions point away from the surface.
//! - [`brdf`], [`material`]: the reflection models and materials. Angles in radian, f_r in sr⁻¹ without the cosine.
//! - [`mean`]: one signature for every way to evaluate F: [`zonal`], [`cubature`], [`lobes`], [`paper`], and [`quadrature`]
//!   as the reference.
//! - [`table`], [`mod@format`], [`errors`], [`axis`]: the file, what it promises, and its grid.
//!
//! - [`family`]: tables of whatever roughness without a fit.
//!
//! Features, on by default: `fs` ([`Table::load`] and [`Table::save`]), `families` (the families that are shipped, 0.2 MB). Off by
//! default: `measured` (readers of files of measured materials), `wgsl` (look-ups in shaders).

pub mod axis;
pub mod batch;
pub mod brdf;
pub mod cap;
pub mod cubature;
pub mod errors;
pub mod family;
pub mod format;
pub mod frame;
#[cfg(feature = "fs")]
mod fs;
#[doc(hidden)]
pub mod gauss;
pub mod lobe;
pub mod lobes;
pub mod material;
pub mod mean;
#[cfg(feature = "measured")]
pub mod measured;
pub mod paper;
pub mod parts;
pub mod quadrature;
#[doc(hidden)]
pub mod real;
pub mod table;
#[cfg(feature = "wgsl")]
pub mod wgsl;
pub mod zonal;

pub use batch::CapBatch;
pub use brdf::{Brdf, Specular};
pub use cap::{Cap, CapError};
pub use family::Family;
pub use format::FormatError;
pub use material::{Material, MaterialError};
pub use mean::MeanBrdf;
pub use table::Table;
