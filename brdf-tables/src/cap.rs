//! Spherical caps: half angle ↔ solid angle, uniform sampling, and the irradiance of a cap cut by the horizon.

use crate::frame::{basis, spherical};
use crate::real::Real;
use core::f64::consts::{FRAC_PI_2, PI, TAU};
use glam::{DVec2, DVec3};

/// A spherical cap: unit axis (zenith angle 0 … π/2) and solid angle Ω = 2π(1 − cos σ) of the whole cap, σ ∈ (0, π/2].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cap {
    axis: DVec3,
    solid_angle: f64,
}

/// Why a cap lies outside the domain of the mean BRDF.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CapError {
    /// The zenith angle is not in [0, π/2].
    #[error("theta_e = {0} rad is outside [0, pi/2]")]
    Zenith(f64),
    /// The azimuth is not finite.
    #[error("phi_e = {0} rad is not a finite number")]
    Azimuth(f64),
    /// The axis is not a unit vector.
    #[error("axis {0} is not a unit vector")]
    Axis(DVec3),
    /// The axis points below the horizon.
    #[error("axis {0} points below the horizon")]
    Below(DVec3),
    /// The solid angle is not in (0, 2π].
    #[error("omega = {0} sr is outside (0, 2 pi]")]
    SolidAngle(f64),
}

impl Cap {
    /// The cap around (θe, φe) with solid angle Ω (radian, sr).
    pub fn new(theta: f64, phi: f64, solid_angle: f64) -> Result<Self, CapError> {
        if !(0.0..=FRAC_PI_2 * (1.0 + 1e-12)).contains(&theta) {
            return Err(CapError::Zenith(theta));
        }
        if !phi.is_finite() {
            return Err(CapError::Azimuth(phi));
        }
        check_solid_angle(solid_angle)?;
        let mut axis = spherical(theta, phi);
        axis.z = axis.z.max(0.0);
        Ok(Self { axis, solid_angle: solid_angle.min(TAU) })
    }

    /// The cap around a unit vector of the upper hemisphere (z ≥ 0) with solid angle Ω (sr).
    ///
    /// # Errors
    /// The axis is not of length 1 (to [`UNIT`]), points below the horizon, or Ω is not in (0, 2π].
    pub fn from_axis(axis: DVec3, solid_angle: f64) -> Result<Self, CapError> {
        check_axis(axis)?;
        check_solid_angle(solid_angle)?;
        Ok(Self::around(axis, solid_angle))
    }

    /// The cap around (θe, φe) with half angle σ (radian).
    pub fn with_half_angle(theta: f64, phi: f64, sigma: f64) -> Result<Self, CapError> {
        Self::new(theta, phi, 2.0 * TAU * (0.5 * sigma).sin().powi(2))
    }

    /// The cap around a unit vector that is known to lie in the upper hemisphere, Ω in (0, 2π].
    pub(crate) fn around(axis: DVec3, solid_angle: f64) -> Self {
        Self { axis: axis.normalize(), solid_angle: solid_angle.min(TAU) }
    }

    /// Unit axis.
    pub fn axis(&self) -> DVec3 {
        self.axis
    }

    /// Solid angle Ω of the whole cap, sr.
    pub fn solid_angle(&self) -> f64 {
        self.solid_angle
    }

    /// 1 − cos σ = Ω/2π, exact for the smallest caps.
    pub fn height(&self) -> f64 {
        self.solid_angle / TAU
    }

    /// Half angle σ, radian.
    pub fn half_angle(&self) -> f64 {
        2.0 * (0.5 * self.height()).sqrt().min(1.0).asin()
    }

    /// Zenith angle θe of the axis, radian.
    pub fn theta(&self) -> f64 {
        self.axis.truncate().length().atan2(self.axis.z)
    }

    /// Azimuth φe of the axis, radian.
    pub fn phi(&self) -> f64 {
        self.axis.y.atan2(self.axis.x)
    }

    /// ∫ cosθ over the part of the cap above the horizon, sr: the denominator of eq. 9.
    pub fn projected_solid_angle(&self) -> f64 {
        projected_solid_angle(self.axis.z, self.height())
    }

    /// Uniformly distributed direction of the whole cap; density 1/Ω.
    pub fn sample(&self, u: DVec2) -> DVec3 {
        let h = u.x * self.height();
        let s = (h * (2.0 - h)).max(0.0).sqrt();
        let (sp, cp) = (TAU * u.y).sin_cos();
        basis(self.axis) * DVec3::new(s * cp, s * sp, 1.0 - h)
    }

    /// Whether the unit vector `w` lies in the cap.
    pub fn contains(&self, w: DVec3) -> bool {
        0.5 * (w - self.axis).length_squared() <= self.height()
    }
}

/// How far the length of a unit vector may be from 1: what single precision leaves of one after a few rotations.
pub const UNIT: f64 = 1e-3;

/// Whether a vector may be the axis of a cap.
pub(crate) fn check_axis(axis: DVec3) -> Result<(), CapError> {
    // A comparison with NaN fails.
    let unit = (axis.length_squared() - 1.0).abs() < UNIT;
    if !unit {
        return Err(CapError::Axis(axis));
    }
    if axis.z < 0.0 { Err(CapError::Below(axis)) } else { Ok(()) }
}

