//! fitter
