//! Local frames and maps from the unit square.

use core::f32::consts::{FRAC_PI_4, TAU};
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
    if p == Vec2::ZERO {
        return p;
    }
    let (r, phi) = if p.x.abs() > p.y.abs() {
        (p.x, FRAC_PI_4 * (p.y / p.x))
    } else {
        (p.y, 2.0 * FRAC_PI_4 - FRAC_PI_4 * (p.x / p.y))
    };
    let (s, c) = phi.sin_cos();
    r * Vec2::new(c, s)
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
    let (s, c) = (TAU * u.y).sin_cos();
    Vec3A::new(r * c, r * s, z)
}