/// Whether a number may be the solid angle of a cap; 2π may be rounded up, in either precision.
pub(crate) fn check_solid_angle(solid_angle: f64) -> Result<(), CapError> {
    let fits = solid_angle > 0.0 && solid_angle <= TAU * (1.0 + f64::from(f32::EPSILON));
    if fits { Ok(()) } else { Err(CapError::SolidAngle(solid_angle)) }
}

/// ∫ cosθ dω over a cap of height h = 1 − cos σ around an axis of cosine `cz` ≥ 0, clipped by the horizon, sr.
///
/// Whole cap: π sin²σ cosθe. Clipped, from the boundary integral ½∮(x dy − y dx) of the region projected on the base
/// disk, written so that every term is positive (no cancellation for small or grazing caps): with φ the half width of
/// the cap on the horizon and ψ the rim angle where it meets it,
/// E = (φ − sinφ cosφ) + cos²θe sinφ cosφ + sin²σ cosθe (π − ψ).
#[inline(always)]
pub fn projected_solid_angle<T: Real>(cz: T, height: T) -> T {
    let (zero, one) = (cz.lit(0.0), cz.lit(1.0));
    let sin2_r = height * (cz.lit(2.0) - height);
    let whole = cz.lit(PI) * sin2_r * cz;
    let chord2 = sin2_r - cz * cz;
    if !T::any(zero.lt(chord2)) {
        return whole;
    }
    let sin2_t = (one - cz * cz).max(cz.lit(1e-12));
    let sin_p = (chord2.max(zero) / sin2_t).min(one).sqrt();
    let cos_p = (one - height) / sin2_t.sqrt();
    let phi = sin_p.asin();
    // φ − sinφ cosφ loses its digits for a short chord: two terms of its series there.
    let short = sin_p.sq() * sin_p * (cz.lit(2.0 / 3.0) + sin_p.sq() * (cz.lit(0.2) + sin_p.sq() * cz.lit(3.0 / 28.0)));
    let segment = T::select(sin_p.lt(cz.lit(0.1)), short, phi - sin_p * cos_p);
    let sin_r = sin2_r.max(cz.lit(1e-30)).sqrt();
    let psi = cz.lit(FRAC_PI_2) - ((one - height) * cz / (sin_r * sin2_t.sqrt())).clamp(-one, one).asin();
    let clipped = segment + cz * cz * sin_p * cos_p + sin2_r * cz * (cz.lit(PI) - psi);
    T::select(zero.lt(chord2), clipped, whole)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Midpoint rule over the cap, clipping by testing each node.
    fn brute_force(cap: &Cap) -> f64 {
        let (n, m) = (2000, 2000);
        let mut sum = 0.0;
        for i in 0..n {
            for j in 0..m {
                let u = DVec2::new((i as f64 + 0.5) / n as f64, (j as f64 + 0.5) / m as f64);
                sum += cap.sample(u).z.max(0.0);
            }
        }
        sum * cap.solid_angle() / (n * m) as f64
    }

    #[test]
    fn projected_solid_angle_matches_brute_force() {
        for theta in [0.0, 0.3, 1.0, 1.4, 1.5, FRAC_PI_2] {
            for sigma in [0.02, 0.2, 0.9, FRAC_PI_2] {
                let cap = Cap::with_half_angle(theta, 0.4, sigma).unwrap();
                let (exact, brute) = (cap.projected_solid_angle(), brute_force(&cap));
                assert!((exact - brute).abs() < 2e-6 * brute + 1e-12, "{theta} {sigma}: {exact} {brute}");
                let single = projected_solid_angle(cap.axis().z as f32, cap.height() as f32) as f64;
                assert!((single - exact).abs() < 2e-5 * exact, "{theta} {sigma}: {exact} {single}");
            }
        }
    }

    #[test]
    fn domain_is_enforced() {
        assert_eq!(Cap::new(-0.1, 0.0, 1.0), Err(CapError::Zenith(-0.1)));
        assert_eq!(Cap::new(0.1, 0.0, 0.0), Err(CapError::SolidAngle(0.0)));
        assert!(Cap::new(0.1, f64::NAN, 1.0).is_err());
        assert!(Cap::new(f64::NAN, 0.0, 1.0).is_err());
        assert!(Cap::new(0.1, 0.0, f64::INFINITY).is_err());
        let slanted = DVec3::new(0.6, 0.0, 0.8);
        assert!((Cap::from_axis(slanted, 1.0).unwrap().theta() - 0.8f64.acos()).abs() < 1e-12);
        assert_eq!(Cap::from_axis(2.0 * slanted, 1.0), Err(CapError::Axis(2.0 * slanted)));
        assert_eq!(Cap::from_axis(-slanted, 1.0), Err(CapError::Below(-slanted)));
        assert_eq!(Cap::from_axis(slanted, 7.0), Err(CapError::SolidAngle(7.0)));
        assert!(Cap::from_axis(DVec3::NAN, 1.0).is_err() && Cap::from_axis(slanted, f64::NAN).is_err());
    }

    #[test]
    fn samples_stay_inside() {
        let cap = Cap::with_half_angle(1.2, 2.0, 0.3).unwrap();
        for i in 0..100 {
            let u = DVec2::new(i as f64 / 100.0, (i * 37 % 100) as f64 / 100.0);
            assert!(cap.contains(cap.sample(u)));
        }
        assert!((cap.half_angle() - 0.3).abs() < 1e-12 && (cap.theta() - 1.2).abs() < 1e-12);
    }
}
