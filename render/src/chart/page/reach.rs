//! What it takes a method to come down to an error.

/// Where a curve of error comes down to a level.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reach {
    /// Its first point is there already.
    Within(f64),
    /// Here, between points.
    At(f64),
    /// None of its points is.
    Never,
}

/// Where a curve of (cost, error) first comes down to an error: between the points straight over logarithmic axes.
pub fn reach(curve: &[(f64, f64)], level: f64) -> Reach {
    let mut sorted = curve.to_vec();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
    match sorted.iter().position(|p| p.1 <= level) {
        None => Reach::Never,
        Some(0) => Reach::Within(sorted[0].0),
        Some(i) => {
            let ((x0, y0), (x1, y1)) = (sorted[i - 1], sorted[i]);
            // An error of 0 has no logarithm.
            if y1 <= 0.0 || level <= 0.0 {
                return Reach::At(x1);
            }
            let share = (y0 / level).ln() / (y0 / y1).ln();
            Reach::At(x0 * (x1 / x0).powf(share))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_are_straight_over_logarithmic_axes() {
        let curve = [(4.0, 0.01), (1.0, 0.04), (2.0, 0.02)];
        assert!(matches!(reach(&curve, 0.01), Reach::At(x) if (x - 4.0).abs() < 1e-12));
        let Reach::At(x) = reach(&curve, 0.03) else { panic!() };
        assert!((x - 4.0 / 3.0).abs() < 1e-12, "{x}");
        assert_eq!(reach(&curve, 0.05), Reach::Within(1.0));
        assert_eq!(reach(&curve, 0.001), Reach::Never);
        assert_eq!(reach(&[], 1.0), Reach::Never);
        assert_eq!(reach(&[(1.0, 1.0), (2.0, 0.0)], 0.5), Reach::At(2.0));
    }
}
