//! The genetic algorithm to find the valley, Levenberg–Marquardt to descend it.

use super::objective::run;
use super::{Options, Problem, Report, Solver, genetic, levenberg_marquardt};

/// [`Genetic`](super::Genetic) with three quarters of the budget at most, then
/// [`LevenbergMarquardt`](super::LevenbergMarquardt) from its best individual.
/// The report tells why the latter stopped.
#[derive(Clone, Copy, Debug, Default)]
pub struct GeneticPolished {
    /// Budget and tolerance, of both together.
    pub options: Options,
}

impl Solver for GeneticPolished {
    fn name(&self) -> &'static str {
        "ga-lm"
    }

    fn solve(&self, problem: &dyn Problem, start: &[f64], seed: u64) -> Report {
        run(problem, start, self.options, |objective| {
            genetic::evolve(objective, seed, self.options.evaluations / 4);
            levenberg_marquardt::minimise(objective)
        })
    }
}
