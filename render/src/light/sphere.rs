//! A sphere that emits.

use crate::frame::{Frame, uniform_sphere};
use crate::math::sin_cos_turn;
use crate::scene::Sphere;
use core::f32::consts::{PI, TAU};
use glam::{Vec2, Vec3A};

/// Points nearer to the surface than this, in the largest coordinate of the sphere, count as lying on it: twice the step
/// by which rays leave a surface, so that no point of the sphere itself passes for one outside.
const SKIN: f32 = 2.0 / (1 << 20) as f32;

/// A sphere that emits to its front.
#[derive(Clone, Copy, Debug)]
pub(super) struct SphereLamp {
    pub sphere: Sphere,
    /// Square of the least distance from the centre at which a point is outside.
    outside2: f32,
    area: f32,
}

/// A sampled point of the sphere.
pub(super) struct SphereSample {
    /// Unit direction to it.
    pub wi: Vec3A,
    /// Unit direction from the centre to it.
    pub outward: Vec3A,
    /// Density in sr⁻¹.
    pub pdf: f32,
}

impl SphereLamp {
    pub fn new(sphere: Sphere) -> Self {
        let Sphere { center, radius, .. } = sphere;
        let outside = radius + SKIN * (center.abs().max_element() + radius);
        Self { sphere, outside2: outside * outside, area: 4.0 * PI * radius * radius }
    }

    pub fn area(&self) -> f32 {
        self.area
    }

    /// Square of the sine of the half angle under which the sphere is seen at a squared distance from its centre; `None`
    /// on its surface and inside, from where its outer side cannot be seen.
    #[inline]
    fn sin2(&self, distance2: f32) -> Option<f32> {
        (distance2 > self.outside2).then(|| self.sphere.radius * self.sphere.radius / distance2)
    }

    /// Facing outwards: uniformly over the cone of directions that meet the sphere. Inwards: uniformly over the area.
    #[inline]
    pub fn sample(&self, p: Vec3A, u: Vec2) -> Option<SphereSample> {
        let Sphere { center, radius, inward, .. } = self.sphere;
        let to_center = center - p;
        if inward {
            let outward = uniform_sphere(u);
            let to_light = to_center + outward * radius;
            let distance = to_light.length();
            let wi = to_light / distance;
            let pdf = self.pdf(p, distance, outward.dot(wi));
            return (distance > 0.0).then_some(SphereSample { wi, outward, pdf });
        }
        let distance2 = to_center.length_squared();
        let sin2_max = self.sin2(distance2)?;
        let distance = distance2.sqrt();
        // The angle at p from 1 − its cosine, then the angle at the centre: neither cancels, however far or near p is.
        let one_minus = u.x * one_minus_cos(sin2_max);
        let cos = 1.0 - one_minus;
        let sin2 = one_minus * (2.0 - one_minus);
        let (sin, cos_exit) = (sin2.sqrt(), (1.0 - sin2 / sin2_max).max(0.0).sqrt());
        let to_surface = (distance - radius) * (distance + radius) / (distance * cos + radius * cos_exit);
        let (sin_alpha, cos_alpha) = (to_surface * sin / radius, sin2 / sin2_max.sqrt() + cos * cos_exit);
        let (sin_phi, cos_phi) = sin_cos_turn(u.y);
        let frame = Frame::from_normal(to_center / -distance);
        Some(SphereSample {
            wi: frame.to_world(Vec3A::new(sin * cos_phi, sin * sin_phi, -cos)),
            outward: frame.to_world(Vec3A::new(sin_alpha * cos_phi, sin_alpha * sin_phi, cos_alpha)),
            pdf: 1.0 / (TAU * one_minus_cos(sin2_max)),
        })
    }

