//! The five errors of one cap, over directions that follow the reflected lobe.

use brdf_tables::brdf::Specular;
use brdf_tables::cap::Cap;
use brdf_tables::errors::Errors;
use brdf_tables::frame::{basis, mirror};
use brdf_tables::gauss::gauss_legendre;
use core::f64::consts::{PI, TAU};
use glam::DVec3;
use std::sync::OnceLock;

/// Rings of directions around the mirrored cap axis.
const RINGS: usize = 26;
/// Directions per ring.
const SPOKES: usize = 20;

/// Outgoing directions above the horizon with their solid angles: polar about the mirrored cap axis, dense within the
/// lobe, reaching to the far side of the hemisphere.
#[derive(Clone, Debug)]
pub struct Directions {
    /// Unit vectors, z > 0.
    pub wo: Vec<DVec3>,
    /// Solid angle of each, sr.
    pub weight: Vec<f64>,
}

impl Directions {
    /// Directions for the mean of `specular` over `cap`.
    pub fn new(specular: &Specular, cap: &Cap) -> Self {
        static RULE: OnceLock<Vec<(f64, f64)>> = OnceLock::new();
        Self::on(RULE.get_or_init(|| gauss_legendre(RINGS)), SPOKES, specular, cap)
    }

    /// As [`Directions::new`], on another number of rings, of so many directions each.
    pub(crate) fn with(specular: &Specular, cap: &Cap, rings: usize, spokes: usize) -> Self {
        Self::on(&gauss_legendre(rings), spokes, specular, cap)
    }

    fn on(rule: &[(f64, f64)], spokes: usize, specular: &Specular, cap: &Cap) -> Self {
        let frame = basis(mirror(cap.axis()));
        // δ = κ s/(1 − s²), so that half of the rings lie within about κ.
        let kappa = cap.half_angle() + 2.0 * specular.lobe_width();
        let top = (-kappa + (kappa * kappa + 4.0 * PI * PI).sqrt()) / TAU;
        let (mut wo, mut weight) = (Vec::new(), Vec::new());
        for &(x, w) in rule {
            let s = 0.5 * top * (x + 1.0);
            let c = 1.0 - s * s;
            let (sd, cd) = (kappa * s / c).sin_cos();
            let solid_angle = 0.5 * top * w * kappa * (1.0 + s * s) / (c * c) * sd * TAU / spokes as f64;
            for spoke in 0..spokes {
                let (sp, cp) = (TAU * (spoke as f64 + 0.5) / spokes as f64).sin_cos();
                let direction = frame * DVec3::new(sd * cp, sd * sp, cd);
                if direction.z > 0.0 {
                    wo.push(direction);
                    weight.push(solid_angle);
                }
            }
        }
        Self { wo, weight }
    }

    /// The five errors of `approximate` against `exact`, values of F in sr⁻¹ at the directions.
    pub fn errors(&self, exact: &[f64], approximate: &[f64]) -> Errors {
        let peak = exact.iter().fold(0f64, |m, &f| m.max(f)).max(f64::MIN_POSITIVE);
        let (mut square, mut lobe, mut lobe_area, mut absolute, mut total) = (0.0, 0.0, 0.0, 0.0, 0.0);
        let (mut worst, mut energy, mut energy_error) = (0f64, 0.0, 0.0);
        for i in 0..exact.len() {
            let (f, e, w) = (exact[i], approximate[i] - exact[i], self.weight[i]);
            square += w * e * e;
            if f > 0.01 * peak {
                lobe += w * e * e;
                lobe_area += w;
            }
            absolute += w * e.abs();
            total += w * f;
            worst = worst.max(e.abs());
            energy += w * f * self.wo[i].z;
            energy_error += w * e * self.wo[i].z;
        }
        let safe = |x: f64| x.max(f64::MIN_POSITIVE);
        Errors {
            rmse_hemi: ((square / TAU).sqrt() / peak) as f32,
            rmse_lobe: ((lobe / safe(lobe_area)).sqrt() / peak) as f32,
            l1: (absolute / safe(total)) as f32,
            max: (worst / peak) as f32,
            albedo: (energy_error.abs() / safe(energy)) as f32,
        }
    }

