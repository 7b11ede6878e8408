//! Speed and size against accuracy, of every representation and solver.

mod axes;
mod bench;
mod draw;
mod methods;
mod monte_carlo;

pub use draw::figure;
pub use methods::{Measurement, measure};

use brdf_tables::errors::{Errors, Summary};
use std::fmt::Write;

/// All curves of a material.
pub struct Chart {
    /// Its recipe.
    pub material: String,
    /// One per method.
    pub curves: Vec<Curve>,
}

/// One method at several settings.
pub struct Curve {
    /// Method, and solver where there is one.
    pub name: String,
    /// From coarse to fine.
    pub points: Vec<Point>,
}

/// One method at one setting.
pub struct Point {
    /// The setting.
    pub label: String,
    /// Time of one evaluation, ns.
    pub nanoseconds: f64,
    /// Bytes of the representation in a table; `None` for a method without one.
    pub bytes: Option<usize>,
    /// Errors over the caps.
    pub errors: Summary,
}

/// The charts as CSV; errors are fractions.
pub fn csv(charts: &[Chart]) -> String {
    let mut text = String::from("material,method,setting,nanoseconds,bytes");
    for row in ["median", "p95", "worst"] {
        for name in Errors::NAMES {
            let _ = write!(text, ",{name}_{row}");
        }
    }
    text.push('\n');
    for chart in charts {
        for curve in &chart.curves {
            for point in &curve.points {
                let bytes = point.bytes.map(|bytes| bytes.to_string()).unwrap_or_default();
                let (name, label) = (&curve.name, &point.label);
                let _ = write!(text, "\"{}\",{name},{label},{:.2},{bytes}", chart.material, point.nanoseconds);
                for errors in [point.errors.median, point.errors.p95, point.errors.worst] {
                    for error in errors.to_array() {
                        let _ = write!(text, ",{error:?}");
                    }
                }
                text.push('\n');
            }
        }
    }
    text
}
