//! The table as published in 2015 (Algorithm 2): positive lobes, the published grid.

use super::cell::{Ansatz, CellFit};
use super::lobes::{describe, solver_options, target};
use super::{FitError, Fitted, Options, oracle};
use crate::solver::SolverKind;
use brdf_tables::brdf::Specular;
use brdf_tables::lobe::Lobe;
use brdf_tables::paper::Paper;
use brdf_tables::table::Representation;
use core::f64::consts::FRAC_PI_2;
use glam::DVec3;
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

/// #H. The paper gives no number; with 16 rows θe = 45° is one.
const ELEVATIONS: usize = 16;
/// #AS. With 64 the first solid angle at 45° is below π/100, the smallest of the paper's four cases.
const SOLID_ANGLES: usize = 64;
/// Lobes per cell unless asked for otherwise. More fit a cell better and the table worse: interpolated coefficients need
/// the lobes of neighbours in one order, which nothing provides (measured: 0.07 % with one, 2 % with two at π/30, n = 40).
const LOBES: usize = 1;

/// Fits the table.
pub(super) fn fit(specular: &Specular, options: &Options) -> Result<Fitted, FitError> {
    let count = options.lobes.unwrap_or(LOBES);
    let ansatz = Ansatz { in_plane: true, signed: false };
    let solver = options.solver.with(solver_options(options.solver));
    let thorough = options.solver == SolverKind::LevenbergMarquardt;
    let oracle = oracle(*specular);
    let done = AtomicUsize::new(0);
    let rows: Vec<Vec<CellFit>> = (1..=ELEVATIONS)
        .into_par_iter()
        .map(|e| {
            let mut cells: Vec<CellFit> = Vec::with_capacity(SOLID_ANGLES);
            for j in 1..=SOLID_ANGLES {
                let cap = Paper::cap_at(ELEVATIONS, SOLID_ANGLES, e, j);
                let (target, _) = target(&oracle, specular, &cap);
                let warm = cells.last().map_or(&[][..], |c| &c.lobes);
                let seed = options.seed ^ (e * SOLID_ANGLES + j) as u64;
                cells.push(target.fit(ansatz, count, warm, &*solver, (thorough, seed), |_| false));
                let all = (ELEVATIONS * SOLID_ANGLES) as f64;
                options.tell(0.9 * (done.fetch_add(1, Ordering::Relaxed) + 1) as f64 / all)?;
            }
            Ok(cells)
        })
        .collect::<Result<_, FitError>>()?;
    let cells: Vec<CellFit> = rows.into_iter().flatten().collect();
    let to_surface = |e: usize, lobe: &Lobe| {
        // Mirror frame back to the frame where the cap has azimuth 0.
        let (s, c) = (FRAC_PI_2 * e as f64 / ELEVATIONS as f64).sin_cos();
        let a = lobe.axis;
        Lobe { axis: DVec3::new(a.x * c - a.z * s, a.y, a.x * s + a.z * c), ..*lobe }
    };
    let lobes: Vec<Vec<Lobe>> = cells
        .iter()
        .enumerate()
        .map(|(i, cell)| cell.lobes.iter().map(|lobe| to_surface(i / SOLID_ANGLES + 1, lobe)).collect())
        .collect();
    let table = Paper::from_cells(ELEVATIONS, SOLID_ANGLES, count, &lobes).map_err(|_| FitError::Diverged)?;
    Ok(Fitted { representation: Representation::Paper(table), notes: vec![describe(options.solver, &cells)] })
}
