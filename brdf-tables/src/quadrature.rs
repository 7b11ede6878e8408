//! The mean BRDF by deterministic quadrature: the truth every faster representation is measured against.
//!
//! Cap coordinates (β from the axis, ψ around it): Gauss–Legendre in β, and in ψ the trapezoid rule (spectral on a
//! whole ring) or Gauss–Legendre (on a ring cut by the horizon). The first cut ring has a square-root kink, so the
//! range of β is split there and β = β₀ + (σ − β₀)t² beyond it. Orders grow until two successive sums agree.

use crate::brdf::{Brdf, Formula, Specular, Visitor};
use crate::cap::Cap;
use crate::frame::basis;
use crate::gauss::gauss_legendre;
use core::f64::consts::{FRAC_PI_2, PI};
use glam::DVec3;
use std::sync::OnceLock;

/// Rules of growing order, each about 1.5 times the last; the largest serve narrow lobes seen at grazing angles.
const ORDERS: [usize; 13] = [4, 6, 10, 16, 24, 36, 54, 80, 120, 180, 270, 400, 600];

fn rule(level: usize) -> &'static [(f64, f64)] {
    static RULES: [OnceLock<Vec<(f64, f64)>>; ORDERS.len()] = [const { OnceLock::new() }; ORDERS.len()];
    RULES[level].get_or_init(|| gauss_legendre(ORDERS[level]))
}

/// ∫ f(wi) cosθi dwi over the part of the cap above the horizon, for one pair of orders.
fn integrate(cap: &Cap, radial: usize, azimuthal: usize, f: &impl Fn(DVec3) -> f64) -> f64 {
    let to_local = basis(cap.axis());
    let (sigma, theta) = (cap.half_angle(), cap.theta());
    // The frame of the rings: e1 points down the slope of the cap, so that ψ = 0 is its lowest point.
    let down = if theta < 1e-9 { to_local.x_axis } else { (cap.axis() * cap.axis().z - DVec3::Z).normalize() };
    let across = cap.axis().cross(down);
    let ring = |beta: f64| {
        let (sb, cb) = beta.sin_cos();
        let point = |psi: f64| {
            let (sp, cp) = psi.sin_cos();
            cap.axis() * cb + (down * cp + across * sp) * sb
        };
        if beta + theta <= FRAC_PI_2 {
            let n = 2 * ORDERS[azimuthal];
            let sum: f64 = (0..n)
                .map(|i| {
                    let w = point(2.0 * PI * (i as f64 + 0.5) / n as f64);
                    f(w) * w.z
                })
                .sum();
            return sum * sb * 2.0 * PI / n as f64;
        }
        let half = PI - (1.0 / (beta.tan() * theta.tan())).clamp(-1.0, 1.0).acos();
        let sum: f64 = rule(azimuthal + 1)
            .iter()
            .map(|&(x, weight)| {
                let w = point(PI + half * x);
                weight * f(w) * w.z.max(0.0)
            })
            .sum();
        sum * sb * half
    };
    let split = (FRAC_PI_2 - theta).clamp(0.0, sigma);
    let mut sum = 0.0;
    for &(x, weight) in rule(radial) {
        let t = 0.5 * (x + 1.0);
        if split > 0.0 {
            sum += 0.5 * weight * split * ring(split * t);
        }
        if split < sigma {
            sum += weight * t * (sigma - split) * ring(split + (sigma - split) * t * t);
        }
    }
    sum
}

