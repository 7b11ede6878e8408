//! Shapes of the lobes of SGD and ABC, as functions of two directions, and the files that say them.

use crate::brdf::angles;
use core::f64::consts::{FRAC_1_PI, FRAC_PI_2};
use glam::DVec3;
use std::fmt::Write;

/// Largest value: parameters of nonsense pass it, and the numbers of single precision.
const LARGEST: f64 = 1e15;

/// Smallest cosine that the division by both is taken at.
const FLOOR: f64 = 1e-4;

/// What the shapes need of two directions.
#[derive(Clone, Copy, Debug)]
pub struct Pair {
    theta_h: f64,
    theta_d: f64,
    wi: f64,
    wo: f64,
}

impl Pair {
    /// Of two unit vectors above the horizon.
    pub fn new(wi: DVec3, wo: DVec3) -> Self {
        let [theta_h, theta_d, _] = angles(wi, wo);
        Self { theta_h, theta_d, wi: wi.z.min(1.0), wo: wo.z.min(1.0) }
    }

    /// cosᵢ cosₒ, not zero.
    fn cosines(&self) -> f64 {
        self.wi.max(FLOOR) * self.wo.max(FLOOR)
    }
}

/// One channel of the shifted gamma distribution (Bagher, Soler and Holzschuch 2012), by the keys of a `.sgd` file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gamma {
    /// Width of the distribution of normals.
    pub alpha: f64,
    /// Power of its tail.
    pub p: f64,
    /// Reflectance at normal incidence.
    pub f0: f64,
    /// What falls off it linearly with cosθd.
    pub f1: f64,
    /// Factor on the distribution.
    pub kap: f64,
    /// Strength of shadowing.
    pub lambda: f64,
    /// Factor in its exponent.
    pub c: f64,
    /// Power in its exponent.
    pub k: f64,
    /// Zenith angle at which it begins, radian.
    pub theta0: f64,
}

impl Gamma {
    /// Distribution of normals at θh.
    fn normals(&self, theta_h: f64) -> f64 {
        let cos2 = theta_h.cos().powi(2).max(1e-12);
        let x = self.alpha + (1.0 - cos2) / cos2 / self.alpha;
        self.kap * (-x).exp() * FRAC_1_PI / (x.powf(self.p) * cos2 * cos2)
    }

    /// F D G₁ G₁ / (π cosᵢ cosₒ) in sr⁻¹, which `ks` multiplies; at most 10¹⁵, 0 where a factor is negative.
    pub fn lobe(&self, at: &Pair) -> f64 {
        let cos_d = at.theta_d.cos();
        let f = self.f0 - self.f1 * cos_d + (1.0 - self.f0) * (1.0 - cos_d).powi(5);
        let g1 = |cos: f64| {
            let beyond = (cos.acos() - self.theta0).max(0.0);
            (1.0 + self.lambda * (1.0 - (self.c * beyond.powf(self.k)).min(700.0).exp())).clamp(0.0, 1.0)
        };
        let value = FRAC_1_PI * f * self.normals(at.theta_h) * g1(at.wi) * g1(at.wo) / at.cosines();
        if value > 0.0 { value.min(LARGEST) } else { 0.0 }
    }

    /// The same with `kap` such that the normals have the projected area 1: ∫ D cosθh dωh.
    #[must_use]
    pub fn normalised(self) -> Self {
        const POINTS: usize = 4096;
        let unit = Self { kap: 1.0, ..self };
        let area = |i: usize| {
            // Dense at the pole, where D is narrow: θ = x³ π/2.
            let x = (i as f64 + 0.5) / POINTS as f64;
            let theta = x.powi(3) * FRAC_PI_2;
            let weight = 3.0 * x * x * FRAC_PI_2 / POINTS as f64;
            2.0 * core::f64::consts::PI * unit.normals(theta) * theta.sin() * theta.cos() * weight
        };
        let area: f64 = (0..POINTS).map(area).sum();
        if area > 0.0 && area.is_finite() { Self { kap: (1.0 / area).min(1e9), ..self } } else { self }
    }

    /// A `.sgd` file of this shape with colours.
    pub fn text(&self, kd: [f64; 3], ks: [f64; 3]) -> String {
        let Self { alpha, p, f0, f1, kap, lambda, c, k, theta0 } = *self;
        let mut text = colors(&[("kd", kd), ("ks", ks)]);
        let numbers = [
            ("alpha", alpha),
            ("p", p),
            ("f0", f0),
            ("f1", f1),
            ("kap", kap),
            ("lambda", lambda),
            ("c", c),
            ("k", k),
            ("theta0", theta0),
        ];
        numbers.into_iter().for_each(|(key, x)| line(&mut text, key, &[x]));
        text
    }
}

