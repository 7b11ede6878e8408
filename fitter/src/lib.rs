//! fitter
pub mod recipe;
pub mod solver;
