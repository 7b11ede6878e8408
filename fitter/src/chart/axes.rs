//! Ranges and tick labels of the logarithmic axes.

use core::ops::Range;

/// The values with a margin, a decade at least.
pub fn range(values: impl Iterator<Item = f64>) -> Range<f64> {
    let (lo, hi) = values.fold((f64::INFINITY, 0f64), |(lo, hi), x| (lo.min(x), hi.max(x)));
    if lo > hi {
        return 1.0..10.0;
    }
    let (lo, hi) = (lo / 1.6, hi * 2.5); // the label of a point is on its right
    lo..hi.max(10.0 * lo)
}

/// A time in ns.
pub fn time(x: &f64) -> String {
    match *x {
        x if x >= 1e6 => format!("{} ms", x / 1e6),
        x if x >= 1e3 => format!("{} µs", x / 1e3),
        x => format!("{x} ns"),
    }
}

/// A number of bytes.
pub fn bytes(x: &f64) -> String {
    match *x {
        x if x >= 1e6 => format!("{} MB", x / 1e6),
        x if x >= 1e3 => format!("{} KB", x / 1e3),
        x => format!("{x} B"),
    }
}

/// A fraction as a percentage.
pub fn percentage(x: &f64) -> String {
    let value = 100.0 * x;
    let decimals = (-value.log10().floor()).max(0.0) as usize;
    format!("{value:.decimals$} %")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels() {
        assert_eq!(
            (time(&10.0), time(&1e5), bytes(&1e4), percentage(&1e-4)),
            ("10 ns".into(), "100 µs".into(), "10 KB".into(), "0.01 %".into())
        );
        assert_eq!((range([2.0].into_iter()), range([].into_iter())), (1.25..12.5, 1.0..10.0));
    }
}
