//! The figures of a scene.

use super::method::{self, METHODS};
use super::plot::{Axes, Series, plot};
use super::row::Row;
use super::subject::Subject;
use anyhow::Result;
use kit::figure::PALETTE;
use plotters::style::RGBColor;

/// A figure with what it shows.
pub struct Figure {
    /// Part of its file's name.
    pub name: &'static str,
    /// SVG.
    pub svg: String,
    /// For a reader.
    pub caption: &'static str,
}

/// Runs of one kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Runs {
    /// Those that kept to a time budget.
    Budgets,
    /// Those at a τ.
    Qualities,
    /// Those whose records are all of one size, at one τ; those at a τ of methods without.
    Sizes,
}

impl Runs {
    /// Whether a row is of this kind, `sized` telling whether its method has runs of one size.
    fn have(self, row: &Row, sized: bool) -> bool {
        match self {
            Self::Budgets => is_budget(row),
            Self::Qualities => !is_budget(row) && !is_size(row),
            Self::Sizes => !is_budget(row) && is_size(row) == sized,
        }
    }

    /// The rows of a method that are of this kind.
    pub fn of<'a>(self, rows: impl Iterator<Item = &'a Row> + Clone, method: &str) -> Vec<&'a Row> {
        let own = rows.filter(|r| r.method == method);
        let sized = own.clone().any(is_size);
        own.filter(|r| self.have(r, sized)).collect()
    }
}

/// What is drawn over what, of which rows.
struct Kind {
    name: &'static str,
    x: (&'static str, fn(&Row) -> f64),
    y: (&'static str, fn(&Row) -> f64),
    /// Which runs are shown.
    runs: Runs,
    caption: &'static str,
}

const ERROR: (&str, fn(&Row) -> f64) = ("rel_mse of the picture", |r| r.rel_mse);

const KINDS: [Kind; 4] = [
    Kind {
        name: "error-time",
        x: ("seconds to fill the caches and draw the picture", |r| r.seconds),
        y: ERROR,
        runs: Runs::Budgets,
        caption: "Error against seconds at the time budgets. eas-2015 compares such pictures in Figs. 10 and 11 and in \
                  Table 1; radiance-caching-2005 compares with path tracing at equal time in §5.",
    },
    Kind {
        name: "error-bytes",
        x: ("bytes per glossy record", |r| r.bytes_per_record),
        y: ERROR,
        runs: Runs::Sizes,
        caption: "Error against the memory of a record, all records of a run being of one size, the rest at one τ. \
                  eas-2015, Fig. 8, compares record sizes at equal quality: at n = 100 its EAS take 7.5 times less than \
                  harmonics.",
    },
    Kind {
        name: "error-size",
        x: ("EAS per record, or order of the harmonics", |r| r.size),
        y: ERROR,
        runs: Runs::Sizes,
        caption: "Error against the number of EAS, or the order of the harmonics, the same for all records of a run, the \
                  rest at one τ: eas-2015, Fig. 12 (right), in whose Fig. 7 too the error falls with the number of \
                  EAS; the command “render probe” draws that one for a single record. What is left on the right is \
                  the noise of direct light and of the records.",
    },
    Kind {
        name: "records-time",
        x: ("seconds to fill the caches and draw the picture", |r| r.seconds),
        y: ("records", |r| r.records as f64),
        runs: Runs::Qualities,
        caption: "Records that a quality asks for against the time it takes (eas-2015, Table 1, rows “# glossy rec.” and \
                  “Rendering time”).",
    },
];

/// Whether a row kept to a time budget.
pub fn is_budget(row: &Row) -> bool {
    row.setting.starts_with("time=")
}

/// Whether the size of the records was chosen.
pub fn is_size(row: &Row) -> bool {
    row.setting.starts_with("order=") || row.setting.starts_with("sources=")
}

/// The number that a setting varies; 0 for none.
fn knob(row: &Row) -> f64 {
    let first = row.setting.split(',').next().and_then(|s| s.split_once('='));
    first.and_then(|(_, x)| x.parse().ok()).filter(|x: &f64| !x.is_nan()).unwrap_or(0.0)
}

/// Methods of some rows: known ones in their order, then those of peers by name.
pub fn methods<'a>(rows: impl Iterator<Item = &'a Row>) -> Vec<&'a str> {
    let place = |name: &str| METHODS.iter().position(|m| m.name == name).unwrap_or(METHODS.len());
    let mut names: Vec<&str> = rows.map(|r| r.method.as_str()).collect();
    names.sort_by_key(|n| (place(n), *n));
    names.dedup();
    names
}

/// A colour for each method and its denoised twin, the same in every figure.
fn color(name: &str, foreign: &[&str]) -> RGBColor {
    let plain = METHODS.iter().filter(|m| !m.denoised).count();
    let known =
        METHODS.iter().position(|m| m.name == name).map(|i| METHODS[..i].iter().filter(|m| !m.denoised).count());
    let twin = method::find(name).is_some_and(|m| m.denoised);
    let known = known.map(|i| i - usize::from(twin));
    let index = known.or_else(|| foreign.iter().position(|f| *f == name).map(|i| plain + i));
    PALETTE[index.unwrap_or(0) % PALETTE.len()]
}

/// All figures that have anything to show.
///
/// # Errors
/// A drawing that fails.
pub fn figures<'a>(subject: &Subject, rows: impl Iterator<Item = &'a Row> + Clone) -> Result<Vec<Figure>> {
    let names = methods(rows.clone());
    let foreign: Vec<&str> = names.iter().copied().filter(|n| method::find(n).is_none()).collect();
    let mut figures = Vec::new();
    for kind in &KINDS {
        let mut series = Vec::new();
        for name in &names {
            let mut shown = kind.runs.of(rows.clone(), name);
            let twin = method::find(name).is_some_and(|m| m.denoised);
            // A method without runs of the kind wanted shows what it has; a denoised one is shown over time alone.
            if shown.is_empty() && !twin {
                shown = rows.clone().filter(|r| r.method == **name).collect();
            }
            shown.sort_by(|a, b| knob(a).total_cmp(&knob(b)));
            let mut points: Vec<_> = shown.into_iter().map(|r| ((kind.x.1)(r), (kind.y.1)(r))).collect();
            points.retain(|(x, y)| *x > 0.0 && *y > 0.0);
            if !points.is_empty() {
                let joined = !foreign.contains(name);
                series.push(Series {
                    name: (*name).to_owned(),
                    color: color(name, &foreign),
                    points,
                    joined,
                    dashed: twin,
                });
            }
        }
        if !series.is_empty() {
            let error = kind.y.0 == ERROR.0;
            let floor = subject.reference_noise.filter(|n| error && *n > 0.0).map(|n| (n, "noise of the reference"));
            let axes = Axes { x: kind.x.0, y: kind.y.0, floor };
            figures.push(Figure { name: kind.name, svg: plot(&axes, &series)?, caption: kind.caption });
        }
    }
    Ok(figures)
}
