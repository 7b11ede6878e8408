//! The methods of a chart and their settings.

use super::bench::Bench;
use super::monte_carlo::MonteCarlo;
use super::{Chart, Curve, Point};
use anyhow::Context;
use brdf_tables::brdf::Specular;
use brdf_tables::cubature::{Cubature, RULES, Rule};
use brdf_tables::material::Material;
use brdf_tables::mean::Exact;
use brdf_tables::table::{Representation, Table};
use core::ops::ControlFlow;
use fitter::fit::{Choice, Options, TOLERANCE, fit};
use fitter::solver::SolverKind;
use fitter::zonal;

/// Sizes of the zonal table.
const ZONAL: [(usize, usize); 7] = [(6, 4), (8, 6), (12, 8), (16, 12), (24, 16), (48, 32), (96, 64)];
/// Tolerances of the cubature whose rule varies from cell to cell.
const FITTED: [f64; 4] = [0.02, 0.005, 0.001, 0.0003];
/// Tolerances of the exact quadrature.
const EXACT: [f64; 3] = [0.1, 0.001, 0.00001];
/// Samples of Monte Carlo.
const SAMPLES: [usize; 4] = [32, 128, 512, 2048];

/// What to chart.
pub struct Measurement<'a> {
    /// Material with a specular part.
    pub material: Material,
    /// Solvers of the lobe curves.
    pub solvers: &'a [SolverKind],
    /// Lobe curves go from one lobe to this many.
    pub lobes: usize,
    /// Caps at which errors are measured.
    pub points: usize,
    /// Seed of the caps and of the solvers.
    pub seed: u64,
    /// Told the fraction done.
    pub progress: &'a dyn Fn(f64),
    /// Told the name of each curve as it begins.
    pub step: &'a dyn Fn(&str),
}

/// Measures the points of a curve.
type Method<'a> = Box<dyn Fn(&Bench) -> anyhow::Result<Vec<Point>> + 'a>;

/// Measures every method.
///
/// # Errors
/// The material has no specular part, or cannot be fitted.
pub fn measure(what: &Measurement) -> anyhow::Result<Chart> {
    let specular = what.material.specular.context("a diffuse material")?;
    let mut methods: Vec<(String, Method)> = Vec::new();
    let radial = specular.radial_exponent().is_some();
    if radial {
        methods.push(("zonal".into(), Box::new(move |bench| Ok(zonal_points(bench, specular)))));
    }
    methods.push(("disc rules (no table)".into(), Box::new(move |bench| Ok(rule_points(bench, specular, true)))));
    methods.push(("product rules (no table)".into(), Box::new(move |bench| Ok(rule_points(bench, specular, false)))));
    methods.push(("cubature table".into(), Box::new(|bench| fitted_points(bench, what))));
    for &solver in what.solvers {
        methods.push((format!("lobes {solver}"), Box::new(move |b| lobe_points(b, what, Choice::Lobes, solver))));
    }
    if specular.is_isotropic() {
        let solver = SolverKind::LevenbergMarquardt;
        methods.push(("paper".into(), Box::new(move |b| lobe_points(b, what, Choice::Paper, solver))));
    }
    methods.push(("exact quadrature".into(), Box::new(move |bench| Ok(exact_points(bench, specular)))));
    methods.push(("Monte Carlo".into(), Box::new(move |bench| Ok(sampled_points(bench, specular, what.seed)))));

    (what.step)("reference");
    let bench = Bench::new(&specular, what.points, what.seed);
    let mut curves = Vec::new();
    let all = methods.len() + 1;
    for (i, (name, points)) in methods.into_iter().enumerate() {
        (what.progress)((i + 1) as f64 / all as f64);
        (what.step)(&name);
        curves.push(Curve { points: points(&bench)?, name });
    }
    Ok(Chart { material: what.material.to_string(), curves })
}

fn zonal_points(bench: &Bench, specular: Specular) -> Vec<Point> {
    let tables =
        ZONAL.iter().filter_map(|&(rows, columns)| Some((rows, columns, zonal::build(specular, rows, columns)?)));
    tables
        .map(|(rows, columns, table)| bench.point(format!("{rows}×{columns}"), &table, Some(4 * rows * columns)))
        .collect()
}

/// Rules of one kind, each used for every cap.
fn rule_points(bench: &Bench, specular: Specular, discs: bool) -> Vec<Point> {
    let of_a_kind = RULES.into_iter().filter(|rule| matches!(rule, Rule::Disc(_)) == discs);
    of_a_kind.map(|rule| bench.point(rule.to_string(), &Cubature::uniform(specular, rule), None)).collect()
}

fn exact_points(bench: &Bench, specular: Specular) -> Vec<Point> {
    let point = |tolerance| bench.point(format!("{tolerance:e}"), &Exact { specular, tolerance }, None);
    EXACT.map(point).into()
}

fn sampled_points(bench: &Bench, specular: Specular, seed: u64) -> Vec<Point> {
    let point = |samples| bench.point(format!("{samples} spp"), &MonteCarlo { specular, samples, seed }, None);
    SAMPLES.map(point).into()
}

/// Cubature with its rule chosen per cell, at several tolerances.
fn fitted_points(bench: &Bench, what: &Measurement) -> anyhow::Result<Vec<Point>> {
    let point = |&tolerance: &f64| {
        let table = fitted(what, Choice::Cubature, SolverKind::LevenbergMarquardt, None, tolerance)?;
        table_point(bench, format!("{} %", 100.0 * tolerance), &table)
    };
    FITTED.iter().map(point).collect()
}

/// Lobes fitted by a solver, by their number.
fn lobe_points(bench: &Bench, what: &Measurement, choice: Choice, solver: SolverKind) -> anyhow::Result<Vec<Point>> {
    let point = |lobes| {
        let table = fitted(what, choice, solver, Some(lobes), TOLERANCE)?;
        table_point(bench, format!("K={lobes}"), &table)
    };
    (1..=what.lobes).map(point).collect()
}

fn fitted(
    what: &Measurement,
    representation: Choice,
    solver: SolverKind,
    lobes: Option<usize>,
    tolerance: f64,
) -> anyhow::Result<Table> {
    let (command, progress) = (String::new(), &|_| ControlFlow::Continue(()));
    let options = Options { representation, solver, lobes, tolerance, seed: what.seed, command, progress };
    Ok(fit(&what.material, &options)?)
}

fn table_point(bench: &Bench, label: String, table: &Table) -> anyhow::Result<Point> {
    let bytes = match &table.representation {
        Representation::Diffuse => 0,
        Representation::Zonal(t) => size_of_val(t.parts().2),
        Representation::Cubature(t) => size_of_val(t.parts().1),
        Representation::Lobes(t) => size_of_val(t.parts().2),
        Representation::Paper(t) => size_of_val(t.parts().3),
    };
    Ok(bench.point(label, table.mean().context("a diffuse table")?, Some(bytes)))
}
