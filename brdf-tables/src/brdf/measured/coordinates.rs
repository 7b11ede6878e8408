//! Half and difference angles, and the unit coordinates of the lattice.

use crate::real::Real;
use core::f64::consts::{FRAC_2_PI, FRAC_PI_2};
use glam::DVec3;

/// (√(2θh/π), 2θd/π, 2φd/π), each in [0, 1]: θh is that of the half vector, θd the angle between it and either direction, φd
/// the azimuth of their difference about it, folded into a quarter turn. All are the same when `wi` and `wo` change places,
/// when both turn about the normal, and when both are mirrored about a plane that holds it.
///
/// The square root, as in the files of MERL, puts the nodes where highlights are.
#[inline(always)]
pub fn unit<T: Real>(wi: [T; 3], wo: [T; 3]) -> [T; 3] {
    let (zero, one, tiny) = (wi[0].lit(0.0), wi[0].lit(1.0), wi[0].lit(1e-30));
    let (half, two) = (one.lit(0.5), one.lit(2.0));
    let sum = [wi[0] + wo[0], wi[1] + wo[1], wi[2] + wo[2]];
    let difference = [wi[0] - wo[0], wi[1] - wo[1], wi[2] - wo[2]];
    let across2 = sum[0].sq() + sum[1].sq();
    let sum2 = (across2 + sum[2].sq()).max(tiny);
    let (length, inverse) = (sum2.sqrt(), sum2.recip());
    let (sin2_h, cos_h) = ((across2 * inverse).min(one), (sum[2] * inverse * length).clamp(zero, one));
    // sin²(θh/2) = sin²θh / (2 (1 + cosθh)) keeps the digits that 1 − cosθh loses near the normal.
    let theta_h = (sin2_h * (cos_h + cos_h + two).recip()).min(half).angle_of_half() * one.lit(FRAC_2_PI);
    let cos_d = (length * half).min(one);
    let theta_d = arc_cosine(cos_d) * one.lit(FRAC_2_PI);
    // The difference is 2 sinθd t with t ⊥ h, and t.z = −sinθh cosφd.
    let squared = difference[0].sq() + difference[1].sq() + difference[2].sq();
    let scale = (squared * sin2_h).max(tiny).sqrt().recip();
    let phi_d = arc_cosine((difference[2].abs() * scale).min(one)) * one.lit(FRAC_2_PI);
    [theta_h.min(one).sqrt(), theta_d.clamp(zero, one), phi_d.clamp(zero, one)]
}

/// Of a number in [0, 1].
#[inline(always)]
fn arc_cosine<T: Real>(x: T) -> T {
    ((x.lit(1.0) - x) * x.lit(0.5)).angle_of_half()
}

/// θh, θd ∈ [0, π/2] and φd ∈ [0, π/2] of two directions, radian.
pub fn angles(wi: DVec3, wo: DVec3) -> [f64; 3] {
    let [h, d, p] = unit(wi.to_array(), wo.to_array());
    [h * h * FRAC_PI_2, d * FRAC_PI_2, p * FRAC_PI_2]
}

/// Two directions with these half and difference angles, the half vector in the plane y = 0. Either may lie below the horizon.
pub fn directions([theta_h, theta_d, phi_d]: [f64; 3]) -> (DVec3, DVec3) {
    let ((sh, ch), (sd, cd), (sp, cp)) = (theta_h.sin_cos(), theta_d.sin_cos(), phi_d.sin_cos());
    let half = DVec3::new(sh, 0.0, ch);
    let across = DVec3::new(ch * cp, sp, -sh * cp);
    (cd * half + sd * across, cd * half - sd * across)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::spherical;

    /// Angles and directions are inverse, and do not change with what the material does not tell apart.
    #[test]
    fn angles_are_inverse_and_symmetric() {
        for (h, d, p) in [(0.01, 0.4, 0.3), (0.5, 0.7, 1.2), (1.0, 0.2, 0.01), (0.3, 1.2, 1.5)] {
            let (wi, wo) = directions([h, d, p]);
            let found = angles(wi, wo);
            for (a, b) in [h, d, p].into_iter().zip(found) {
                assert!((a - b).abs() < 1e-7, "{h} {d} {p}: {found:?}");
            }
            assert_eq!(angles(wo, wi), found);
            let flip = |w: DVec3| DVec3::new(w.y, w.x, w.z);
            assert!(angles(flip(wi), flip(wo)).iter().zip(found).all(|(a, b)| (a - b).abs() < 1e-7));
        }
        // Mirror directions, and both along the normal.
        let [h, d, _] = angles(spherical(0.6, 0.0), spherical(0.6, core::f64::consts::PI));
        assert!(h < 1e-7 && (d - 0.6).abs() < 1e-7, "{h} {d}");
        assert!(angles(DVec3::Z, DVec3::Z)[1] < 1e-7);
    }

    /// Single precision follows double.
    #[test]
    fn single_precision_agrees() {
        for i in 0..500 {
            let x = f64::from(i) / 500.0;
            let (wi, wo) = (spherical(1.5 * x, 40.0 * x), spherical(1.4 * (0.2 + 0.8 * x), 2.0));
            let narrow = unit(wi.as_vec3().to_array(), wo.as_vec3().to_array());
            let wide = unit(wi.as_vec3().as_dvec3().to_array(), wo.as_vec3().as_dvec3().to_array());
            for (a, b) in narrow.into_iter().zip(wide) {
                assert!((f64::from(a) - b).abs() < 1e-3, "{i}: {narrow:?} {wide:?}");
            }
        }
    }
}
