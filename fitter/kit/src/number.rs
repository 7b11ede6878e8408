//! Numbers of a command line: what is not one, or out of range, is refused with what is allowed.

use core::fmt::Display;
use core::ops::RangeInclusive;
use core::str::FromStr;

/// A parser of finite numbers in `range`; `expected` says which those are.
pub fn number<T>(
    range: RangeInclusive<T>,
    expected: &'static str,
) -> impl Fn(&str) -> Result<T, String> + Clone + Send + Sync + 'static
where
    T: FromStr + Into<f64> + PartialOrd + Copy + Send + Sync + 'static,
{
    move |text| match text.trim().parse::<T>() {
        Ok(x) if range.contains(&x) => Ok(x),
        Ok(x) if !x.into().is_finite() => Err(format!("not a finite number; expected {expected}")),
        _ => Err(format!("expected {expected}")),
    }
}

/// A parser of whole numbers in `range`; `hint` is what else a person should know, with its punctuation.
pub fn whole<T>(
    range: RangeInclusive<T>,
    hint: &'static str,
) -> impl Fn(&str) -> Result<T, String> + Clone + Send + Sync + 'static
where
    T: FromStr + PartialOrd + Copy + Display + Send + Sync + 'static,
{
    move |text| {
        let expected = || format!("expected a whole number from {} to {}{hint}", range.start(), range.end());
        text.trim().parse().ok().filter(|x| range.contains(x)).ok_or_else(expected)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_finite_and_in_range() {
        let parse = number(0.5f32..=1.0, "a number from 0.5 to 1");
        assert_eq!((parse("0.75"), parse(" 1 ")), (Ok(0.75), Ok(1.0)));
        for bad in ["nan", "inf", "-inf", "1e999", "NaN"] {
            assert_eq!(parse(bad).unwrap_err(), "not a finite number; expected a number from 0.5 to 1", "{bad}");
        }
        for bad in ["", "x", "0.49", "1.01", "-1", "0.75 s"] {
            assert_eq!(parse(bad).unwrap_err(), "expected a number from 0.5 to 1", "{bad}");
        }
        let parse = whole(1..=16u8, "; or none");
        assert_eq!(parse("16"), Ok(16));
        for bad in ["0", "17", "-1", "300", "1.0", "nan", ""] {
            assert_eq!(parse(bad).unwrap_err(), "expected a whole number from 1 to 16; or none", "{bad}");
        }
    }
}
