//! Elementary functions without branches: a fraction of the cost of the library's, to the precision of f32.

use core::f32::consts::{FRAC_PI_2, FRAC_PI_4, PI};

/// Sine and cosine of |x| ≤ π/4 by their series.
#[inline(always)]
pub fn sin_cos_octant(x: f32) -> (f32, f32) {
    let y = x * x;
    let sin = x * (1.0 + y * (-1.0 / 6.0 + y * (1.0 / 120.0 + y * (-1.0 / 5040.0 + y * (1.0 / 362_880.0)))));
    let cos = 1.0 + y * (-0.5 + y * (1.0 / 24.0 + y * (-1.0 / 720.0 + y * (1.0 / 40_320.0))));
    (sin, cos)
}

/// Sine and cosine of 2πu, u from 0 to 1.
#[inline(always)]
pub fn sin_cos_turn(u: f32) -> (f32, f32) {
    // The nearest quarter turn, and the rest, which is exact.
    let quarter = (4.0 * u + 0.5).floor();
    let (s, c) = sin_cos_octant(FRAC_PI_2 * (4.0 * u - quarter));
    let quarter = quarter as i32;
    let (s, c) = if quarter & 1 == 0 { (s, c) } else { (c, s) };
    (if quarter & 2 == 0 { s } else { -s }, if (quarter + 1) & 2 == 0 { c } else { -c })
}

/// Angle of (x, y) from the x axis, −π … π (Cephes' polynomial, Moshier 1992); 0 at the origin.
#[inline(always)]
pub fn atan2(y: f32, x: f32) -> f32 {
    let (a, b) = (x.abs(), y.abs());
    let (small, large) = (a.min(b), a.max(b));
    // Above π/8, the tangent of the difference to π/4.
    let steep = small > 0.414_213_57 * large;
    let (n, d) = if steep { (small - large, small + large) } else { (small, large) };
    let t = n / d.max(f32::MIN_POSITIVE);
    let z = t * t;
    let series = ((8.053_744e-2 * z - 0.138_776_85) * z + 0.199_777_11) * z - 0.333_329_5;
    let angle = if steep { FRAC_PI_4 } else { 0.0 } + (t + t * z * series);
    let angle = if b > a { FRAC_PI_2 - angle } else { angle };
    let angle = if x < 0.0 { PI - angle } else { angle };
    angle.copysign(y)
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::TAU;

    #[test]
    fn series() {
        for i in -100..=100 {
            let x = FRAC_PI_4 * i as f32 / 100.0;
            let (s, c) = sin_cos_octant(x);
            assert!((s - x.sin()).abs() < 1.5e-7 && (c - x.cos()).abs() < 1.5e-7, "{x}");
        }
    }

    #[test]
    fn turns() {
        for i in 0..=4096 {
            let u = i as f32 / 4096.0;
            let (s, c) = sin_cos_turn(u);
            let (es, ec) = (TAU * f64::from(u)).sin_cos();
            assert!((f64::from(s) - es).abs() < 2e-7 && (f64::from(c) - ec).abs() < 2e-7, "{u}: {s} {c}");
        }
    }

    #[test]
    fn angles() {
        for i in 0..4096 {
            for r in [1e-30f32, 1.0, 1e30] {
                let (s, c) = (TAU * f64::from(i) / 4096.0).sin_cos();
                let (x, y) = (r * c as f32, r * s as f32);
                let expected = f64::from(y).atan2(f64::from(x));
                assert!((f64::from(atan2(y, x)) - expected).abs() < 4e-7, "{x} {y}: {} {expected}", atan2(y, x));
            }
        }
        assert_eq!([atan2(0.0, 0.0), atan2(0.0, 1.0), atan2(0.0, -1.0), atan2(-1.0, 0.0)], [0.0, 0.0, PI, -FRAC_PI_2]);
    }
}
