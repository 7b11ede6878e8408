//! From a material to a table of its mean BRDF: integration, fitting, measuring.
pub mod check;
pub mod error;
pub mod explain;
pub mod family;
pub mod fit;
pub mod integrate;
pub mod measured;
pub mod recipe;
#[cfg(feature = "cli")]
pub mod rows;
pub mod solver;
pub mod zonal;
