//! From a material to a table of its mean BRDF: integration, fitting, measuring.
pub mod check;
pub mod command;
pub mod error;
pub mod figure;
pub mod fit;
pub mod integrate;
pub mod recipe;
pub mod solver;
pub mod zonal;
