//! The text of the module, with the constants that it shares with the library.

use super::model::{BODY, FRESNEL, Kind};
use super::words::{CUBATURE, DIFFUSE, RULE_KINDS, ZONAL};
use crate::batch::MIN_HEIGHT;
use crate::brdf::constants::{INSIDE, SHEEN_FLOOR, WALTER, WALTER_END, WARD_FLOOR};
use crate::cubature::constants::{CHORD_STEPS, COSINES, FAR, OUTER, SHIFT};
use crate::real::{ASIN, COS, EXP2, LN, SIN};
use crate::zonal::REACH;
use core::f64::consts::{FRAC_2_PI, FRAC_PI_2, LN_2, LOG2_E, PI, TAU};

const PARTS: [&str; 7] = [
    include_str!("math.wgsl"),
    include_str!("cap.wgsl"),
    include_str!("models.wgsl"),
    include_str!("cubature.wgsl"),
    include_str!("zonal.wgsl"),
    include_str!("lobes.wgsl"),
    include_str!("lookup.wgsl"),
];

/// Terms of the series of φ − sinφ cosφ.
const SEGMENT_TERMS: usize = 6;

/// The buffer in which the functions find the tables.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Buffer<'a> {
    /// One that the text declares, with this group and binding.
    Bound {
        /// `@group`.
        group: u32,
        /// `@binding`.
        binding: u32,
    },
    /// A variable of type `array<u32>` that the including module declares.
    Named(&'a str),
}

/// The functions of the look-up, and the declaration of the buffer where it is [`Buffer::Bound`].
pub fn source(buffer: &Buffer) -> String {
    let name = match buffer {
        Buffer::Bound { .. } => "mb_tables",
        Buffer::Named(name) => name,
    };
    let mut text = match buffer {
        Buffer::Bound { group, binding } => {
            format!("@group({group}) @binding({binding}) var<storage, read> {name}: array<u32>;\n\n")
        }
        Buffer::Named(_) => String::new(),
    };
    text += &PARTS.join("\n");
    for (key, value) in constants() {
        text = text.replace(&format!("{{{{{key}}}}}"), &value);
    }
    text.replace("{{BUFFER}}", name)
}

/// What stands in double braces in the text.
fn constants() -> Vec<(&'static str, String)> {
    let number = |x: f64| format!("{:?}f", x as f32);
    let whole = |x: u32| format!("{x}u");
    let segment: Vec<f64> = (0..SEGMENT_TERMS).rev().map(segment).collect();
    let mut all = vec![
        ("EXP2", horner(&EXP2, "f")),
        ("LN", horner(&LN, "f")),
        ("ASIN", horner(&ASIN, "z")),
        ("SIN", horner(&SIN, "z")),
        ("COS", horner(&COS, "z")),
        ("SEGMENT", horner(&segment, "s2")),
        ("LOG2_E", number(LOG2_E)),
        ("LN_2", number(LN_2)),
        ("PI", number(PI)),
        ("FRAC_PI_2", number(FRAC_PI_2)),
        ("FRAC_2_PI", number(FRAC_2_PI)),
        ("INSIDE", number(INSIDE)),
        ("OVER_TWO_PI", number(1.0 / TAU)),
        ("MIN_HEIGHT", number(MIN_HEIGHT.into())),
        ("WALTER_END", number(WALTER_END)),
        ("WARD_FLOOR", number(WARD_FLOOR)),
        ("SHEEN_FLOOR", number(SHEEN_FLOOR)),
        ("REACH", number(REACH)),
        ("COSINES", whole(COSINES as u32)),
        ("SHIFT", whole(SHIFT)),
        ("CHORD_STEPS", number(CHORD_STEPS)),
        ("FAR", whole(FAR.into())),
        ("OUTER", whole(OUTER.into())),
        ("RULES", whole(RULE_KINDS)),
        ("BODY", whole(BODY)),
        ("FRESNEL", whole(FRESNEL)),
        ("DIFFUSE", whole(DIFFUSE)),
        ("ZONAL", whole(ZONAL)),
        ("CUBATURE", whole(CUBATURE)),
    ];
    all.extend(Kind::ALL.map(|kind| (kind.name(), whole(kind as u32))));
    all.extend(["WALTER_0", "WALTER_1", "WALTER_2", "WALTER_3"].into_iter().zip(WALTER.map(number)));
    all
}

/// A polynomial with these coefficients, the highest first, as nested `fma`.
fn horner(coefficients: &[f64], x: &str) -> String {
    let mut terms = coefficients.iter().map(|c| format!("{:?}f", *c as f32));
    let first = terms.next().unwrap_or_default();
    terms.fold(first, |sum, c| format!("fma({sum}, {x}, {c})"))
}

/// The coefficient of s^(2k + 3) in asin s − s √(1 − s²): its derivative is 2s²/√(1 − s²).
fn segment(k: usize) -> f64 {
    let binomial: f64 = (1..=k).map(|i| (2 * i - 1) as f64 / (2 * i) as f64).product();
    2.0 * binomial / (2 * k + 3) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_is_left_to_fill_in() {
        let text = source(&Buffer::Named("numbers"));
        assert!(!text.contains("{{") && !text.contains("}}"));
        assert!(text.contains("numbers[at]") && !text.contains("@binding"));
        for (key, _) in constants() {
            let used = PARTS.iter().any(|part| part.contains(&format!("{{{{{key}}}}}")));
            assert!(used, "{key} is not used");
        }
    }

    #[test]
    fn series_of_a_segment() {
        let s: f64 = 0.3;
        let sum: f64 = (0..SEGMENT_TERMS).map(|k| segment(k) * s.powi(2 * k as i32 + 3)).sum();
        let exact = s.asin() - s * (1.0 - s * s).sqrt();
        assert!((sum / exact - 1.0).abs() < 1e-7, "{sum} {exact}");
    }
}
