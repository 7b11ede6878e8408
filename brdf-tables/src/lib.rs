//! Mean BRDF look-up (see the crate README section of the repository).
pub mod brdf;
pub mod cap;
pub mod frame;
pub mod real;
