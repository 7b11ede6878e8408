//! What the fitter measured at a node of the error grid of a family, in six bytes.

use crate::errors::Errors;
use crate::table::CellInfo;
use core::f64::consts::PI;

/// Five errors by a code of a byte, then the support in steps of π/255; all rounded up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Measured(pub [u8; 6]);

/// Eight steps to an octave from 2⁻²⁴; 0 stands for no error at all.
fn code(error: f32) -> u8 {
    if error > 0.0 { ((f64::from(error).log2() + 24.0) * 8.0).ceil().clamp(0.0, 254.0) as u8 + 1 } else { 0 }
}

fn error(code: u8) -> f32 {
    if code == 0 { 0.0 } else { ((f64::from(code) - 1.0) / 8.0 - 24.0).exp2() as f32 }
}

impl Measured {
    /// Rounded up.
    pub fn new(info: &CellInfo) -> Self {
        let [a, b, c, d, e] = info.errors.to_array().map(code);
        Self([a, b, c, d, e, (f64::from(info.support) / PI * 255.0).ceil().clamp(0.0, 255.0) as u8])
    }

    /// As a table has it.
    pub fn info(self) -> CellInfo {
        let [a, b, c, d, e, support] = self.0;
        let errors = Errors::from_array([a, b, c, d, e].map(error));
        CellInfo { errors, support: (PI * f64::from(support) / 255.0) as f32 }
    }

    /// The larger of each number.
    pub fn or(self, other: Self) -> Self {
        Self(core::array::from_fn(|i| self.0[i].max(other.0[i])))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_are_rounded_up_by_a_tenth_at_most() {
        for i in 0..200 {
            let exact = 1e-6 * 1.08f32.powi(i);
            let found = error(code(exact));
            assert!((1.0 - 1e-6..1.1).contains(&(found / exact)), "{exact} {found}");
        }
        assert_eq!(error(code(0.0)), 0.0);
        let info = CellInfo { errors: Errors { max: 0.01, ..Errors::default() }, support: 1.0 };
        let back = Measured::new(&info).info();
        assert!(back.support >= 1.0 && back.support < 1.02 && back.errors.max >= 0.01 && back.errors.l1 == 0.0);
        let other = Measured::new(&CellInfo { support: 3.0, ..CellInfo::default() });
        assert_eq!(Measured::new(&info).or(other).info(), CellInfo { support: other.info().support, ..back });
    }
}
