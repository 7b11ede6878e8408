//! Hemispheres drawn onto a plane above their point ("Radiance Cache Splatting", 2005, §5.2): by rays, or rasterised by a graphics
//! card (feature `gpu`).
//!
//! The light that surfaces reflect is held beforehand ([`SurfaceLight`], the first bounce), so that a drawing says no more than which
//! piece of a surface is seen in which cell. Both ways read the same pieces, and differ at silhouettes alone.

#[cfg(feature = "gpu")]
mod card;
mod light;
mod patch;
mod traced;

#[cfg(feature = "gpu")]
pub use card::Rasterizer;
pub use light::{PlaneError, SurfaceLight};

use crate::frame::Frame;
use crate::world::Interaction;
use glam::Vec3A;

/// A point with its hemisphere.
#[derive(Clone, Copy, Debug)]
pub struct Viewpoint {
    /// Where rays begin: above the surface by more than its rounding.
    pub eye: Vec3A,
    /// z is the normal.
    pub frame: Frame,
    /// How far it is above.
    pub offset: f32,
}

impl Viewpoint {
    /// On the side of a surface from which it is seen.
    pub fn on(at: &Interaction) -> Self {
        let normal = at.normal * 1f32.copysign(at.normal.dot(at.wo));
        Self { eye: at.origin_towards(normal), frame: Frame::from_normal(normal), offset: at.offset }
    }
}
