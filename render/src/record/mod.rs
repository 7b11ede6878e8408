//! What a cache keeps at a point: equivalent area light sources or harmonics for glossy surfaces, irradiance for diffuse ones.

mod cut;
pub mod eas;
pub mod harmonics;
mod hessian;
pub mod irradiance;
mod moved;
mod reflector;
mod schlick;
mod translate;
mod tree;

pub use cut::{Cut, CutSettings, cut, global_error};
pub use hessian::Hessian;
pub use reflector::{Albedo, Reflector};
pub use translate::{Receiver, Reflected, Scratch, reflect};
pub use tree::{Centroid, Node, Tree};

use glam::Vec3A;

/// A point of a surface with what it stores, as the octree and the radius policy see it.
pub trait Record: Send + Sync {
    /// Position, world space.
    fn position(&self) -> Vec3A;
    /// Unit normal on the lit side.
    fn normal(&self) -> Vec3A;
    /// Radius of the zone of influence, in the unit of the scene.
    fn radius(&self) -> f32;
    /// Sets the radius.
    fn set_radius(&mut self, radius: f32);
    /// Memory, bytes.
    fn bytes(&self) -> usize;
    /// Whether every number it stores is finite.
    fn is_finite(&self) -> bool;
}
