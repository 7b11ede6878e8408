//! The five errors of a mean BRDF, and what a table says about them.

use serde::{Deserialize, Serialize};

/// Errors of F over the hemisphere of `wo` for one cap, e = approximate − exact, as fractions (not percent).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Errors {
    /// √(mean over 2π of e²) / max F: the paper's, which flatters narrow lobes.
    pub rmse_hemi: f32,
    /// √(mean over S of e²) / max F with S = {F > 0.01 max F}: the main figure.
    pub rmse_lobe: f32,
    /// ∫|e| / ∫F.
    pub l1: f32,
    /// max|e| / max F.
    pub max: f32,
    /// |∫e cosθo| / ∫F cosθo.
    pub albedo: f32,
}

impl Errors {
    /// Names, in the order of [`Errors::to_array`].
    pub const NAMES: [&'static str; 5] = ["rmse_hemi", "rmse_lobe", "l1", "max", "albedo"];

    /// The five numbers.
    pub fn to_array(self) -> [f32; 5] {
        [self.rmse_hemi, self.rmse_lobe, self.l1, self.max, self.albedo]
    }

    /// From the five numbers.
    pub fn from_array([rmse_hemi, rmse_lobe, l1, max, albedo]: [f32; 5]) -> Self {
        Self { rmse_hemi, rmse_lobe, l1, max, albedo }
    }
}

/// Median, 95th percentile and worst of each error over a set of caps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    /// Caps measured.
    pub caps: u32,
    /// Median of each error.
    pub median: Errors,
    /// 95th percentile of each error.
    pub p95: Errors,
    /// Largest of each error.
    pub worst: Errors,
}

impl Summary {
    /// Summary of `errors`; all zero when there are none.
    pub fn new(errors: &[Errors]) -> Self {
        if errors.is_empty() {
            return Self::default();
        }
        let mut columns: [Vec<f32>; 5] = core::array::from_fn(|i| errors.iter().map(|e| e.to_array()[i]).collect());
        for column in &mut columns {
            column.sort_by(f32::total_cmp);
        }
        let at = |fraction: f64| {
            let index = ((errors.len() - 1) as f64 * fraction).round() as usize;
            Errors::from_array(core::array::from_fn(|i| columns[i][index]))
        };
        Self { caps: errors.len() as u32, median: at(0.5), p95: at(0.95), worst: at(1.0) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn summary_orders_each_error_by_itself() {
        let errors: Vec<Errors> =
            (0..101).map(|i| Errors::from_array([i, 100 - i, 0, 7, i % 10].map(|x| x as f32))).collect();
        let summary = Summary::new(&errors);
        assert_eq!(summary.caps, 101);
        assert_eq!(summary.median.to_array(), [50.0, 50.0, 0.0, 7.0, 4.0]);
        assert_eq!(summary.p95.to_array(), [95.0, 95.0, 0.0, 7.0, 9.0]);
        assert_eq!(summary.worst.to_array(), [100.0, 100.0, 0.0, 7.0, 9.0]);
        assert_eq!(Summary::new(&[]), Summary::default());
    }
}
