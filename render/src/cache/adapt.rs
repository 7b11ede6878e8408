//! Adaptive caching: records reach less far where they disagree (Křivánek et al. 2006, "Making radiance and irradiance
//! caching practical: adaptive caching and neighbor clamping"; SIGGRAPH course 2007).

use super::{Cache, Weight};
use crate::color::luminance;
use crate::record::Record;
use crate::scene::Rgb;
use glam::Vec3A;

/// Weber's law: the eye notices relative differences of 2 to 3 %.
pub const WEBER_FRACTION: f32 = 0.03;

/// A record, by index, and the radius it may have at most.
pub type Shrink = (u32, f32);

/// What the records about a point say of it must not differ from their weighted mean by more than `fraction` of that mean;
/// a record that does reaches no farther than the point, and no less far than `smallest`. `value` is what a record says of
/// the point, `None` for one that does not count there.
pub fn disagreeing<R: Record>(
    cache: &Cache<R>,
    (position, normal): (Vec3A, Vec3A),
    weight: Weight,
    (fraction, smallest): (f32, f32),
    mut value: impl FnMut(&R) -> Option<Rgb>,
) -> Vec<Shrink> {
    let mut found: Vec<(u32, f32, f32)> = Vec::new();
    cache.visit(position, normal, weight, |i, record, w| {
        if let Some(light) = value(record) {
            found.push((i, luminance(light), w));
        }
    });
    if found.len() < 2 {
        return Vec::new();
    }
    let (sum, weights) = found.iter().fold((0.0, 0.0), |(s, t), (_, light, w)| (s + light * w, t + w));
    let mean = sum / weights;
    let wrong = found.iter().filter(|(_, light, _)| (light - mean).abs() > fraction * mean.abs());
    wrong
        .filter_map(|&(i, _, _)| {
            let record = &cache.records()[i as usize];
            let radius = record.position().distance(position).max(smallest);
            (radius < record.radius()).then_some((i, radius))
        })
        .collect()
}

impl<R: Record> Cache<R> {
    /// Applies what [`disagreeing`] found, in any order.
    pub fn shrink(&mut self, shrinks: &[Shrink]) {
        for &(i, radius) in shrinks {
            let record = &mut self.records[i as usize];
            if radius > 0.0 && radius < record.radius() {
                record.set_radius(radius);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::Frame;
    use crate::hemisphere::Incident;
    use crate::record::irradiance::{IrradianceRecord, Strata};
    use glam::Vec2;

    fn record(x: f32, light: f32) -> IrradianceRecord {
        let incident =
            |_: Vec3A, _: u32| Incident { radiance: Rgb::splat(light), distance: f32::INFINITY, normal: Vec3A::ZERO };
        let frame = Frame::from_normal(Vec3A::Z);
        let position = Vec3A::new(x, 0.0, 0.0);
        let strata = Strata::about(64);
        let mut record = IrradianceRecord::gather(position, &frame, strata, |_| Vec2::splat(0.5), incident).record;
        record.set_radius(1.0);
        record
    }

    /// Two records agree and keep their radii; a third that says something else reaches the point of the test only, and the
    /// smallest radius is kept.
    #[test]
    fn records_that_disagree_shrink() {
        let mut cache = Cache::new(Vec3A::splat(-2.0), Vec3A::splat(2.0));
        for (x, light) in [(-0.5, 1.0), (0.0, 1.01), (0.5, 1.2)] {
            cache.insert(record(x, light));
        }
        let at = (Vec3A::new(0.1, 0.0, 0.0), Vec3A::Z);
        let value = |r: &IrradianceRecord| Some(r.at(at.0, at.1));
        let test = |cache: &Cache<_>, smallest| {
            disagreeing(cache, at, Weight::Smooth, (3.0 * WEBER_FRACTION, smallest), value)
        };
        assert_eq!(test(&cache, 0.01), [(2, 0.4)]);
        assert_eq!(test(&cache, 0.6), [(2, 0.6)]);
        let shrinks = test(&cache, 0.01);
        cache.shrink(&shrinks);
        assert_eq!(cache.records()[2].radius(), 0.4);
        assert!(test(&cache, 0.01).is_empty());
    }
}
