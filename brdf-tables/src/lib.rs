//! Mean BRDF look-up (see the crate README section of the repository).
pub mod axis;
pub mod batch;
pub mod brdf;
pub mod cap;
pub mod cubature;
pub mod frame;
pub mod gauss;
pub mod material;
pub mod mean;
pub mod quadrature;
pub mod real;
pub mod zonal;
