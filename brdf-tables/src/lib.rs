//! Mean BRDFs over spherical caps, looked up from small fitted tables.
//!
//! A cache for glossy light multiplies the irradiance E of an equivalent area light source by the mean BRDF
//! F(θe, Ω; ωo) over its solid angle ("A Radiance Cache Method for Highly Glossy Surfaces", 2015, eqs. 8–9). This crate
//! holds what a renderer links for that: load a [`table::Table`] once, put the sources that light a point into a
//! [`batch::CapBatch`], and ask [`table::Table::specular_values`] for all of them at once, without allocation.
//!
//! - [`cap`], [`frame`]: geometry. The local frame has z along the normal; directions point away from the surface.
//! - [`brdf`], [`material`]: the reflection models and materials. Angles in radian, f_r in sr⁻¹ without the cosine.
//! - [`mean`]: one signature for every way to evaluate F: [`zonal`], [`cubature`], [`lobes`], [`paper`], and [`quadrature`]
//!   as the reference.
//! - [`table`], [`mod@format`], [`errors`], [`axis`]: the file, what it promises, and its grid.
//! - [`real`], [`gauss`]: one number type for scalar and vector code, and quadrature rules.
//!
//! `examples/lookup.rs` is the shortest complete use.
pub mod axis;
pub mod batch;
pub mod brdf;
pub mod cap;
pub mod cubature;
pub mod errors;
pub mod format;
pub mod frame;
pub mod gauss;
pub mod lobe;
pub mod lobes;
pub mod material;
pub mod mean;
pub mod paper;
pub mod quadrature;
pub mod real;
pub mod table;
pub mod zonal;
