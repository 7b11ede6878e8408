//! argmin's Gauss-Newton with a backtracking line search.

use argmin::core::IterState;
use argmin::solver::gaussnewton::GaussNewtonLS;
use nalgebra::{DMatrix, DVector};

use super::argmin_view::{View, backtracking};
use super::objective::run;
use super::unbounded::Unbounded;
use super::{Options, Problem, Report, Solver};

/// Gauss-Newton, p ← p − α (JᵀJ)⁻¹ Jᵀr with α halved until the Armijo condition
/// holds. A singular JᵀJ ends the run as a failure.
#[derive(Clone, Copy, Debug, Default)]
pub struct GaussNewton {
    /// Budget and tolerance.
    pub options: Options,
}

impl Solver for GaussNewton {
    fn name(&self) -> &'static str {
        "gauss-newton"
    }

    fn solve(&self, problem: &dyn Problem, start: &[f64], _seed: u64) -> Report {
        run(problem, start, self.options, |objective| {
            let maps = Unbounded::new(problem.bounds());
            let u = DVector::from_vec(maps.inverse(&objective.best().0));
            // The relative test of the view replaces the absolute one of argmin.
            let method = GaussNewtonLS::new(backtracking()).with_tolerance(f64::MIN_POSITIVE).expect("tolerance > 0");
            type Point = IterState<DVector<f64>, DVector<f64>, DMatrix<f64>, (), (), f64>;
            View::new(objective, &maps).run(method, 1, |state: Point| state.param(u))
        })
    }
}
