//! argmin's own solvers on an [`Objective`]: the traits they ask for, and the
//! stopping tests they lack.

use argmin::core::{
    CostFunction, Error, Executor, Gradient, Jacobian, KV, Operator, OptimizationResult as Finished, Problem,
    Solver as ArgminSolver, State, TerminationReason, TerminationStatus,
};
use argmin::solver::linesearch::BacktrackingLineSearch;
use argmin::solver::linesearch::condition::ArmijoCondition;
use nalgebra::{DMatrix, DVector};

use super::Stop;
use super::objective::{Objective, stop_of};
use super::unbounded::Unbounded;

#[derive(Debug, thiserror::Error)]
enum NotFinite {
    #[error("Jacobian not finite")]
    Jacobian,
    /// Not a fault of the problem: a line search would halve NaN for ever.
    #[error("search direction not finite")]
    Direction,
}

/// The objective in the free variables of [`Unbounded`], residuals divided by
/// the norm of those at the start: argmin's tolerances and the Armijo condition
/// inside its Gauss-Newton are absolute.
#[derive(Clone, Copy)]
pub(super) struct View<'a> {
    pub objective: &'a Objective<'a>,
    maps: &'a Unbounded,
    scale: f64,
}

impl<'a> View<'a> {
    pub fn new(objective: &'a Objective<'a>, maps: &'a Unbounded) -> Self {
        let cost = objective.best().1;
        let scale = if cost > 0.0 { (2.0 * cost).sqrt().recip() } else { 1.0 };
        Self { objective, maps, scale }
    }

    /// The parameters that `u` stands for.
    fn point(&self, u: &[f64]) -> Result<Vec<f64>, Error> {
        if u.iter().all(|x| x.is_finite()) { Ok(self.maps.forward(u)) } else { Err(NotFinite::Direction.into()) }
    }

    fn residuals(&self, u: &[f64]) -> Result<Vec<f64>, Error> {
        let mut r = vec![0.0; self.objective.problem.residual_count()];
        self.objective.residuals(&self.point(u)?, &mut r)?;
        r.iter_mut().for_each(|x| *x *= self.scale);
        Ok(r)
    }

    /// ∂r/∂u, row-major.
    fn derivatives(&self, u: &[f64]) -> Result<Vec<f64>, Error> {
        let mut j = vec![0.0; self.objective.problem.residual_count() * u.len()];
        if !self.objective.jacobian(&self.point(u)?, &mut j) {
            return Err(NotFinite::Jacobian.into());
        }
        let slope = self.maps.slope(u);
        for row in j.chunks_exact_mut(u.len()) {
            for (x, s) in row.iter_mut().zip(&slope) {
                *x *= s * self.scale;
            }
        }
        Ok(j)
    }

    /// Runs one of argmin's solvers to its end.
    pub fn run<S, I>(self, solver: S, window: usize, state: impl FnOnce(I) -> I) -> Stop
    where
        S: ArgminSolver<Self, I>,
        I: State<Float = f64>,
    {
        let watched = Watched { solver, objective: self.objective, window, reference: f64::INFINITY, stop: None };
        match Executor::new(self, watched).configure(state).ctrlc(false).run() {
            Ok(Finished { solver: Watched { stop: Some(stop), .. }, .. }) => stop,
            Ok(result) => match result.state.get_termination_reason() {
                Some(TerminationReason::SolverConverged) => Stop::GradientTolerance,
                Some(reason) => Stop::Failure(reason.text().to_lowercase()),
                None => Stop::NoProgress,
            },
            Err(error) => stop_of(&error),
        }
    }
}

impl CostFunction for View<'_> {
    type Param = Vec<f64>;
    type Output = f64;

    fn cost(&self, u: &Vec<f64>) -> Result<f64, Error> {
        let cost = self.objective.cost(&self.point(u)?)?;
        Ok(cost * self.scale * self.scale)
    }
}

impl Gradient for View<'_> {
    type Param = Vec<f64>;
    type Gradient = Vec<f64>;

    fn gradient(&self, u: &Vec<f64>) -> Result<Vec<f64>, Error> {
        let (r, j) = (self.residuals(u)?, self.derivatives(u)?);
        let mut gradient = vec![0.0; u.len()];
        for (r, row) in r.iter().zip(j.chunks_exact(u.len())) {
            for (g, x) in gradient.iter_mut().zip(row) {
                *g += r * x;
            }
        }
        Ok(gradient)
    }
}

impl Operator for View<'_> {
    type Param = DVector<f64>;
    type Output = DVector<f64>;

    fn apply(&self, u: &DVector<f64>) -> Result<DVector<f64>, Error> {
        Ok(DVector::from_vec(self.residuals(u.as_slice())?))
    }
}

impl Jacobian for View<'_> {
    type Param = DVector<f64>;
    type Jacobian = DMatrix<f64>;

    fn jacobian(&self, u: &DVector<f64>) -> Result<DMatrix<f64>, Error> {
        let j = self.derivatives(u.as_slice())?;
        Ok(DMatrix::from_row_slice(j.len() / u.len(), u.len(), &j))
    }
}

/// A solver that also stops when the best cost is as good as zero, or falls by
/// no more than the relative tolerance within `window` iterations.
struct Watched<'a, S> {
    solver: S,
    objective: &'a Objective<'a>,
    window: usize,
    reference: f64,
    stop: Option<Stop>,
}

impl<O, I, S> ArgminSolver<O, I> for Watched<'_, S>
where
    I: State<Float = f64>,
    S: ArgminSolver<O, I>,
{
    fn name(&self) -> &str {
        self.solver.name()
    }

    fn init(&mut self, problem: &mut Problem<O>, state: I) -> Result<(I, Option<KV>), Error> {
        let initialised = self.solver.init(problem, state)?;
        self.reference = self.objective.best().1;
        Ok(initialised)
    }

    fn next_iter(&mut self, problem: &mut Problem<O>, state: I) -> Result<(I, Option<KV>), Error> {
        let iterations = self.objective.iterations.get() + 1;
        self.objective.iterations.set(iterations);
        let next = self.solver.next_iter(problem, state)?;
        if iterations.is_multiple_of(self.window) {
            let cost = self.objective.best().1;
            let decrease = self.reference - cost;
            self.reference = cost;
            if self.objective.is_perfect(cost) {
                self.stop = Some(Stop::CostTolerance);
            } else if decrease == 0.0 {
                self.stop = Some(Stop::NoProgress);
            } else if decrease <= self.objective.options.cost_tolerance * cost {
                self.stop = Some(Stop::CostTolerance);
            }
        }
        Ok(next)
    }

    fn terminate(&mut self, state: &I) -> TerminationStatus {
        if self.stop.is_some() {
            return TerminationStatus::Terminated(TerminationReason::SolverConverged);
        }
        self.solver.terminate(state)
    }
}

/// A line search that halves the step until the Armijo condition holds.
pub(super) fn backtracking<P, G>() -> BacktrackingLineSearch<P, G, ArmijoCondition<f64>, f64> {
    let armijo = ArmijoCondition::new(1e-4).expect("0 < c < 1");
    BacktrackingLineSearch::new(armijo).rho(0.5).expect("0 < rho < 1")
}
