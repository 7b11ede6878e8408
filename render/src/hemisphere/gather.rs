//! One hemisphere of incident radiance: the input of every record (eas-2015, Algorithm 1 and eq. 11).
//!
//! The estimator of radiance is the caller's: any renderer can fill a record.

use super::Cell;
use crate::frame::Frame;
use crate::scene::Rgb;
use glam::{Vec2, Vec3A};

/// What a ray from a record meets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Incident {
    /// Radiance that arrives, W·m⁻²·sr⁻¹; what is not finite counts as black.
    pub radiance: Rgb,
    /// Distance to the surface; infinite for the environment.
    pub distance: f32,
    /// Unit normal of the surface, towards the record; zero without surface.
    pub normal: Vec3A,
}

/// A sampled direction with its share of the hemisphere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GatherSample {
    /// Unit direction, local frame of the record.
    pub direction: Vec3A,
    /// Radiance, W·m⁻²·sr⁻¹.
    pub radiance: Rgb,
    /// 1/distance; 0 for the environment.
    pub inv_distance: f32,
    /// Unit normal where the ray ends, world space.
    pub normal: Vec3A,
    /// Share of the solid angle of the hemisphere, sr.
    pub solid_angle: f32,
    /// Share of its projected solid angle, sr.
    pub projected: f32,
}

impl GatherSample {
    /// Irradiance of the sample, W·m⁻² (eq. 11).
    pub fn irradiance(&self) -> Rgb {
        self.radiance * self.projected
    }
}

/// Distance of the nearest thing that samples met; infinite where they met nothing.
pub fn nearest(samples: &[GatherSample]) -> f32 {
    1.0 / samples.iter().map(|s| s.inv_distance).fold(0.0, f32::max)
}

/// Samples a partition of the hemisphere about `frame`, `per_cell[i]` directions in cell i with density ∝ cosθ, so that
/// constant light gives the exact irradiance of every cell. `point` gives the place of a sample in its cell from the
/// sample's number, `incident` the light from a world direction.
pub fn gather_cells(
    frame: &Frame,
    cells: &[(Cell, u32)],
    mut point: impl FnMut(u32) -> Vec2,
    incident: impl FnMut(Vec3A, u32) -> Incident,
) -> Vec<GatherSample> {
    let place = |cell: &Cell, share: f32, number: u32| {
        let direction = cell.sample_cosine(point(number));
        (direction, cell.solid_angle() * share, cell.projected_solid_angle() * share)
    };
    in_cells(frame, cells, place, incident)
}

/// The same with directions uniform in each cell, so that constant radiance gives the exact solid angle of every cell: what
/// projection needs, whose weights are not cosines.
pub fn gather_cells_uniform(
    frame: &Frame,
    cells: &[(Cell, u32)],
    mut point: impl FnMut(u32) -> Vec2,
    incident: impl FnMut(Vec3A, u32) -> Incident,
) -> Vec<GatherSample> {
    let place = |cell: &Cell, share: f32, number: u32| {
        let direction = cell.sample_uniform(point(number));
        let solid_angle = cell.solid_angle() * share;
        (direction, solid_angle, solid_angle * direction.z)
    };
    in_cells(frame, cells, place, incident)
}

/// `place` gives direction, solid angle and projected solid angle of a sample that has a share of a cell.
fn in_cells(
    frame: &Frame,
    cells: &[(Cell, u32)],
    mut place: impl FnMut(&Cell, f32, u32) -> (Vec3A, f32, f32),
    mut incident: impl FnMut(Vec3A, u32) -> Incident,
) -> Vec<GatherSample> {
    let mut samples = Vec::with_capacity(cells.iter().map(|c| c.1 as usize).sum());
    for (cell, count) in cells {
        for _ in 0..*count {
            let number = samples.len() as u32;
            let (direction, solid_angle, projected) = place(cell, 1.0 / *count as f32, number);
            let light = incident(frame.to_world(direction), number);
            samples.push(sample(direction, light, solid_angle, projected));
        }
    }
    samples
}

/// Samples the hemisphere as the paper does: about `count` directions, stratified and uniform in solid angle, each of
/// 2π/#s sr and with the irradiance of eq. 11.
pub fn gather_uniform(
    frame: &Frame,
    count: u32,
    mut point: impl FnMut(u32) -> Vec2,
    mut incident: impl FnMut(Vec3A, u32) -> Incident,
) -> Vec<GatherSample> {
    // Strata about as wide as high on the hemisphere: azimuths = π heights.
    let heights = ((count as f32 / core::f32::consts::PI).sqrt().round() as u32).max(1);
    let azimuths = (count / heights).max(1);
    let total = heights * azimuths;
    let solid_angle = core::f32::consts::TAU / total as f32;
    (0..total)
        .map(|number| {
            let stratum = Vec2::new((number / azimuths) as f32, (number % azimuths) as f32);
            let u = (stratum + point(number)) / Vec2::new(heights as f32, azimuths as f32);
            let direction = Cell::HEMISPHERE.sample_uniform(u);
            let light = incident(frame.to_world(direction), number);
            sample(direction, light, solid_angle, solid_angle * direction.z)
        })
        .collect()
}

/// Nothing that is not finite gets past here: this is the only door into a record.
fn sample(direction: Vec3A, light: Incident, solid_angle: f32, projected: f32) -> GatherSample {
    let radiance = if light.radiance.is_finite() { light.radiance.max(Rgb::ZERO) } else { Rgb::ZERO };
    let inv_distance = if light.distance > 0.0 { 1.0 / light.distance } else { 0.0 };
    let inv_distance = if inv_distance.is_finite() { inv_distance } else { 0.0 };
    let normal = if light.normal.is_finite() { light.normal } else { Vec3A::ZERO };
    GatherSample { direction, radiance, inv_distance, normal, solid_angle, projected }
}
