//! Parameters that others fitted to measured materials: SGD and ABC, a line of text for each.
//!
//! `.sgd`, the shifted gamma distribution (Bagher, Soler and Holzschuch 2012, "Accurate fitting of measured reflectances using a
//! shifted gamma micro-facet distribution"): f_r = (kd + ks F D G₁ G₁ / (cosᵢ cosₒ)) / π, with
//! D = kap e^−x x^−p / (π cos⁴θh), x = alpha + tan²θh / alpha, F = f0 − f1 cosθd + (1 − f0)(1 − cosθd)⁵ and
//! G₁ = 1 + lambda (1 − e^(c max(0, θ − theta0)^k)) within [0, 1]. Eleven keys, all of one number or three (RGB).
//!
//! `.abc` (Löw, Kronander, Ynnerman and Unger 2012, "BRDF models for accurate and efficient rendering of glossy surfaces", the
//! microfacet form): f_r = (kd + F D G / (cosᵢ cosₒ)) / π with D = a / (1 + b (1 − cosθh))^c, F that of a dielectric of index
//! `ior`, and G of V-shaped grooves. `kd` and `a` are of one number or three, `b`, `c` and `ior` of one.
//!
//! Lines that begin with `#` are remarks; keys stand first, their numbers behind blanks or commas, an equals sign if one likes.

use super::lines::{number, text};
use super::shape::{Gamma, Groove, Pair};
use super::{Format, Place, ReadError, Reading, Source};
use core::f64::consts::{FRAC_1_PI, PI};
use glam::DVec3;

