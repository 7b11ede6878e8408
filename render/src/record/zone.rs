//! Where a record is valid: all that the octree, the radius policy and the overlay know of any kind.

use crate::frame::Frame;
use glam::Vec3A;

/// A point of a surface and the ball about it in which a record counts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Zone {
    /// Position, world space.
    pub position: Vec3A,
    /// Unit normal on the lit side.
    pub normal: Vec3A,
    /// Radius of the zone of influence, in the unit of the scene; 0 until it is known.
    pub radius: f32,
    /// Material the record was made for, an index the caller chooses; [`Zone::ANY`] for light that any material reads.
    pub material: u32,
}

impl Zone {
    /// No material of its own.
    pub const ANY: u32 = u32::MAX;

    /// About a surface, its radius not yet known.
    pub fn at(position: Vec3A, frame: &Frame, material: u32) -> Self {
        Self { position, normal: frame.normal(), radius: 0.0, material }
    }

    /// Whether position and normal are finite.
    pub fn is_finite(&self) -> bool {
        self.position.is_finite() && self.normal.is_finite()
    }
}

/// What a record of any kind tells of itself.
pub trait Record: Send + Sync {
    /// Where it is valid.
    fn zone(&self) -> &Zone;
    /// To change where it is valid.
    fn zone_mut(&mut self) -> &mut Zone;
    /// Memory, bytes.
    fn bytes(&self) -> usize;
    /// Whether every number it stores is finite.
    fn is_finite(&self) -> bool;

    /// Position, world space.
    #[inline(always)]
    fn position(&self) -> Vec3A {
        self.zone().position
    }
    /// Unit normal on the lit side.
    #[inline(always)]
    fn normal(&self) -> Vec3A {
        self.zone().normal
    }
    /// Radius of the zone of influence, in the unit of the scene.
    #[inline(always)]
    fn radius(&self) -> f32 {
        self.zone().radius
    }
    /// Sets the radius.
    fn set_radius(&mut self, radius: f32) {
        self.zone_mut().radius = radius;
    }
}
