//! A record of irradiance with its gradients (Ward et al. 1988, Ward and Heckbert 1992), for diffuse surfaces.

use super::{Hessian, Record, Zone};
use crate::color::luminance;
use crate::frame::Frame;
use crate::hemisphere::Incident;
use crate::scene::Rgb;
use core::f32::consts::{PI, TAU};
use glam::{Vec2, Vec3A};

/// Irradiance at a point and how it changes, W·m⁻² and W·m⁻² per unit of length or radian.
#[derive(Clone, Copy, Debug)]
pub struct IrradianceRecord {
    zone: Zone,
    /// E.
    pub irradiance: Rgb,
    /// ∇ₜE, per channel, world space.
    pub translation: [Vec3A; 3],
    /// ∇ᵣE, per channel: E changes by (n × n′)·∇ᵣE.
    pub rotation: [Vec3A; 3],
}

/// A stratified hemisphere: `rings` of equal projected solid angle × `sectors` of equal azimuth.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Strata {
    /// M, elevations.
    pub rings: u32,
    /// N, azimuths.
    pub sectors: u32,
}

impl Strata {
    /// About `count` strata, about as wide as high: N ≈ πM.
    pub fn about(count: u32) -> Self {
        let rings = ((count as f32 / PI).sqrt().round() as u32).max(2);
        Self { rings, sectors: (count / rings).max(4) }
    }

    fn count(self) -> usize {
        (self.rings * self.sectors) as usize
    }
}

/// A record and the mean distance that its radius follows from.
#[derive(Clone, Copy, Debug)]
pub struct Gathered {
    /// The record, its radius still zero.
    pub record: IrradianceRecord,
    /// Harmonic mean distance of what the rays met; infinite where nothing.
    pub harmonic_mean: f32,
    /// Smallest distance.
    pub nearest: f32,
    /// Second derivatives of the luminance of the irradiance in the tangent plane.
    pub hessian: Hessian,
}

impl IrradianceRecord {
    /// Gathers at `position`: `point` gives the place of a sample in its stratum from the sample's number, `incident` the
    /// light from a world direction.
    pub fn gather(
        position: Vec3A,
        frame: &Frame,
        strata: Strata,
        mut point: impl FnMut(u32) -> Vec2,
        mut incident: impl FnMut(Vec3A, u32) -> Incident,
    ) -> Gathered {
        let Strata { rings, sectors } = strata;
        let mut light = Vec::with_capacity(strata.count());
        let mut inverse_sum = 0.0;
        let mut nearest = f32::INFINITY;
        let (mut irradiance, mut rotation) = (Rgb::ZERO, [Vec3A::ZERO; 3]);
        let share = PI / strata.count() as f32;
        let mut hessian = Hessian::default();
        for j in 0..rings {
            for k in 0..sectors {
                let number = j * sectors + k;
                let u = point(number);
                // sin²θ uniform: density cosθ/π.
                let sin2 = (j as f32 + u.x) / rings as f32;
                let (sin, cos) = (sin2.sqrt(), (1.0 - sin2).max(0.0).sqrt());
                let (s, c) = (TAU * (k as f32 + u.y) / sectors as f32).sin_cos();
                let direction = Vec3A::new(sin * c, sin * s, cos);
                let found = incident(frame.to_world(direction), number);
                let radiance = if found.radiance.is_finite() { found.radiance.max(Rgb::ZERO) } else { Rgb::ZERO };
                irradiance += radiance;
                let tan = sin / cos.max(1e-3);
                for (channel, gradient) in rotation.iter_mut().enumerate() {
                    *gradient += Vec3A::new(-s, c, 0.0) * (tan * radiance[channel]);
                }
                let distance = found.distance.max(f32::MIN_POSITIVE);
                hessian.add(share * luminance(radiance), direction, distance, frame.to_local(found.normal));
                inverse_sum += 1.0 / distance;
                nearest = nearest.min(distance);
                light.push((radiance, distance));
            }
        }
        let record = Self {
            zone: Zone::at(position, frame, Zone::ANY),
            irradiance: irradiance * share,
            translation: translation_gradient(&light, strata).map(|g| frame.to_world(g)),
            rotation: rotation.map(|g| frame.to_world(g * share)),
        };
        Gathered { record, harmonic_mean: strata.count() as f32 / inverse_sum, nearest, hessian }
    }

    /// E at another point and normal, to first order, never negative.
    #[inline]
    pub fn at(&self, position: Vec3A, normal: Vec3A) -> Rgb {
        let (moved, turned) = (position - self.zone.position, self.zone.normal.cross(normal));
        let channel = |c: usize| self.irradiance[c] + moved.dot(self.translation[c]) + turned.dot(self.rotation[c]);
        Rgb::new(channel(0), channel(1), channel(2)).max(Rgb::ZERO)
    }

    /// All that the record holds, for a file.
    pub fn to_numbers(&self) -> [f32; 28] {
        let vectors = [self.zone.position, self.zone.normal, self.irradiance].into_iter();
        let mut numbers = vectors.chain(self.translation).chain(self.rotation).flat_map(|v| v.to_array());
        core::array::from_fn(|i| if i == 27 { self.zone.radius } else { numbers.next().unwrap_or(0.0) })
    }

    /// Inverse of [`IrradianceRecord::to_numbers`].
    pub fn from_numbers(numbers: [f32; 28]) -> Self {
        let v = |i: usize| Vec3A::from_slice(&numbers[3 * i..3 * i + 3]);
        Self {
            zone: Zone { position: v(0), normal: v(1), radius: numbers[27], material: Zone::ANY },
            irradiance: v(2),
            translation: [v(3), v(4), v(5)],
            rotation: [v(6), v(7), v(8)],
        }
    }

