//! Reflection of a record's sources at another point (eas-2015, §3.3, eqs. 15–16 and Fig. 9).

use super::eas::{Eas, EasRecord, Estimator, cap_sine, softened, unpack_normal};
use super::reflector::{Albedo, Reflector};
use crate::frame::Frame;
use crate::record::Record;
use crate::scene::Rgb;
use brdf_tables::batch::CapBatch;
use brdf_tables::cap::projected_solid_angle;
use core::f32::consts::{PI, TAU};
use glam::Vec3A;

/// The point to shade.
#[derive(Clone, Copy, Debug)]
pub struct Receiver {
    /// Position, world space.
    pub position: Vec3A,
    /// Local frame of the shading normal.
    pub frame: Frame,
    /// Unit direction to the eye, local frame.
    pub wo: Vec3A,
}

/// What the sources of a record do at a point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reflected {
    /// Irradiance, W·m⁻²: what the Lambertian part needs.
    pub irradiance: Rgb,
    /// Radiance reflected by the specular part at unit strength, W·m⁻²·sr⁻¹.
    pub specular: Rgb,
}

/// Memory for [`reflect`], reused from point to point.
#[derive(Debug, Default)]
pub struct Scratch {
    caps: CapBatch,
    light: Vec<Rgb>,
    area: Vec<f32>,
    mean: Vec<f32>,
    /// Functions to read harmonics with.
    pub harmonics: super::harmonics::Reader,
}

/// Most a source may grow or shrink on the way to a point of the zone of influence: what is more is not a translation.
const MAX_RATIO: f32 = 4.0;

/// Sources may cover the lobe, or the hemisphere, so many times, or that part of it, before they are scaled.
const ROOM: f32 = 1.15;

/// Most that sources are scaled up where they leave gaps.
const MAX_FILL: f32 = 10.0;

/// Factor that takes a cover to within [`ROOM`] of 1.
#[inline]
fn toward_one(cover: f32) -> f32 {
    match cover {
        x if x > ROOM => ROOM / x,
        x if x > 0.0 && x * ROOM < 1.0 => (1.0 / (ROOM * x)).min(MAX_FILL),
        // Within the room, or nothing that could be scaled.
        _ => 1.0,
    }
}

/// A source as the point sees it.
struct Seen {
    direction: Vec3A,
    solid_angle: f32,
    irradiance: Rgb,
    /// Projected solid angle above the horizon; 0 where the estimator does not know it.
    area: f32,
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
    let Scratch { caps, light, area, mean, .. } = scratch;
    caps.clear();
    light.clear();
    area.clear();
    let mut whole = 0.0;
    let mut out = Reflected::default();
    let offset = at.position - record.position();
    let mirror = Vec3A::new(-at.wo.x, -at.wo.y, at.wo.z);
    for source in &record.sources {
        let seen = match estimator {
            Estimator::Paper => translate_paper(source, offset, &at.frame),
            Estimator::Improved => translate(source, offset, &at.frame),
        };
        let Some(seen) = seen else { continue };
        out.irradiance += seen.irradiance;
        whole += seen.area;
        // Beyond the support angle plus the cap's own, the lobe sees nothing of it.
        if seen.direction.dot(mirror) > albedo.support_cosine(seen.solid_angle) {
            caps.push(seen.direction.into(), seen.solid_angle);
            light.push(seen.irradiance * reflector.tint(seen.direction, at.wo));
            area.push(seen.area);
        }
    }
    mean.resize(caps.len(), 0.0);
    reflector.table.specular_values(caps, at.wo.into(), mean);
    out.specular = light.iter().zip(mean.iter()).map(|(e, f)| *e * *f).sum();
    if estimator == Estimator::Improved {
        // Sources tile the hemisphere of the record, caps do so but roughly, and on the way into a corner all of a wall may
        // meet in one direction: what they would reflect of light that is 1 everywhere must stay near the albedo.
        let unit: f32 = area.iter().zip(mean.iter()).map(|(a, f)| a * f).sum();
        out.specular *= toward_one(unit / albedo.at(at.wo));
        out.irradiance *= (ROOM * PI / whole).min(1.0);
    }
    if record.background != Rgb::ZERO {
        out.irradiance += record.background * PI;
        out.specular += record.background * reflector.tint(mirror, at.wo) * albedo.at(at.wo);
    }
    out
}

/// Direction, squared length and distance ratio of the centroid seen from a point `offset` away: C = x + d·direction, in
/// homogeneous form, so that d = ∞ is a direction only.
fn moved(source: &Eas, offset: Vec3A) -> Option<(Vec3A, f32)> {
    let toward = Vec3A::from_array(source.direction) - offset * source.inv_distance;
    let length2 = toward.length_squared();
    (length2 > 1e-4).then(|| (toward * length2.sqrt().recip(), length2))
}

/// The improved estimator: the cap keeps its radiance, its solid angle follows eq. 16 with bounded foreshortening, and its
/// irradiance is that of the cap above the horizon, exactly.
#[inline(always)]
fn translate(source: &Eas, offset: Vec3A, frame: &Frame) -> Option<Seen> {
    let (toward, length2) = moved(source, offset)?;
    let sine = cap_sine(source.solid_angle);
    let cos_alpha = -unpack_normal(source.normal).dot(toward);
    let ratio = softened(cos_alpha, sine) * source.factor / length2;
    let solid_angle = (source.solid_angle * ratio.clamp(1.0 / MAX_RATIO, MAX_RATIO)).min(TAU);
    let mut direction = frame.to_local(toward);
    let below = -direction.z / sine.max(f32::MIN_POSITIVE);
    if below >= 1.0 {
        return None;
    }
    let mut area = projected_solid_angle(direction.z.max(0.0), solid_angle / TAU);
    if below > 0.0 {
        // Less than half of the cap is above the horizon: it fades out as it sinks.
        area *= (1.0 - below) * (1.0 - below);
        direction.z = 0.0;
        direction = direction.try_normalize()?;
    }
    Some(Seen { direction, solid_angle, irradiance: Rgb::from_array(source.light) * area, area })
}

/// Eq. 16 as published. Where it has no meaning (a patch turned away, a centroid below the horizon) the source is dropped.
fn translate_paper(source: &Eas, offset: Vec3A, frame: &Frame) -> Option<Seen> {
    let (toward, length2) = moved(source, offset)?;
    let direction = frame.to_local(toward);
    let cos_alpha = -unpack_normal(source.normal).dot(toward);
    if direction.z <= 0.0 || cos_alpha <= 0.0 {
        return None;
    }
    let cos_theta = frame.normal().dot(Vec3A::from_array(source.direction));
    let irradiance = Rgb::from_array(source.light) * (direction.z * cos_alpha * source.factor / length2);
    // The stored factor holds both cosines of the record; the solid angle needs that of the patch alone.
    let solid_angle = source.solid_angle * (cos_alpha * source.factor * cos_theta.max(0.01) / length2);
    Some(Seen { direction, solid_angle: solid_angle.min(TAU), irradiance, area: 0.0 })
}
