//! How far a record reaches: every rule about validity is here.

use super::Cache;
use crate::record::{Hessian, Record};
use glam::Vec3A;

/// What else than distances decides how far records reach.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Spacing {
    /// Radii follow the curvature of the light (its Hessian) instead of the distance of what is seen.
    pub hessian: bool,
    /// Records that differ by more than this fraction where they overlap reach less far ([`super::disagreeing`]).
    pub adaptive: Option<f32>,
}

impl Spacing {
    /// Radii by distance alone, as in 2015.
    pub const DISTANCE: Self = Self { hessian: false, adaptive: None };
}

/// By curvature: an extrapolation by gradients lies above every dome of light, 2 to 3 % where radii follow distances.
impl Default for Spacing {
    fn default() -> Self {
        Self { hessian: true, adaptive: None }
    }
}

/// Step of the differences that tell how the light bends, over the radius by distance.
const STEP: f32 = 0.25;

/// Radius of a record from the distance of what it sees, kept between bounds in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RadiusPolicy {
    /// Radius over distance.
    pub scale: f32,
    /// Smallest radius, in pixels at the record.
    pub min_pixels: f32,
    /// Largest radius, in pixels at the record.
    pub max_pixels: f32,
}

impl RadiusPolicy {
    /// The radius for a distance (minimum or mean, infinite where nothing was met) and the width of a pixel there.
    pub fn radius(&self, distance: f32, footprint: f32) -> f32 {
        self.bounded(self.scale * distance, footprint)
    }

    /// A radius found otherwise, between the bounds.
    pub fn bounded(&self, radius: f32, footprint: f32) -> f32 {
        let (low, high) = (self.min_pixels * footprint, self.max_pixels * footprint);
        radius.clamp(low, high.max(low)).max(f32::MIN_POSITIVE)
    }

    /// The radius within which second-order terms of the reflected light are this share of it in the mean, and what is met at
    /// `nearest` is no nearer; `reflected` tells the light at a displacement in the tangent plane.
    pub fn by_bending(
        &self,
        nearest: f32,
        footprint: f32,
        curvature: f32,
        mut reflected: impl FnMut(f32, f32) -> f32,
    ) -> f32 {
        let step = STEP * self.radius(nearest, footprint);
        let bend = Hessian::of(step, &mut reflected).radius(reflected(0.0, 0.0), curvature);
        self.bounded(bend.min(nearest), footprint)
    }
}

/// Adds a record whose radius its neighbours may bound, but not below `smallest`.
pub fn insert_clamped<R: Record>(cache: &mut Cache<R>, (mut record, smallest): (R, f32)) {
    let radius = clamp_to_neighbours(cache, record.position(), record.radius(), smallest);
    record.set_radius(radius);
    cache.insert(record);
}

/// Neighbour clamping (Křivánek et al. 2006).
///
/// The radius of a record is meant to follow its distance to the nearest surface. By the triangle inequality the distances of two
/// records differ by no more than the records are apart, but a gather may miss a small thing nearby, and then a radius is
/// too large. So where the new record lies within the reach of another, the larger of both radii is cut down to the smaller one plus
/// the distance between them. Shrinks the neighbours in the cache, returns the radius of the new record; neither becomes less
/// than `smallest`.
pub fn clamp_to_neighbours<R: Record>(cache: &mut Cache<R>, position: Vec3A, radius: f32, smallest: f32) -> f32 {
    let mut neighbours = Vec::new();
    cache.octree.visit(position, |i| neighbours.push(i as usize));
    let mut clamped = radius;
    for &i in &neighbours {
        let other = &cache.records[i];
        let distance = other.position().distance(position);
        if distance < other.radius() {
            clamped = clamped.min(other.radius() + distance);
        }
    }
    let clamped = clamped.max(smallest.min(radius));
    for i in neighbours {
        let other = &mut cache.records[i];
        let distance = other.position().distance(position);
        if distance < other.radius() && other.radius() > clamped + distance {
            other.set_radius(clamped + distance);
        }
    }
    clamped
}

/// Weight of a record at a point, by distance and normal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Weight {
    /// Ward et al. 1988: 1/(d/r + √(1 − n·n′)), cut off at 1.
    Ward,
    /// (1 − d/r)(1 − √(1 − n·n′)/s): falls to zero where the zone ends, so that no record appears at a step. s is the value
    /// of the root at 25 degrees.
    Smooth,
}

/// √(1 − cos 25°).
pub(crate) const NORMAL_SPREAD: f32 = 0.306;

/// How far behind a record a point may lie, in its radii.
pub(crate) const BEHIND: f32 = -0.1;

impl Weight {
    /// The weight, 0 where the record does not count: out of its zone, or behind it.
    #[inline]
    pub fn of<R: Record>(self, record: &R, position: Vec3A, normal: Vec3A) -> f32 {
        let offset = position - record.position();
        let radius = record.radius();
        let distance2 = offset.length_squared();
        if distance2 >= radius * radius {
            return 0.0;
        }
        // A point behind the record is lit by other things (Ward's test in front, with room for curvature).
        if offset.dot(normal + record.normal()) < BEHIND * radius {
            return 0.0;
        }
        let near = distance2.sqrt() / radius;
        let turned = (1.0 - normal.dot(record.normal())).max(0.0).sqrt();
        match self {
            Self::Ward => {
                let error = near + turned;
                if error < 1.0 { 1.0 / error.max(1e-4) } else { 0.0 }
            }
            Self::Smooth => (1.0 - near) * (1.0 - turned * (1.0 / NORMAL_SPREAD)).max(0.0),
        }
    }
}
