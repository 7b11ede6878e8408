//! Reflection of a record's sources at another point (eas-2015, §3.3, eqs. 15–16 and Fig. 9).

use super::eas::{Eas, EasRecord, Estimator, unpack_normal};
use super::moved::{MIN_LENGTH2, Moved, Receiver};
use super::reflector::{Albedo, Reflector};
use crate::frame::Frame;
use crate::record::Record;
use crate::scene::Rgb;
use brdf_tables::batch::CapBatch;
use brdf_tables::real::LANES;
use core::f32::consts::{PI, TAU};
use glam::Vec3A;

/// What the sources of a record do at a point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reflected {
    /// Irradiance, W·m⁻²: what the Lambertian part needs.
    pub irradiance: Rgb,
    /// Radiance reflected by the specular part, W·m⁻²·sr⁻¹: in its colours by [`reflect`], at unit strength from harmonics.
    pub specular: Rgb,
    /// 1 where the sources, moved here, still tile the lobe, falling to 0 where they cover it twice or half:
    /// then they say little of this point.
    pub trust: f32,
}

/// Memory for [`reflect`], reused from point to point.
#[derive(Debug, Default)]
pub struct Scratch {
    caps: CapBatch,
    light: Vec<Rgb>,
    area: Vec<f32>,
    mean: Vec<f32>,
}

/// Sources may cover the hemisphere so many times before their irradiance is scaled down.
pub(crate) const ROOM: f32 = 1.15;

/// Cover, or its inverse, from which on sources are trusted less, and at which they are not at all.
pub(crate) const TRUSTED: [f32; 2] = [1.2, 2.0];

/// How far sources are trusted that cover the lobe so many times.
#[inline]
fn trust(cover: f32) -> f32 {
    let [whole, none] = TRUSTED;
    // A sum over nothing is −0, which must not pass for less than any cover.
    let cover = cover.abs();
    let off = cover.max(cover.recip()).min(none);
    ((none - off) / (none - whole)).min(1.0)
}

/// A source as the point sees it.
pub(super) struct Seen {
    pub direction: Vec3A,
    pub solid_angle: f32,
    pub irradiance: Rgb,
}

impl Scratch {
    /// Forgets the sources of another point.
    pub(super) fn clear(&mut self) {
        self.caps.clear();
        self.light.clear();
        self.area.clear();
    }

    /// A source to look up; `area` is its projected solid angle, 0 where the estimator does not know it.
    #[inline]
    pub(super) fn add(&mut self, seen: &Seen, area: f32, tint: Rgb) {
        self.caps.push_nearest(seen.direction.into(), seen.solid_angle);
        self.light.push(seen.irradiance * tint);
        self.area.push(area);
    }
}

/// Sums E′·F(θ′, Ω′; ωo) over the sources of `record` (eq. 15 at the point). Sources outside the support of the lobe add to
/// the irradiance only.
pub fn reflect(
    record: &EasRecord,
    at: &Receiver,
    reflector: &Reflector,
    albedo: &Albedo,
    estimator: Estimator,
    scratch: &mut Scratch,
) -> Reflected {
    let offset = at.position - record.position();
    let mirror = Vec3A::new(-at.wo.x, -at.wo.y, at.wo.z);
    let tint = |direction| reflector.tint(direction, at.wo);
    let (mut irradiance, mut whole) = (Rgb::ZERO, 0.0);
    scratch.clear();
    match estimator {
        Estimator::Paper => {
            for source in &record.sources {
                let Some(seen) = translate_paper(source, offset, &at.frame) else { continue };
                irradiance += seen.irradiance;
                // Beyond the support angle plus the cap's own, the lobe sees nothing of it.
                if seen.direction.dot(mirror) > albedo.support_cosine(seen.solid_angle) {
                    scratch.add(&seen, 0.0, tint(seen.direction));
                }
            }
        }
        Estimator::Improved => {
            for block in record.sources.chunks(LANES) {
                let moved = Moved::new(block, offset, at, albedo);
                for (lane, source) in block.iter().enumerate() {
                    let area = moved.area[lane];
                    let light = Rgb::from_array(source.light) * area;
                    irradiance += light;
                    whole += area;
                    if moved.near[lane] > 0.0 {
                        let direction = Vec3A::from_array(moved.direction.each_ref().map(|axis| axis[lane]));
                        let seen = Seen { direction, solid_angle: moved.solid_angle[lane], irradiance: light };
                        scratch.add(&seen, area, tint(direction));
                    }
                }
            }
        }
    }
    scratch.reflected(record, at, (reflector, albedo, estimator), irradiance, whole)
}

