//! Numbers and names for a person to read.

/// A fraction as a percentage of about three significant digits, without its sign.
pub fn percent(fraction: f64) -> String {
    let value = 100.0 * fraction;
    match value.abs() {
        x if x >= 100.0 => format!("{value:.0}"),
        x if x >= 10.0 => format!("{value:.1}"),
        x if x >= 1.0 => format!("{value:.2}"),
        x if x >= 0.1 => format!("{value:.3}"),
        _ => format!("{value:.4}"),
    }
}

/// A multiple of `step` with the decimals that the step needs.
pub fn multiple(value: f64, step: f64) -> String {
    let decimals = (-step.log10().floor()).max(0.0) as usize;
    format!("{value:.decimals$}")
}

/// At most `most` characters.
pub fn shortened(text: &str, most: usize) -> String {
    if text.chars().count() <= most { text.into() } else { text.chars().take(most - 1).chain(['…']).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits() {
        assert_eq!([2.5, 0.25, 0.025, 0.0025, 0.00025].map(percent), ["250", "25.0", "2.50", "0.250", "0.0250"]);
        assert_eq!(
            (multiple(0.5, 0.5), multiple(20.0, 10.0), multiple(0.06, 0.02)),
            ("0.5".into(), "20".into(), "0.06".into())
        );
        assert_eq!((shortened("abcd", 4), shortened("abcde", 4)), ("abcd".into(), "abc…".into()));
    }
}