/// The shape of the ABC model (Löw, Kronander, Ynnerman and Unger 2012, microfacets), by the keys of an `.abc` file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Groove {
    /// Width of the distribution of normals: the larger, the narrower.
    pub b: f64,
    /// Power of its tail.
    pub c: f64,
    /// Index of the dielectric that reflects.
    pub ior: f64,
}

impl Groove {
    /// F G / (π cosᵢ cosₒ (1 + b (1 − cosθh))^c) in sr⁻¹, which `a` multiplies.
    pub fn lobe(&self, at: &Pair) -> f64 {
        let (cos_h, cos_d) = (at.theta_h.cos(), at.theta_d.cos().max(1e-6));
        // 1 − cosθh with all its digits.
        let lowered = 2.0 * (0.5 * at.theta_h).sin().powi(2);
        let shape = (1.0 + self.b * lowered).powf(-self.c);
        let groove = (2.0 * cos_h * at.wi.min(at.wo) / cos_d).min(1.0);
        FRAC_1_PI * dielectric(cos_d, self.ior) * shape * groove / at.cosines()
    }

    /// An `.abc` file of this shape with colours.
    pub fn text(&self, kd: [f64; 3], a: [f64; 3]) -> String {
        let mut text = colors(&[("kd", kd), ("a", a)]);
        [("b", self.b), ("c", self.c), ("ior", self.ior)].into_iter().for_each(|(key, x)| line(&mut text, key, &[x]));
        text
    }
}

fn colors(keys: &[(&str, [f64; 3])]) -> String {
    let mut text = String::new();
    keys.iter().for_each(|(key, rgb)| line(&mut text, key, rgb));
    text
}

/// A line of a file, with six digits.
fn line(text: &mut String, key: &str, numbers: &[f64]) {
    text.push_str(key);
    for x in numbers {
        let rounded: f64 = format!("{x:.5e}").parse().unwrap_or(*x);
        let _ = write!(text, " {rounded}");
    }
    text.push('\n');
}

/// Unpolarised reflectance of a dielectric from outside.
pub(super) fn dielectric(cos: f64, ior: f64) -> f64 {
    let inside = (1.0 - (1.0 - cos * cos) / (ior * ior)).max(0.0).sqrt();
    let across = (cos - ior * inside) / (cos + ior * inside);
    let along = (ior * cos - inside) / (ior * cos + inside);
    0.5 * (across * across + along * along)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::spherical;
    use crate::measured::{Format, Reading};

    /// What is written is what is read, and normals have the area 1.
    #[test]
    fn files_say_the_shape() {
        let gamma =
            Gamma { alpha: 0.05, p: 0.8, f0: 0.3, f1: -0.1, kap: 1.0, lambda: 2.0, c: 0.7, k: 3.0, theta0: 0.4 };
        let normal = gamma.normalised();
        let rings = 200_000;
        let area = |i: u32| {
            let cos = (f64::from(i) + 0.5) / f64::from(rings);
            2.0 * core::f64::consts::PI * normal.normals(cos.acos()) * cos / f64::from(rings)
        };
        let area: f64 = (0..rings).map(area).sum();
        assert!((area - 1.0).abs() < 1e-3, "{area}");
        let groove = Groove { b: 123.456, c: 1.3, ior: 1.45 };
        let (kd, ks) = ([0.1, 0.2, 0.3], [0.4, 0.5, 0.6]);
        let (wi, wo) = (spherical(0.8, 0.3), spherical(0.5, 2.9));
        let pair = Pair::new(wi, wo);
        for (format, text, lobe) in [
            (Format::Sgd, normal.text(kd, ks), normal.lobe(&pair)),
            (Format::Abc, groove.text(kd, ks), groove.lobe(&pair)),
        ] {
            let read = Reading::from_bytes(format, text.as_bytes()).unwrap().source.rgb(wi, wo).unwrap();
            for c in 0..3 {
                let right = kd[c] * FRAC_1_PI + ks[c] * lobe;
                assert!((read[c] / right - 1.0).abs() < 1e-4, "{text}: {read:?} {right}");
            }
        }
    }
}
