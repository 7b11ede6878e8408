//! argmin's BFGS with a backtracking line search.

use argmin::core::{IterState, Jacobian};
use argmin::solver::quasinewton::BFGS;
use nalgebra::{DMatrix, DVector};

use super::argmin_view::{View, backtracking};
use super::objective::run;
use super::unbounded::Unbounded;
use super::{Options, Problem, Report, Solver, Stop};

/// Damping of the first Hessian, relative to its diagonal.
const DAMPING: f64 = 1e-3;

/// BFGS with α halved until the Armijo condition holds. The first inverse
/// Hessian is that of damped Gauss-Newton: from the identity the first step
/// leaves the region where the lobes overlap their target.
#[derive(Clone, Copy, Debug, Default)]
pub struct Bfgs {
    /// Budget and tolerance.
    pub options: Options,
}

impl Solver for Bfgs {
    fn name(&self) -> &'static str {
        "bfgs"
    }

    fn solve(&self, problem: &dyn Problem, start: &[f64], _seed: u64) -> Report {
        run(problem, start, self.options, |objective| {
            let maps = Unbounded::new(problem.bounds());
            let view = View::new(objective, &maps);
            loop {
                let (p, before) = objective.best();
                let u = maps.inverse(&p);
                let inverse = match view.jacobian(&DVector::from_column_slice(&u)) {
                    Ok(jacobian) => inverse_hessian(&jacobian),
                    Err(error) => return Stop::Failure(error.to_string()),
                };
                // The relative test of the view replaces the absolute one of argmin.
                let method = BFGS::new(backtracking())
                    .with_tolerance_grad(1e-12)
                    .and_then(|method| method.with_tolerance_cost(0.0))
                    .expect("tolerances >= 0");
                type Point = IterState<Vec<f64>, Vec<f64>, (), Vec<Vec<f64>>, (), f64>;
                let stop = view.run(method, 1, |state: Point| state.param(u).inv_hessian(inverse));
                // Without the curvature condition the matrix may have become
                // useless: begin anew as long as that helps.
                if stop != Stop::NoProgress || objective.best().1 == before {
                    return stop;
                }
            }
        })
    }
}

/// (JᵀJ + 10⁻³ diag JᵀJ)⁻¹, or the identity where a column is zero.
fn inverse_hessian(jacobian: &DMatrix<f64>) -> Vec<Vec<f64>> {
    let mut hessian = jacobian.tr_mul(jacobian);
    let n = hessian.nrows();
    for i in 0..n {
        hessian[(i, i)] *= 1.0 + DAMPING;
    }
    let inverse = hessian.cholesky().map_or_else(|| DMatrix::identity(n, n), |c| c.inverse());
    inverse.row_iter().map(|row| row.iter().copied().collect()).collect()
}