    /// Angle from the mirrored cap axis beyond which F stays below 1/1000 of its maximum, radian: that of the first ring
    /// beyond which all are dark, π when none is.
    pub fn support(&self, cap: &Cap, exact: &[f64]) -> f64 {
        let peak = exact.iter().fold(0f64, |m, &f| m.max(f));
        let centre = mirror(cap.axis());
        let angle = |wo: &DVec3| 2.0 * (0.5 * (*wo - centre).length()).min(1.0).asin();
        let lit = self.wo.iter().zip(exact).filter(|(_, f)| **f > 1e-3 * peak);
        let last = lit.map(|(wo, _)| angle(wo)).fold(0.0, f64::max);
        self.wo.iter().map(angle).filter(|a| *a > last + 1e-9).fold(PI, f64::min)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use brdf_tables::brdf::{Brdf, Phong};
    use brdf_tables::frame::spherical;
    use core::f64::consts::FRAC_PI_2;

    fn directions(theta: f64, sigma: f64) -> (Cap, Specular, Directions) {
        let specular = Specular::Phong(Phong { exponent: 40.0 });
        let cap = Cap::with_half_angle(theta, 0.4, sigma).unwrap();
        let directions = Directions::new(&specular, &cap);
        (cap, specular, directions)
    }

    /// The weights make up the hemisphere, and the lobe integrates to what it should.
    #[test]
    fn weights_are_solid_angles() {
        for (theta, sigma) in [(0.0, 0.1), (0.6, 0.4), (1.3, 0.2), (FRAC_PI_2, 0.3)] {
            let (_, _, d) = directions(theta, sigma);
            let sum: f64 = d.weight.iter().sum();
            assert!((sum / TAU - 1.0).abs() < 0.1, "{theta} {sigma}: {sum}");
            assert!(d.wo.iter().all(|w| w.z > 0.0 && (w.length() - 1.0).abs() < 1e-12));
        }
        let (cap, specular, d) = directions(0.6, 1e-4);
        let sum: f64 = d.wo.iter().zip(&d.weight).map(|(&wo, w)| w * specular.eval(cap.axis(), wo)).sum();
        assert!((sum * 41.0 / 42.0 - 1.0).abs() < 1e-3, "{sum}");
    }

    /// The five formulas, on an error of one sign and size.
    #[test]
    fn the_five_errors() {
        let (_, _, d) = directions(0.6, 0.2);
        let exact: Vec<f64> =
            d.wo.iter().map(|w| if w.dot(spherical(0.6, 0.4 + PI)) > 0.95 { 2.0 } else { 0.0 }).collect();
        let approximate: Vec<f64> = exact.iter().map(|f| f * 1.1).collect();
        let errors = d.errors(&exact, &approximate).to_array();
        let area: f64 = d.weight.iter().zip(&exact).filter(|(_, f)| **f > 0.0).map(|(w, _)| w).sum();
        let expected = [0.1 * (area / TAU).sqrt(), 0.1, 0.1, 0.1, 0.1];
        for ((found, expected), name) in errors.into_iter().zip(expected).zip(Errors::NAMES) {
            assert!((f64::from(found) - expected).abs() < 1e-6, "{name}: {found} instead of {expected}");
        }
        assert_eq!(d.errors(&exact, &exact).to_array(), [0.0; 5]);
        let none = vec![0.0; exact.len()];
        assert!(d.errors(&none, &none).to_array().iter().all(|e| e.is_finite()));
    }

    #[test]
    fn support_reaches_past_the_last_lit_ring() {
        let (cap, _, d) = directions(0.5, 0.1);
        let lit = |edge: f64| -> Vec<f64> {
            d.wo.iter().map(|w| if w.angle_between(mirror(cap.axis())) < edge { 1.0 } else { 0.0 }).collect()
        };
        for edge in [0.2, 0.5, 1.0] {
            let support = d.support(&cap, &lit(edge));
            assert!((edge..1.5 * edge + 0.1).contains(&support), "{edge}: {support}");
        }
        assert_eq!(d.support(&cap, &lit(PI)), PI);
    }
}
