//! What irradiance records say of a point.

use crate::cache::{Cache, FOUND, Weight};
use crate::record::irradiance::IrradianceRecord;
use crate::scene::Rgb;
use glam::Vec3A;

/// Irradiance about `normal`, which a texture may have bent, from the records of the hemisphere about another; `None` where none
/// reaches.
#[inline]
pub fn interpolated(cache: &Cache<IrradianceRecord>, position: Vec3A, hemisphere: Vec3A, normal: Vec3A) -> Option<Rgb> {
    let (mut sum, mut weights) = (Rgb::ZERO, 0.0);
    cache.interpolate(position, hemisphere, Weight::Smooth, |record, w| {
        sum += record.at(position, normal) * w;
        weights += w;
    });
    (weights > FOUND).then(|| sum / weights)
}
