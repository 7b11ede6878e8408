//! Rays and what they hit.

use glam::Vec3A;

/// A half line, or a part of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Start.
    pub origin: Vec3A,
    /// Direction; need not be a unit vector, and distances along the ray are in its length.
    pub direction: Vec3A,
    /// Hits at this distance or before do not count.
    pub t_min: f32,
    /// Hits at this distance or beyond do not count.
    pub t_max: f32,
    /// Whether it begins at the camera, from which some lamps are not seen.
    pub from_camera: bool,
}

impl Ray {
    /// The whole half line.
    #[inline]
    pub fn new(origin: Vec3A, direction: Vec3A) -> Self {
        Self { origin, direction, t_min: 0.0, t_max: f32::INFINITY, from_camera: false }
    }
}

/// `Hit::instance` of a surface that is not in an instance.
pub const NO_INSTANCE: u32 = u32::MAX;

/// The nearest intersection of a ray so far.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance along the ray; infinite where nothing is hit.
    pub t: f32,
    /// Barycentric weight of a triangle's second vertex.
    pub b1: f32,
    /// Barycentric weight of its third vertex.
    pub b2: f32,
    /// Primitive, in the numbering of the accelerator that found it.
    pub primitive: u32,
    /// Instance that holds the primitive, or [`NO_INSTANCE`].
    pub instance: u32,
}

impl Hit {
    /// No intersection.
    pub const NONE: Self = Self { t: f32::INFINITY, b1: 0.0, b2: 0.0, primitive: u32::MAX, instance: NO_INSTANCE };

    /// Whether there is an intersection.
    #[inline]
    pub fn exists(&self) -> bool {
        self.primitive != u32::MAX
    }
}
