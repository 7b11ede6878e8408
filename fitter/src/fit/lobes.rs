//! The sweep of the lobe table: signed lobes over a grid that includes θe = 0 and Ω = 0.

use super::cell::{Ansatz, CellFit, Target};
use super::{FitError, Fitted, Options, oracle, values};
use crate::error::Directions;
use crate::solver::{self, SolverKind};
use brdf_tables::axis::Axes;
use brdf_tables::brdf::Specular;
use brdf_tables::cap::Cap;
use brdf_tables::cubature::Cubature;
use brdf_tables::lobe::Lobe;
use brdf_tables::lobes::{Lobes, into_mirror_frame};
use brdf_tables::table::Representation;
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

/// The exact F of a cell, ready for a fit, and the directions it was taken at.
pub(super) fn target(oracle: &Cubature, specular: &Specular, cap: &Cap) -> (Target, Directions) {
    let directions = Directions::new(specular, cap);
    let exact = values(oracle, cap, &directions);
    let peak = exact.iter().fold(0f64, |m, &f| m.max(f)).max(f64::MIN_POSITIVE);
    let local = directions.wo.iter().map(|&wo| into_mirror_frame(cap.axis(), wo)).collect();
    (Target { directions: local, weights: directions.weight.clone(), values: exact, peak }, directions)
}

/// Residual evaluations per run: Levenberg–Marquardt never needs as many, the global solvers spend them.
pub(super) fn solver_options(kind: SolverKind) -> solver::Options {
    let evaluations = if kind == SolverKind::LevenbergMarquardt { 400 } else { 1000 };
    solver::Options { evaluations, cost_tolerance: 1e-6 }
}

/// Line about what the solver did over all cells.
pub(super) fn describe(kind: SolverKind, cells: &[CellFit]) -> String {
    let evaluations: usize = cells.iter().map(|c| c.evaluations).sum();
    let lobes: usize = cells.iter().map(|c| c.lobes.len()).sum();
    let stopped = cells.iter().filter(|c| c.report.stop.converged()).count();
    let mean = lobes as f64 / cells.len() as f64;
    format!("{kind}: {mean:.1} lobes per cell, {evaluations} evaluations, {stopped} of {} cells converged", cells.len())
}

/// Fits the table.
pub(super) fn fit(specular: &Specular, options: &Options) -> Result<Fitted, FitError> {
    let isotropic = specular.is_isotropic();
    let axes = Axes {
        theta: if isotropic { 16 } else { 10 },
        phi: if isotropic { 1 } else { 5 },
        omega: if isotropic { 16 } else { 10 },
        sharpness: specular.lobe_width().powi(-2),
        stretch: 1.0,
    };
    let most = options.lobes.unwrap_or(if isotropic { 6 } else { 8 });
    let ansatz = Ansatz { in_plane: isotropic, signed: true };
    let solver = options.solver.with(solver_options(options.solver));
    let thorough = options.solver == SolverKind::LevenbergMarquardt;
    let oracle = oracle(*specular);
    let done = AtomicUsize::new(0);
    let (np, no) = (axes.phi as usize, axes.omega as usize);

    // Rows of constant (θe, φe) in parallel; along a row each cell starts from the one before.
    let rows: Vec<Vec<CellFit>> = (0..axes.theta as usize * np)
        .into_par_iter()
        .map(|row| {
            let mut cells: Vec<CellFit> = Vec::with_capacity(no);
            for omega in 0..no {
                let cap = axes.cap_at(row / np, row % np, omega);
                let (target, directions) = target(&oracle, specular, &cap);
                let good = |lobes: &[Lobe]| {
                    let fitted: Vec<f64> =
                        target.directions.iter().map(|&w| lobes.iter().map(|l| l.value(w)).sum::<f64>()).collect();
                    options.lobes.is_none()
                        && f64::from(directions.errors(&target.values, &fitted).rmse_lobe) <= 0.5 * options.tolerance
                };
                let warm = cells.last().map_or(&[][..], |c| &c.lobes);
                let seed = options.seed ^ axes.index(row / np, row % np, omega) as u64;
                let mut cell = target.fit(ansatz, most, warm, &*solver, (thorough, seed), good);
                conserve_energy(&mut cell.lobes, &target, &directions);
                cells.push(cell);
                options.tell(0.9 * (done.fetch_add(1, Ordering::Relaxed) + 1) as f64 / axes.len() as f64)?;
            }
            Ok(cells)
        })
        .collect::<Result<_, FitError>>()?;
    let cells: Vec<CellFit> = rows.into_iter().flatten().collect();
    let nodes: Vec<Vec<Lobe>> = cells.iter().map(|c| c.lobes.clone()).collect();
    let table = Lobes::from_nodes(axes, &nodes).map_err(|_| FitError::Diverged)?;
    Ok(Fitted { representation: Representation::Lobes(table), notes: vec![describe(options.solver, &cells)] })
}

/// Scales the amplitudes so that the reflected energy ∫F cosθo is exact, where the fit is near enough for that to help.
fn conserve_energy(lobes: &mut [Lobe], target: &Target, directions: &Directions) {
    let (mut exact, mut fitted) = (0.0, 0.0);
    for (i, w) in target.directions.iter().enumerate() {
        let cos = directions.weight[i] * directions.wo[i].z;
        exact += cos * target.values[i];
        fitted += cos * lobes.iter().map(|lobe| lobe.value(*w)).sum::<f64>().max(0.0);
    }
    if (fitted / exact - 1.0).abs() < 0.02 {
        lobes.iter_mut().for_each(|lobe| lobe.amplitude *= exact / fitted);
    }
}