    /// Distance over which the light changes by as much as there is: no radius should be larger.
    pub fn gradient_limit(&self) -> f32 {
        let of = |c: usize| self.irradiance[c] / self.translation[c].length().max(f32::MIN_POSITIVE);
        of(0).min(of(1)).min(of(2))
    }

    /// Bounds the translational gradient, so that E stays within a factor over `radius`: noise of nearby walls passes for
    /// gradients otherwise.
    pub fn limit_gradient(&mut self, radius: f32) {
        for c in 0..3 {
            let largest = self.irradiance[c] / radius.max(f32::MIN_POSITIVE);
            self.translation[c] = self.translation[c].clamp_length_max(largest);
        }
    }
}

/// ∇ₜE, local frame (Ward and Heckbert 1992, eq. 2.5): neighbouring strata change places as the point moves, at a rate that
/// the nearer of the two sets.
fn translation_gradient(light: &[(Rgb, f32)], Strata { rings, sectors }: Strata) -> [Vec3A; 3] {
    let at = |j: u32, k: u32| light[(j * sectors + k) as usize];
    let mut gradient = [Vec3A::ZERO; 3];
    let mut add = |direction: Vec3A, difference: Rgb| {
        gradient.iter_mut().enumerate().for_each(|(c, g)| *g += direction * difference[c]);
    };
    // Lower edge of ring j.
    let sin = |j: u32| (j as f32 / rings as f32).sqrt();
    for k in 0..sectors {
        let middle = TAU * (k as f32 + 0.5) / sectors as f32;
        let edge = TAU * k as f32 / sectors as f32;
        let across = Vec3A::new(middle.cos(), middle.sin(), 0.0);
        let along = Vec3A::new(-edge.sin(), edge.cos(), 0.0);
        let before = (k + sectors - 1) % sectors;
        for j in 0..rings {
            let (radiance, distance) = at(j, k);
            if j > 0 {
                let (inner, inner_distance) = at(j - 1, k);
                let (s, cos2) = (sin(j), 1.0 - j as f32 / rings as f32);
                let rate = TAU / sectors as f32 * s * cos2 / distance.min(inner_distance);
                add(across, (radiance - inner) * rate);
            }
            let (left, left_distance) = at(j, before);
            let rate = (sin(j + 1) - sin(j)) / distance.min(left_distance);
            add(along, (radiance - left) * rate);
        }
    }
    gradient
}

impl Record for IrradianceRecord {
    fn zone(&self) -> &Zone {
        &self.zone
    }
    fn zone_mut(&mut self) -> &mut Zone {
        &mut self.zone
    }
    fn bytes(&self) -> usize {
        size_of::<Self>()
    }
    fn is_finite(&self) -> bool {
        self.zone.is_finite()
            && [self.irradiance].iter().chain(&self.translation).chain(&self.rotation).all(|v| v.is_finite())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A floor under a disk lamp of radius 1 at height 2 about (0, 0, 2), no occlusion: E by closed form is smooth; the
    /// gradients agree with finite differences of gathers.
    #[test]
    fn gradients_agree_with_finite_differences() {
        let strata = Strata { rings: 160, sectors: 500 };
        let gather = |p: Vec3A, n: Vec3A| {
            let frame = Frame::from_normal(n);
            IrradianceRecord::gather(
                p,
                &frame,
                strata,
                |_| Vec2::splat(0.5),
                |d, _| {
                    // A smooth wall of light at height 2.
                    let t = if d.z > 1e-3 { (2.0 - p.z) / d.z } else { 1e6 };
                    let q = p + d * t;
                    let glow = (-0.3 * (q.x * q.x + q.y * q.y)).exp();
                    Incident { radiance: Rgb::new(1.0, 0.5, 0.2) * glow, distance: t, normal: -Vec3A::Z }
                },
            )
            .record
        };
        let (p, n) = (Vec3A::new(0.7, -0.4, 0.0), Vec3A::Z);
        let record = gather(p, n);
        for axis in [Vec3A::X, Vec3A::Y] {
            let h = 0.05;
            let slope = (gather(p + axis * h, n).irradiance - gather(p - axis * h, n).irradiance) / (2.0 * h);
            let found = record.translation[0].dot(axis);
            assert!((found - slope.x).abs() < 0.02 * record.irradiance.x, "{axis}: {found} {slope}");
            let tilt = |h: f32| (n + axis * h).normalize();
            let slope = (gather(p, tilt(h)).irradiance - gather(p, tilt(-h)).irradiance) / (2.0 * h);
            let found = n.cross(axis).dot(record.rotation[0]);
            assert!((found - slope.x).abs() < 0.02 * record.irradiance.x, "turn {axis}: {found} {slope}");
        }
    }

    #[test]
    fn constant_light_has_no_gradient() {
        let frame = Frame::from_normal(Vec3A::Y);
        let light = Incident { radiance: Rgb::splat(2.0), distance: 3.0, normal: Vec3A::ZERO };
        let found =
            IrradianceRecord::gather(Vec3A::ZERO, &frame, Strata::about(500), |_| Vec2::splat(0.5), |_, _| light);
        assert!((found.record.irradiance / (2.0 * PI) - 1.0).abs().max_element() < 1e-4);
        assert!((found.harmonic_mean - 3.0).abs() < 1e-3 && found.nearest == 3.0);
        assert!(found.record.translation.iter().chain(&found.record.rotation).all(|g| g.length() < 1e-3));
    }
}
