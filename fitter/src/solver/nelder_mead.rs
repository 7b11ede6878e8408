//! argmin's Nelder–Mead, restarted.

use argmin::core::IterState;
use argmin::solver::neldermead::NelderMead as ArgminNelderMead;

use super::argmin_view::View;
use super::objective::run;
use super::unbounded::Unbounded;
use super::{Options, Problem, Report, Solver, Stop};

/// Edge of the simplex in the free variables, a tenth of the box for a bounded
/// parameter, and relative to |u| for the others.
const EDGE: f64 = 0.3;

/// Nelder–Mead's simplex; it needs no derivatives. It may collapse onto a point
/// that is no minimum, so a fresh simplex is set up around the result until
/// that gains nothing.
#[derive(Clone, Copy, Debug, Default)]
pub struct NelderMead {
    /// Budget and tolerance.
    pub options: Options,
}

impl Solver for NelderMead {
    fn name(&self) -> &'static str {
        "nelder-mead"
    }

    fn solve(&self, problem: &dyn Problem, start: &[f64], _seed: u64) -> Report {
        run(problem, start, self.options, |objective| {
            let maps = Unbounded::new(problem.bounds());
            let mut edge = EDGE;
            loop {
                let (p, before) = objective.best();
                // argmin's set-up of the simplex cannot pass an error on.
                if objective.remaining() <= p.len() {
                    return Stop::Budget;
                }
                let vertices = simplex(&maps.inverse(&p), edge);
                let method = ArgminNelderMead::new(vertices).with_sd_tolerance(0.0).expect("tolerance >= 0");
                type Point = IterState<Vec<f64>, (), (), (), (), f64>;
                let stop = View::new(objective, &maps).run(method, 20 * (p.len() + 1), |state: Point| state);

                let cost = objective.best().1;
                let collapsed = matches!(stop, Stop::CostTolerance | Stop::NoProgress);
                if !collapsed || objective.is_perfect(cost) {
                    return stop;
                }
                if before - cost <= self.options.cost_tolerance * before {
                    return Stop::CostTolerance;
                }
                // The other side of each axis, in case of a ridge.
                edge = -edge;
            }
        })
    }
}

/// `u` and its neighbours along each axis.
fn simplex(u: &[f64], edge: f64) -> Vec<Vec<f64>> {
    let vertex = |i: usize| {
        let mut v = u.to_vec();
        v[i] += edge * v[i].abs().max(1.0);
        v
    };
    std::iter::once(u.to_vec()).chain((0..u.len()).map(vertex)).collect()
}
