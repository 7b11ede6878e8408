//! Lines of numbers, as text files have them.

use super::{Place, ReadError};

/// Most lines of a file.
pub const MOST_LINES: usize = 4_000_000;

/// The text of bytes, without a byte order mark.
pub fn text(bytes: &[u8]) -> Result<&str, ReadError> {
    let bytes = bytes.strip_prefix(&[0xef, 0xbb, 0xbf]).unwrap_or(bytes);
    core::str::from_utf8(bytes).map_err(|e| {
        let line = 1 + bytes[..e.valid_up_to()].iter().filter(|b| **b == b'\n').count();
        ReadError::new(Place::Line(line), "not UTF-8 text")
    })
}

/// The number that a word is; it must be finite.
pub fn number(word: &str, line: usize) -> Result<f64, ReadError> {
    match word.trim().parse::<f64>() {
        Ok(x) if x.is_finite() => Ok(x),
        Ok(_) => Err(ReadError::new(Place::Line(line), format!("`{}` is not a finite number", word.trim()))),
        Err(_) => {
            let shown: String = word.trim().chars().take(40).filter(|c| !c.is_control()).collect();
            Err(ReadError::new(Place::Line(line), format!("`{shown}` is not a number")))
        }
    }
}

/// A zenith angle from the normal to the horizon, radian; half a thousandth beyond is rounding.
pub fn zenith(x: f64, what: &str, line: usize) -> Result<f64, ReadError> {
    use core::f64::consts::FRAC_PI_2;
    if (-5e-4..=FRAC_PI_2 + 5e-4).contains(&x) {
        return Ok(x.clamp(0.0, FRAC_PI_2));
    }
    Err(ReadError::new(Place::Line(line), format!("{what} is {x} rad, outside 0 to π/2")))
}