    /// Density in sr⁻¹ of [`SphereLamp::sample`] at a point at `distance` whose normal makes the cosine `cos` > 0 with the
    /// direction back to `p`.
    #[inline]
    pub fn pdf(&self, p: Vec3A, distance: f32, cos: f32) -> f32 {
        if self.sphere.inward {
            return if cos > 0.0 { distance * distance / (cos * self.area) } else { 0.0 };
        }
        let sin2_max = self.sin2((self.sphere.center - p).length_squared());
        sin2_max.map_or(0.0, |sin2| 1.0 / (TAU * one_minus_cos(sin2)))
    }
}

/// 1 − cos θ from sin² θ, θ ≤ π/2, without cancellation.
fn one_minus_cos(sin2: f32) -> f32 {
    sin2 / (1.0 + (1.0 - sin2).max(0.0).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Mat3A;

    /// Directions meet the sphere where they say, from a point just outside to one so far away that the sine squared of the
    /// half angle has no digits beside 1.
    #[test]
    fn samples_lie_on_the_sphere_at_every_distance() {
        for radius in [1e-3f32, 1.0, 1e3] {
            let center = Vec3A::new(3.0, -2.0, 1.0) * radius;
            let lamp = SphereLamp::new(Sphere { center, radius, rotation: Mat3A::IDENTITY, inward: false });
            for height in [1e-4f32, 1e-2, 1.0, 1e2, 1e4, 1e6] {
                let away = Vec3A::new(0.48, 0.6, -0.64);
                let p = center + away * (radius * (1.0 + height));
                let mut solid_angle = 0.0;
                for i in 0..64 {
                    let u = Vec2::new((i as f32 + 0.5) / 64.0, (i as f32 * 0.618).fract());
                    let s = lamp.sample(p, u).unwrap();
                    assert!((s.outward.length() - 1.0).abs() < 1e-4 && (s.wi.length() - 1.0).abs() < 1e-5);
                    // The rounding of p and of the point itself, as an angle.
                    let rounding = 4e-7 * p.abs().max_element().max(center.abs().max_element()) / (radius * height);
                    let geometric = (center + s.outward * radius - p).normalize();
                    assert!((geometric - s.wi).length() < 1e-3 + rounding, "{radius} {height}: {geometric} {}", s.wi);
                    assert!(s.outward.dot(s.wi) < 1e-3);
                    assert_eq!(s.pdf, lamp.pdf(p, 1.0, 1.0));
                    solid_angle = 1.0 / f64::from(s.pdf);
                }
                let d = 1.0 + f64::from(height);
                let exact = core::f64::consts::TAU / (d * d) / (1.0 + (1.0 - 1.0 / (d * d)).sqrt());
                assert!((solid_angle / exact - 1.0).abs() < 1e-2, "{radius} {height}: {solid_angle} {exact}");
            }
        }
    }

    #[test]
    fn nothing_is_sampled_from_the_surface_or_inside() {
        for center in [Vec3A::ZERO, Vec3A::new(900.0, -70.0, 5.0)] {
            let lamp = SphereLamp::new(Sphere { center, radius: 1.5, rotation: Mat3A::IDENTITY, inward: false });
            for i in 0..1000 {
                let outward = uniform_sphere(Vec2::new((i as f32 + 0.5) / 1000.0, (i as f32 * 0.618).fract()));
                let p = center + outward * 1.5;
                assert!(lamp.sample(p, Vec2::splat(0.3)).is_none() && lamp.pdf(p, 1.0, 1.0) == 0.0);
            }
        }
    }

    /// What faces the centre is not seen from outside.
    #[test]
    fn the_back_of_an_inward_sphere_has_no_density() {
        let lamp =
            SphereLamp::new(Sphere { center: Vec3A::ZERO, radius: 1.0, rotation: Mat3A::IDENTITY, inward: true });
        let s = lamp.sample(Vec3A::X * 3.0, Vec2::new(0.5, 0.0)).unwrap();
        assert!(s.outward.x > 0.99 && s.pdf == 0.0);
        assert!(lamp.sample(Vec3A::ZERO, Vec2::splat(0.2)).unwrap().pdf > 0.0);
    }
}
