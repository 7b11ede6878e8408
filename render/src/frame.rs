//! Local frames and maps from the unit square.

use crate::math::{sin_cos_octant, sin_cos_turn};
use core::f32::consts::FRAC_PI_4;
use glam::{Mat3A, Vec2, Vec3A};

/// An orthonormal frame; z is the normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    axes: Mat3A,
}

impl Frame {
    /// Any frame about a unit normal (Duff et al. 2017, "Building an orthonormal basis, revisited").
    #[inline]
    pub fn from_normal(n: Vec3A) -> Self {
        let s = 1f32.copysign(n.z);
        let a = -1.0 / (s + n.z);
        let b = n.x * n.y * a;
        let x = Vec3A::new(1.0 + s * n.x * n.x * a, s * b, -s * n.x);
        let y = Vec3A::new(b, s + n.y * n.y * a, -n.y);
        Self { axes: Mat3A::from_cols(x, y, n) }
    }

    /// The frame about a unit normal whose x axis lies as near as possible to `tangent`; any, if that is parallel.
    #[inline]
    pub fn with_tangent(n: Vec3A, tangent: Vec3A) -> Self {
        match (tangent - n * n.dot(tangent)).try_normalize() {
            Some(x) => Self { axes: Mat3A::from_cols(x, n.cross(x), n) },
            None => Self::from_normal(n),
        }
    }

    /// The frame of these orthonormal axes; z is the normal. They are not checked.
    #[inline]
    pub fn from_axes(x: Vec3A, y: Vec3A, z: Vec3A) -> Self {
        Self { axes: Mat3A::from_cols(x, y, z) }
    }

    /// The axes x, y and z.
    pub fn axes(&self) -> [Vec3A; 3] {
        [self.axes.x_axis, self.axes.y_axis, self.axes.z_axis]
    }

    /// The normal.
    #[inline]
    pub fn normal(&self) -> Vec3A {
        self.axes.z_axis
    }

    /// The frame seen from the other side: y and z turned about x.
    #[inline]
    pub fn flipped(&self) -> Self {
        Self { axes: Mat3A::from_cols(self.axes.x_axis, -self.axes.y_axis, -self.axes.z_axis) }
    }

    /// Local to world.
    #[inline]
    pub fn to_world(&self, v: Vec3A) -> Vec3A {
        self.axes * v
    }

    /// World to local.
    #[inline]
    pub fn to_local(&self, v: Vec3A) -> Vec3A {
        Vec3A::new(self.axes.x_axis.dot(v), self.axes.y_axis.dot(v), self.axes.z_axis.dot(v))
    }
}

/// Point of the unit disk, uniform (Shirley and Chiu 1997).
#[inline]
pub fn concentric_disk(u: Vec2) -> Vec2 {
    let p = 2.0 * u - 1.0;
    let wide = p.x.abs() > p.y.abs();
    let (r, other) = if wide { (p.x, p.y) } else { (p.y, p.x) };
    if r == 0.0 {
        return Vec2::ZERO;
    }
    let (s, c) = sin_cos_octant(FRAC_PI_4 * (other / r));
    r * if wide { Vec2::new(c, s) } else { Vec2::new(s, c) }
}

/// Direction about z with density cosθ/π.
#[inline]
pub fn cosine_hemisphere(u: Vec2) -> Vec3A {
    let p = concentric_disk(u);
    Vec3A::new(p.x, p.y, (1.0 - p.length_squared()).max(0.0).sqrt())
}

/// Direction with density 1/4π.
#[inline]
pub fn uniform_sphere(u: Vec2) -> Vec3A {
    let z = 1.0 - 2.0 * u.x;
    let r = (1.0 - z * z).max(0.0).sqrt();
    let (s, c) = sin_cos_turn(u.y);
    Vec3A::new(r * c, r * s, z)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn disk() {
        // the first and second moments of the disk, by the midpoint rule
        let n = 200;
        let points = (0..n * n).map(|i| Vec2::new((i % n) as f32 + 0.5, (i / n) as f32 + 0.5) / n as f32);
        let (mut sum, mut xx, mut yy) = (Vec2::ZERO, 0.0, 0.0);
        for p in points.map(concentric_disk) {
            assert!(p.length() <= 1.0);
            (sum, xx, yy) = (sum + p, xx + f64::from(p.x * p.x), yy + f64::from(p.y * p.y));
        }
        let count = f64::from(n * n);
        assert!(sum.length() / (count as f32) < 1e-5);
        assert!((xx / count - 0.25).abs() < 1e-3 && (yy / count - 0.25).abs() < 1e-3);
    }
}
