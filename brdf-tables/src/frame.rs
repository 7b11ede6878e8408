//! The local shading frame (z = normal) and the spherical helpers every part agrees on.

use glam::{DMat3, DVec3};

/// Unit vector of zenith angle `theta` and azimuth `phi` (radian).
#[inline]
pub fn spherical(theta: f64, phi: f64) -> DVec3 {
    let (st, ct) = theta.sin_cos();
    let (sp, cp) = phi.sin_cos();
    DVec3::new(st * cp, st * sp, ct)
}

/// Mirror of `v` about the surface normal: the perfect specular direction for light from `v`.
#[inline]
pub fn mirror(v: DVec3) -> DVec3 {
    DVec3::new(-v.x, -v.y, v.z)
}

/// Rotation whose third column is the unit vector `axis` (Duff et al. 2017: no branch but the sign, no singular pole).
#[inline]
pub fn basis(axis: DVec3) -> DMat3 {
    let s = 1f64.copysign(axis.z);
    let a = -1.0 / (s + axis.z);
    let b = axis.x * axis.y * a;
    DMat3::from_cols(
        DVec3::new(1.0 + s * axis.x * axis.x * a, s * b, -s * axis.x),
        DVec3::new(b, s + axis.y * axis.y * a, -axis.y),
        axis,
    )
}
