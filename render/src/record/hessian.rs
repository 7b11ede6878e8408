//! How fast the light of a point bends: the second derivatives that an extrapolation by gradients leaves out.
//!
//! Every sample of a hemisphere stands for a patch that stays where it is (the geometric Hessian of Schwarzhaupt, Jensen and
//! Jarosz 2012, "Practical Hessian-based error control for irradiance caching"): what a patch at distance d, seen along ω and
//! facing the point under the cosine cosα, gives to the irradiance at a displacement δ in the tangent plane is
//!
//!   w (1 + n·δ/(d cosα)) (1 − 2 ω·δ/d + δ²/d²)⁻²
//!
//! of what it gives at the point, n being its normal.

use glam::Vec3A;

/// Second derivatives of irradiance (or radiance) in the tangent plane, per unit of length squared.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Hessian {
    /// ∂²/∂x².
    pub xx: f32,
    /// ∂²/∂x∂y.
    pub xy: f32,
    /// ∂²/∂y².
    pub yy: f32,
}

/// A patch is taken to face the point at least this much: one seen edge on would bend the light without bound.
const MIN_COS: f32 = 0.1;

impl Hessian {
    /// Adds a sample of irradiance `light` from the unit `direction` and `distance`, which ends on a patch of unit `normal`;
    /// both in the local frame of the point. Light from infinity does not change.
    pub fn add(&mut self, light: f32, direction: Vec3A, distance: f32, normal: Vec3A) {
        let scale = light / (distance * distance);
        if !scale.is_finite() || scale <= 0.0 {
            return;
        }
        let slope = normal / (-normal.dot(direction)).max(MIN_COS);
        let (w, m) = (direction, slope);
        self.xx += scale * (24.0 * w.x * w.x - 4.0 + 8.0 * w.x * m.x);
        self.xy += scale * (24.0 * w.x * w.y + 4.0 * (w.x * m.y + w.y * m.x));
        self.yy += scale * (24.0 * w.y * w.y - 4.0 + 8.0 * w.y * m.y);
    }

    /// Of a function of the displacement, by central differences of step `h`.
    pub fn of(h: f32, mut f: impl FnMut(f32, f32) -> f32) -> Self {
        let (middle, over_h2) = (f(0.0, 0.0), 1.0 / (h * h));
        Self {
            xx: (f(h, 0.0) + f(-h, 0.0) - 2.0 * middle) * over_h2,
            xy: (f(h, h) + f(-h, -h) - f(h, -h) - f(-h, h)) * (0.25 * over_h2),
            yy: (f(0.0, h) + f(0.0, -h) - 2.0 * middle) * over_h2,
        }
    }

    /// Largest absolute eigenvalue.
    pub fn largest(&self) -> f32 {
        let (mean, half) = (0.5 * (self.xx + self.yy), 0.5 * (self.xx - self.yy));
        mean.abs() + half.hypot(self.xy)
    }

    /// Radius of the disk over which the second-order term, λδ²/2 at most, is `tolerance` of `value` in the mean; infinite
    /// where nothing bends.
    pub fn radius(&self, value: f32, tolerance: f32) -> f32 {
        let ratio = tolerance * value / self.largest();
        if ratio.is_nan() { f32::INFINITY } else { 2.0 * ratio.max(0.0).sqrt() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::Frame;
    use crate::hemisphere::{Incident, gather_uniform};
    use crate::scene::Rgb;
    use glam::Vec2;

    /// A ceiling at height 1 whose radiance is a bell about (0.4, 0.2).
    fn ceiling(from: Vec3A, direction: Vec3A) -> Incident {
        let distance = (1.0 - from.z) / direction.z.max(1e-6);
        let at = from + direction * distance - Vec3A::new(0.4, 0.2, 1.0);
        let radiance = (-at.length_squared() * 2.0).exp();
        Incident { radiance: Rgb::splat(radiance), distance, normal: Vec3A::NEG_Z }
    }

    fn samples(from: Vec3A) -> Vec<crate::hemisphere::GatherSample> {
        gather_uniform(&Frame::from_normal(Vec3A::Z), 40_000, |_| Vec2::splat(0.5), |d, _| ceiling(from, d))
    }

    #[test]
    fn second_derivatives_are_those_of_finite_differences() {
        let e = |x: f32, y: f32| samples(Vec3A::new(x, y, 0.0)).iter().map(|s| s.irradiance().x).sum::<f32>();
        let numeric = Hessian::of(0.1, e);
        let frame = Frame::from_normal(Vec3A::Z);
        let mut analytic = Hessian::default();
        for s in samples(Vec3A::ZERO) {
            let world = frame.to_world(s.direction);
            analytic.add(s.irradiance().x, world, 1.0 / s.inv_distance, s.normal);
        }
        let scale = numeric.largest();
        for (a, b) in [(analytic.xx, numeric.xx), (analytic.xy, numeric.xy), (analytic.yy, numeric.yy)] {
            assert!((a - b).abs() < 0.03 * scale, "{analytic:?} {numeric:?}");
        }
    }

    #[test]
    fn radii_follow_curvature() {
        let bent = Hessian { xx: 4.0, xy: 0.0, yy: -1.0 };
        assert_eq!(bent.largest(), 4.0);
        assert_eq!(bent.radius(1.0, 0.01), 0.1);
        assert_eq!(Hessian::default().radius(0.0, 0.01), f32::INFINITY);
        let mut far = Hessian::default();
        far.add(1.0, Vec3A::Z, f32::INFINITY, Vec3A::ZERO);
        assert_eq!(far, Hessian::default());
    }
}
