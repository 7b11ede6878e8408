//! Half and difference angles, and the unit coordinates of the lattice.

use crate::real::Real;
use core::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_2};
use glam::DVec3;

/// Angles nearest to a quarter turn that values are taken at: at the quarter turn itself both directions graze.
const LARGEST: f64 = 0.9995 * FRAC_PI_2;
/// Largest z of the difference of two directions over that of their sum that values are taken at: at 1 one of them grazes.
const STEEPEST: f64 = 0.998;

/// ((1 − cosθh)^¼, (1 − cosθd)^½, t), each in [0, 1]: θh is the angle of the half vector, θd that between it and either
/// direction, and t the square of the z of the difference of the directions over the largest that it has at θh and θd while
/// both are above the horizon. With φd, the azimuth of the difference about the half vector, √t is cosφd where tanθh tanθd ≤ 1,
/// and cosφd tanθh tanθd, the z of the difference over that of the sum, beyond. All are the same when `wi` and `wo` change
/// places, when both turn about the normal, and when both are mirrored about a plane that holds it.
///
/// The first is about the square root of θh, as in the files of MERL, which puts the nodes where highlights are; the second
/// about θd; f_r is even in φd and about a quarter turn, which makes it smooth in t. The horizon is the face t = 1, so that all
/// of the lattice holds values that there are, and what f_r does there follows the lattice. No angle is needed to find them.
#[inline(always)]
pub fn unit<T: Real>(wi: [T; 3], wo: [T; 3]) -> [T; 3] {
    let (zero, one, tiny) = (wi[0].lit(0.0), wi[0].lit(1.0), wi[0].lit(1e-30));
    let (x, y, z) = (wi[0] + wo[0], wi[1] + wo[1], wi[2] + wo[2]);
    let across2 = y.mul_add(y, x.sq());
    let z2 = z.sq();
    let sum2 = (across2 + z2).max(tiny);
    // Twice the cosine of θd.
    let length = sum2.sqrt();
    // 1 − cosθh = sin²θh / (1 + cosθh) keeps the digits that the difference loses near the normal.
    let lowered = across2 * z.mul_add(length, sum2).max(tiny).recip();
    let turned = (-length).mul_add(one.lit(0.5), one).max(zero);
    // The difference is 2 sinθd u with u ⊥ h, and u.z = −sinθh cosφd.
    let largest = (z2 * sum2).min(across2 * (one.lit(4.0) - sum2)).max(tiny);
    let t = (wi[2] - wo[2]).sq() * sum2 * largest.recip();
    [lowered.min(one).sqrt().sqrt(), turned.sqrt(), t.min(one)]
}

/// The angles of a node of the lattice, as of [`angles`], a little above the horizon where it lies there.
pub fn node([h, d, t]: [f64; 3]) -> [f64; 3] {
    let theta_h = (2.0 * (h * h * FRAC_1_SQRT_2).min(1.0).asin()).min(LARGEST);
    let theta_d = (2.0 * (d * FRAC_1_SQRT_2).min(1.0).asin()).min(LARGEST);
    let horizon = STEEPEST / (theta_h.tan() * theta_d.tan()).max(1e-12);
    [theta_h, theta_d, (t.sqrt() * horizon.min(1.0)).acos()]
}

/// θh, θd ∈ [0, π/2] and φd ∈ [0, π/2] of two directions, radian.
pub fn angles(wi: DVec3, wo: DVec3) -> [f64; 3] {
    let (sum, difference) = (wi + wo, wi - wo);
    let (length, across) = (sum.length().max(1e-15), difference.length());
    let sin_h = (sum.truncate().length() / length).min(1.0);
    let cos_p = difference.z.abs() / (across * sin_h).max(1e-15);
    // By their sines or cosines, whichever is the smaller, which keeps the digits of both.
    [sum.truncate().length().atan2(sum.z.max(0.0)), across.atan2(length), cos_p.min(1.0).acos()]
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

    /// Nodes are looked up where they lie, all above the horizon, which is the last face.
    #[test]
    fn nodes_lie_above_the_horizon() {
        let mut grazing = 0;
        for i in 0..1000 {
            let at = [(i % 10) as f64 / 9.0, (i / 10 % 10) as f64 / 9.0, (i / 100) as f64 / 9.0];
            let (wi, wo) = directions(node(at));
            assert!(wi.z > 0.0 && wo.z > 0.0, "{at:?}: {wi} {wo}");
            let [theta_h, theta_d, _] = node(at);
            if at[2] == 1.0 && theta_h.tan() * theta_d.tan() > 1.0 {
                assert!(wi.z.min(wo.z) < 2e-3, "{at:?}: {wi} {wo}");
                grazing += 1;
            }
            // Where an angle is zero, or both directions graze, the others mean nothing.
            if at[..2].iter().all(|x| (0.1..0.9).contains(x)) {
                let found = unit(wi.to_array(), wo.to_array());
                assert!(at.iter().zip(found).all(|(a, b)| (a - b).abs() < 5e-3), "{at:?}: {found:?}");
            }
        }
        assert!(grazing > 10);
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