impl Scratch {
    /// What the sources of a record add up to, those that were added in the specular sum; `whole` is the projected solid angle of all.
    #[inline(always)]
    pub(super) fn reflected(
        &mut self,
        record: &EasRecord,
        at: &Receiver,
        (reflector, albedo, estimator): (&Reflector, &Albedo, Estimator),
        irradiance: Rgb,
        whole: f32,
    ) -> Reflected {
        let Scratch { caps, light, area, mean } = self;
        mean.resize(caps.len(), 0.0);
        reflector.values(caps, at.wo, mean);
        let specular: Rgb = light.iter().zip(mean.iter()).map(|(e, f)| *e * *f).sum();
        let unit: f32 = area.iter().zip(mean.iter()).map(|(a, f)| a * f).sum();
        completed(record, at, (reflector, albedo, estimator), (irradiance, whole), (specular, unit))
    }
}

/// What sources add up to: irradiance and projected solid angle of all, light and white that the lobe sees of them, reflected.
#[inline(always)]
pub(super) fn completed(
    record: &EasRecord,
    at: &Receiver,
    (reflector, albedo, estimator): (&Reflector, &Albedo, Estimator),
    (mut irradiance, whole): (Rgb, f32),
    (mut specular, unit): (Rgb, f32),
) -> Reflected {
    let everywhere = reflector.albedo(albedo, at.wo);
    let mut trusted = 1.0;
    if estimator == Estimator::Improved {
        // Sources tile the hemisphere of the record, caps do so but roughly, and on the way into a corner all of a wall may
        // meet in one direction: what they would reflect of light that is 1 everywhere, against the albedo, tells.
        let reflected = everywhere.1;
        let cover = if reflected > 0.0 { unit / reflected } else { 1.0 };
        trusted = trust(cover);
        irradiance *= (ROOM * PI / whole).min(1.0);
    }
    if record.background != Rgb::ZERO {
        irradiance += record.background * PI;
        specular += record.background * everywhere.0;
    }
    Reflected { irradiance, specular, trust: trusted }
}

/// Eq. 16 as published. Where it has no meaning (a patch turned away, a centroid below the horizon) the source is dropped.
fn translate_paper(source: &Eas, offset: Vec3A, frame: &Frame) -> Option<Seen> {
    // The centroid seen from a point `offset` away, C = x + d·direction, in homogeneous form: d = ∞ is a direction only.
    let toward = Vec3A::from_array(source.direction) - offset * source.inv_distance;
    let length2 = toward.length_squared();
    let toward = toward.try_normalize()?;
    let direction = frame.to_local(toward);
    let [u, v] = source.normal.map(f32::from);
    let cos_alpha = -Vec3A::from_array(unpack_normal(u, v)).dot(toward);
    if direction.z <= 0.0 || cos_alpha <= 0.0 || length2 < MIN_LENGTH2 {
        return None;
    }
    let cos_theta = frame.normal().dot(Vec3A::from_array(source.direction));
    let irradiance = Rgb::from_array(source.light) * (direction.z * cos_alpha * source.factor / length2);
    // The stored factor holds both cosines of the record; the solid angle needs that of the patch alone.
    let solid_angle = source.solid_angle * (cos_alpha * source.factor * cos_theta.max(0.01) / length2);
    Some(Seen { direction, solid_angle: solid_angle.min(TAU), irradiance })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whole trust within a fifth, none from twice or half on, less and less between, and the same for a cover and its inverse.
    #[test]
    fn trust_falls_with_the_cover() {
        assert_eq!([1.0, 1.2, 2.0, 0.5, 0.0, -0.0, f32::INFINITY].map(trust), [1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
        let covers = (0..=20).map(|i| 1.0 + 0.05 * i as f32);
        let values: Vec<f32> = covers.clone().map(trust).collect();
        assert!(values.is_sorted_by(|a, b| a >= b) && values[10] > 0.3 && values[10] < 0.8, "{values:?}");
        assert!(covers.zip(values).all(|(x, value)| (trust(1.0 / x) - value).abs() < 1e-5));
    }
}