/// F(cap; wo) of a specular model in sr⁻¹ (eq. 9), to a relative tolerance on its own value or on `scale` sr⁻¹,
/// whichever is laxer (pass 0 for the strict one). Reaches about 1e-9 except where the integrand itself has kinks.
pub fn mean_brdf(specular: &Specular, cap: &Cap, wo: DVec3, tolerance: f64, scale: f64) -> f64 {
    struct Run<'a>(&'a Cap, DVec3, f64, f64, f64);
    impl Visitor for Run<'_> {
        type Output = f64;
        fn visit<M: Brdf + Formula>(self, model: &M) -> f64 {
            refine(model, self.0, self.1, self.2, self.3, self.4)
        }
    }
    // The narrowest extent of the lobe over wi, cut where it would ask for more nodes than there are.
    let narrowing = specular.narrowing(wo).max(0.02);
    specular.visit(Run(cap, wo, specular.lobe_width() * narrowing, tolerance, scale))
}

fn refine(brdf: &impl Brdf, cap: &Cap, wo: DVec3, width: f64, tolerance: f64, scale: f64) -> f64 {
    let f = |wi: DVec3| brdf.eval(wi, wo);
    let area = cap.projected_solid_angle();
    if wo.z <= 0.0 || area <= 0.0 {
        return 0.0;
    }
    let last = ORDERS.len() - 2;
    // Start where the nodes are about a lobe width apart, so that a lobe inside a large cap is not missed by every rule
    // that is tried.
    let needed = cap.half_angle() / width;
    let first = ORDERS.iter().position(|&n| n as f64 >= needed).unwrap_or(last).min(last - 2);
    let (mut radial, mut azimuthal) = (first, first + 1);
    let mut value = integrate(cap, radial, azimuthal, &f) / area;
    // A first agreement can be luck (a lobe between the nodes): ask for two in a row.
    let mut agreed = 0;
    while agreed < 2 && azimuthal < last {
        (radial, azimuthal) = (radial + 1, azimuthal + 1);
        let finer = integrate(cap, radial, azimuthal, &f) / area;
        let close = (finer - value).abs() <= tolerance * finer.abs().max(scale);
        agreed = if close { agreed + 1 } else { 0 };
        value = finer;
    }
    value
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::brdf::Phong;
    use crate::frame::spherical;

    /// Known integrals over caps: constants (the area, and the projected area in closed form) and a polynomial.
    #[test]
    fn integrates_what_is_known() {
        for (theta, sigma) in [(0.0, 0.3), (0.7, 0.4), (1.2, 0.9), (FRAC_PI_2, 0.5), (0.0, FRAC_PI_2), (1e-7, 1.2)] {
            let cap = Cap::with_half_angle(theta, 0.9, sigma).unwrap();
            let sum = integrate(&cap, 3, 4, &|_| 1.0);
            assert!((sum / cap.projected_solid_angle() - 1.0).abs() < 1e-6, "{theta} {sigma}: {sum}");
        }
        // ∫ cos²θ over a cap about the normal.
        let cap = Cap::with_half_angle(0.0, 0.0, 0.8).unwrap();
        let exact = 2.0 * PI * (1.0 - 0.8f64.cos().powi(3)) / 3.0;
        assert!((integrate(&cap, 2, 3, &|w| w.z) - exact).abs() < 1e-10);
    }

    /// A lobe of a hundredth of a radian anywhere in a cap of one radian is found.
    #[test]
    fn narrow_lobes_are_not_missed() {
        let specular = Specular::Phong(Phong { exponent: 1e4 });
        let cap = Cap::with_half_angle(0.4, 0.2, 1.0).unwrap();
        let all = 1.0 / cap.projected_solid_angle();
        for (theta, phi) in [(0.4, 3.34), (0.9, 3.0), (0.05, 1.0), (0.7, 4.0)] {
            let wo = spherical(theta, phi);
            // The whole lobe lies in the cap: ∫ f cosθi = cosθo, but for terms in 1/n.
            let mean = mean_brdf(&specular, &cap, wo, 1e-6, 0.0);
            assert!((mean / (all * wo.z) - 1.0).abs() < 1e-3, "{theta} {phi}: {mean}");
        }
        assert_eq!(mean_brdf(&specular, &cap, DVec3::NEG_Z, 1e-6, 0.0), 0.0);
    }
}
