//! What irradiance records say of a point.

use crate::cache::{FOUND, Lookup, Weight};
use crate::record::Record;
use crate::record::irradiance::IrradianceRecord;
use crate::scene::Rgb;
use glam::Vec3A;

/// What records say together.
#[derive(Clone, Copy, Debug)]
pub struct Interpolated {
    /// E, W·m⁻².
    pub irradiance: Rgb,
    /// Mean radius of their zones.
    pub radius: f32,
}

/// Irradiance about `normal`, which a texture may have bent, from the records of the hemisphere about another; `None` where none
/// reaches.
#[inline]
pub fn interpolated(
    records: &impl Lookup<IrradianceRecord>,
    position: Vec3A,
    hemisphere: Vec3A,
    normal: Vec3A,
) -> Option<Interpolated> {
    let (mut irradiance, mut radius, mut weights) = (Rgb::ZERO, 0.0, 0.0);
    records.interpolate(position, hemisphere, Weight::Smooth, |record, w| {
        irradiance += record.at(position, normal) * w;
        radius += record.radius() * w;
        weights += w;
    });
    (weights > FOUND).then(|| Interpolated { irradiance: irradiance / weights, radius: radius / weights })
}