/// A key, the range of its numbers, and whether it may have three.
pub(super) struct Key(pub &'static str, pub f64, pub f64, pub bool);

const SGD: [Key; 11] = [
    Key("kd", 0.0, 1.0, true),
    Key("ks", 0.0, 1e3, true),
    Key("alpha", 1e-8, 1e3, true),
    Key("p", 0.0, 1e2, true),
    Key("f0", -1e2, 1e2, true),
    Key("f1", -1e2, 1e2, true),
    Key("kap", 0.0, 1e9, true),
    Key("lambda", 0.0, 1e9, true),
    Key("c", 0.0, 1e40, true),
    Key("k", 0.0, 1e4, true),
    Key("theta0", -PI, PI, true),
];
const ABC: [Key; 5] = [
    Key("kd", 0.0, 1.0, true),
    Key("a", 0.0, 1e9, true),
    Key("b", 0.0, 1e12, false),
    Key("c", 0.0, 1e3, false),
    Key("ior", 1.0, 1e3, false),
];

/// The numbers of a file, by key, in the order of `keys`; `None` of a key that is not there.
pub(super) fn found<const N: usize>(bytes: &[u8], keys: &[Key; N]) -> Result<[Option<[f64; 3]>; N], ReadError> {
    let fail = |line: usize, what: String| ReadError::new(Place::Line(line), what);
    let known = || known(keys);
    let mut found = [None; N];
    for (line, words) in text(bytes)?.lines().enumerate().map(|(i, l)| (i + 1, l.trim())) {
        if words.is_empty() || words.starts_with('#') {
            continue;
        }
        let separator = |c: char| c.is_whitespace() || ",=[]".contains(c);
        let mut words = words.split(separator).filter(|w| !w.is_empty());
        let name = words.next().unwrap_or_default();
        let at = keys.iter().position(|key| key.0 == name);
        let at = at.ok_or_else(|| fail(line, format!("the key must be one of {}", known())))?;
        let Key(key, min, max, colored) = &keys[at];
        let values = words.take(4).map(|word| number(word, line)).collect::<Result<Vec<_>, _>>()?;
        let rgb = match values[..] {
            [x] => [x; 3],
            [r, g, b] if *colored => [r, g, b],
            _ => {
                return Err(fail(
                    line,
                    format!("{key} has {}", if *colored { "one number or three" } else { "one number" }),
                ));
            }
        };
        if let Some(x) = rgb.iter().find(|x| !(*min..=*max).contains(*x)) {
            return Err(fail(line, format!("{key} is {x}, outside {min} to {max}")));
        }
        if found[at].replace(rgb).is_some() {
            return Err(fail(line, format!("{key} stands there twice")));
        }
    }
    Ok(found)
}

fn known(keys: &[Key]) -> String {
    keys.iter().map(|k| k.0).collect::<Vec<_>>().join(", ")
}

/// The same where every key must be there.
fn numbers<const N: usize>(bytes: &[u8], keys: &[Key; N]) -> Result<[[f64; 3]; N], ReadError> {
    let mut numbers = [[0.0; 3]; N];
    for (k, rgb) in found(bytes, keys)?.into_iter().enumerate() {
        let missing = || format!("{} is missing (keys: {})", keys[k].0, known(keys));
        numbers[k] = rgb.ok_or_else(|| ReadError::new(Place::File, missing()))?;
    }
    Ok(numbers)
}

/// Parameters of SGD per channel, in the order of [`SGD`].
struct Shifted([[f64; 3]; 11]);

/// Parameters of ABC, in the order of [`ABC`].
struct Grooves([[f64; 3]; 5]);

/// Reads the bytes of a `.sgd` file.
pub fn sgd(bytes: &[u8]) -> Result<Reading, ReadError> {
    let source = Shifted(numbers(bytes, &SGD)?);
    Ok(Reading { format: Format::Sgd, source: Box::new(source), notes: vec!["SGD: fitted parameters".into()] })
}

/// Reads the bytes of a `.abc` file.
pub fn abc(bytes: &[u8]) -> Result<Reading, ReadError> {
    let source = Grooves(numbers(bytes, &ABC)?);
    Ok(Reading { format: Format::Abc, source: Box::new(source), notes: vec!["ABC: fitted parameters".into()] })
}

impl Source for Shifted {
    fn rgb(&self, wi: DVec3, wo: DVec3) -> Option<[f64; 3]> {
        let pair = Pair::new(wi, wo);
        let [kd, ks, alpha, p, f0, f1, kap, lambda, c, k, theta0] = &self.0;
        Some(core::array::from_fn(|i| {
            let shape = Gamma {
                alpha: alpha[i],
                p: p[i],
                f0: f0[i],
                f1: f1[i],
                kap: kap[i],
                lambda: lambda[i],
                c: c[i],
                k: k[i],
                theta0: theta0[i],
            };
            FRAC_1_PI * kd[i] + ks[i] * shape.lobe(&pair)
        }))
    }

    fn is_folded(&self) -> bool {
        true
    }
}

impl Source for Grooves {
    fn rgb(&self, wi: DVec3, wo: DVec3) -> Option<[f64; 3]> {
        let [kd, a, b, c, ior] = &self.0;
        let lobe = Groove { b: b[0], c: c[0], ior: ior[0] }.lobe(&Pair::new(wi, wo));
        Some(core::array::from_fn(|i| FRAC_1_PI * kd[i] + a[i] * lobe))
    }

    fn is_folded(&self) -> bool {
        true
    }
}

#[cfg(test)]
mod tests {
    use super::super::shape::dielectric;
    use super::*;
    use crate::frame::spherical;

    const GAMMA: &str =
        "# test\nkd .1 .2 .3\nks = 0.5\nalpha 0.1\np 0.7\nf0 .05\nf1 .01\nkap 10\nlambda 1\nc .5\nk 4\ntheta0 .3\n";
    const GROOVE: &str = "kd 0.1, 0.2, 0.3\na 5\nb 100\nc 1.5\nior 1.5\n";

    /// Closed forms at normal incidence, where θh = θd = 0, and reciprocity.
    #[test]
    fn closed_forms() {
        let at = |reading: &Reading, wi, wo| reading.source.rgb(wi, wo).unwrap();
        let reading = sgd(GAMMA.as_bytes()).unwrap();
        let d = 10.0 * (-0.1f64).exp() / (PI * 0.1f64.powf(0.7));
        let right = (0.1 + 0.5 * 0.04 * d) / PI;
        assert!((at(&reading, DVec3::Z, DVec3::Z)[0] / right - 1.0).abs() < 1e-6);
        let (wi, wo) = (spherical(0.9, 0.0), spherical(0.4, 2.0));
        let exchanged = at(&reading, wo, wi);
        assert!((0..3).all(|c| (at(&reading, wi, wo)[c] / exchanged[c] - 1.0).abs() < 1e-12));
        // Both views lie beyond theta0: G₁ = 1 + 1 − e^(0.5 (θ − 0.3)⁴).
        let half = (wi + wo).normalize();
        let x = 0.1 + (1.0 / half.z.powi(2) - 1.0) / 0.1;
        let d = 10.0 * (-x).exp() / (PI * x.powf(0.7) * half.z.powi(4));
        let cos = half.dot(wi);
        let f = 0.05 - 0.01 * cos + 0.95 * (1.0 - cos).powi(5);
        let g = |theta: f64| 2.0 - (0.5 * (theta - 0.3f64).powi(4)).exp();
        let right = (0.2 + 0.5 * f * d * g(0.9) * g(0.4) / (wi.z * wo.z)) / PI;
        assert!((at(&reading, wi, wo)[1] / right - 1.0).abs() < 1e-6);

        let reading = abc(GROOVE.as_bytes()).unwrap();
        let right = (0.1 + 5.0 * 0.04) / PI;
        assert!((at(&reading, DVec3::Z, DVec3::Z)[0] / right - 1.0).abs() < 1e-6);
        let exchanged = at(&reading, wo, wi);
        assert!((0..3).all(|c| (at(&reading, wi, wo)[c] / exchanged[c] - 1.0).abs() < 1e-12));
        // At grazing incidence everything is reflected.
        assert!((dielectric(1e-9, 1.5) - 1.0).abs() < 1e-6 && (dielectric(1.0, 1.5) - 0.04).abs() < 1e-12);
    }

    #[test]
    fn bad_lines_are_named() {
        let error = |from: &str, to: &str| sgd(GAMMA.replace(from, to).as_bytes()).err().unwrap().to_string();
        assert!(error("alpha 0.1", "beta 0.1").contains("line 4: the key must be one of kd, ks"));
        assert!(error("alpha 0.1", "alpha 0").contains("line 4: alpha is 0, outside"));
        assert!(error("alpha 0.1", "alpha 1 2").contains("line 4: alpha has one number or three"));
        assert!(error("alpha 0.1", "alpha nan").contains("line 4: `nan`"));
        assert!(error("alpha 0.1", "kd 0.1").contains("line 4: kd stands there twice"));
        assert!(error("alpha 0.1", "").contains("alpha is missing"));
        let error = |from: &str, to: &str| abc(GROOVE.replace(from, to).as_bytes()).err().unwrap().to_string();
        assert!(error("ior 1.5", "ior 1 2 3").contains("line 5: ior has one number"));
        assert!(error("ior 1.5", "ior 0.5").contains("line 5: ior is 0.5"));
    }
}
