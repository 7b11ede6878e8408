//! What a cache keeps at a point: equivalent area light sources or harmonics for glossy surfaces, irradiance for diffuse ones.

mod cut;
pub mod eas;
pub mod harmonics;
mod hessian;
pub mod irradiance;
mod moved;
mod reflector;
mod schlick;
mod together;
mod translate;
mod tree;
mod zone;

/// Numbers that shaders share with the translation of sources.
#[cfg(feature = "gpu")]
pub(crate) mod constants {
    pub(crate) use super::moved::{MAX_RATIO, MIN_LENGTH2};
    pub(crate) use super::translate::{ROOM, TRUSTED};
    /// Of [`super::eas::ViewCone`].
    pub(crate) const FINE: f32 = super::eas::ViewCone::FINE;
    pub(crate) const COARSE: f32 = super::eas::ViewCone::COARSE;
}

pub use cut::{Cut, CutSettings, cut, global_error};
pub use hessian::Hessian;
pub use moved::Receiver;
pub use reflector::{Albedo, Reflector};
pub use together::reflect_together;
pub use translate::{Reflected, Scratch, reflect};
pub use tree::{Centroid, Node, Tree};
pub use zone::{Record, Zone};
