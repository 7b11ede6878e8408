//! Radiance caching with harmonics (Gautron et al. 2004; Křivánek et al. 2005): the rival of the EAS.
//!
//! A record holds the coefficients of incident radiance and their translational gradients. Reflected radiance is their dot
//! product with the coefficients of the BRDF times cosine. Where the paper turns the radiance of each record into the frame of
//! the point, here the BRDF is turned into the frame of the record: the same number, for a third of the work.

mod basis;
mod brdf;
mod conversion;
#[cfg(feature = "gpu")]
pub(crate) mod flat;
mod gradient;
mod projection;
mod read;
mod rotation;
mod store;

pub use basis::{Basis, MAX_ORDER};
pub use brdf::{HarmonicBrdf, OrderChoice, Outgoing, Summary};
pub use gradient::Gradients;
pub use projection::Projector;
pub use read::Reader;
pub use store::HarmonicsRecord;
#[cfg(feature = "gpu")]
pub(crate) use {
    conversion::bands_for,
    read::{COSINE_ORDER, SAME_NORMAL, frame_of},
};

/// How radiance is projected and stored.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct HarmonicsSettings {
    /// Functions.
    pub basis: Basis,
    /// Whether and how gradients are found.
    pub gradients: Gradients,
    /// Order of the BRDFs, which is that of the records.
    pub order: OrderChoice,
}

/// Share of the squared norm of a lobe that may be lost, over τ.
const ERROR_SHARE: f32 = 0.05;

impl HarmonicsSettings {
    /// Orders follow the tolerance τ unless one is given.
    pub fn new(basis: Basis, gradients: Gradients, tolerance: f32, order: Option<usize>) -> Self {
        let order = order.map_or(OrderChoice::Error(ERROR_SHARE * tolerance), OrderChoice::Fixed);
        Self { basis, gradients, order }
    }
}
