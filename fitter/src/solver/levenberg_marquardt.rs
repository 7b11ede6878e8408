//! Levenberg–Marquardt with bounds, as a solver of argmin.

use argmin::core::{
    Error, Executor, IterState, KV, Problem as ArgminProblem, Solver as ArgminSolver, State, TerminationReason,
    TerminationStatus,
};

use super::model::Model;
use super::objective::{BudgetSpent, Objective, project, run, stop_of};
use super::{Options, Problem, Report, Solver, Stop};

/// First damping relative to the diagonal of JᵀJ.
const INITIAL_DAMPING: f64 = 1e-3;
/// Damping below which the damped matrix is the undamped one in floating point.
const MIN_DAMPING: f64 = 1e-18;
/// Damping beyond which no step is left to shorten.
const MAX_DAMPING: f64 = 1e24;
const GRADIENT_TOLERANCE: f64 = 1e-10;
const STEP_TOLERANCE: f64 = 1e-12;
/// How many times better the other model must predict to be used instead.
/// Measured on fits of 1 to 6 lobes: 1 takes half as many steps again.
const MODEL_SWITCH: f64 = 4.0;

/// Levenberg–Marquardt: (JᵀJ + μD) h = −Jᵀr, or (JᵀJ + S + μD) h = −Jᵀr with the
/// secant term S of NL2SOL when that predicts the cost better.
///
/// D is the largest diagonal of JᵀJ so far (Marquardt 1963; Moré 1978), μ
/// follows the gain ratio (Nielsen, IMM-REP-1999-05): an accepted step
/// multiplies it by max(1/3, 1 − (2ρ − 1)³), each rejected one by 2, 4, 8, ….
/// Parameters on a bound that the gradient pushes outwards are held, the
/// others' step is projected onto the bounds.
#[derive(Clone, Copy, Debug, Default)]
pub struct LevenbergMarquardt {
    /// Budget and tolerance.
    pub options: Options,
}

impl Solver for LevenbergMarquardt {
    fn name(&self) -> &'static str {
        "lm"
    }

    fn solve(&self, problem: &dyn Problem, start: &[f64], _seed: u64) -> Report {
        run(problem, start, self.options, minimise)
    }
}

/// Runs from the best point of the objective so far.
pub(super) fn minimise(objective: &Objective) -> Stop {
    let (start, cost) = objective.best();
    let finished = Executor::new(objective, Iteration::new(objective))
        .configure(|state| state.param(start).cost(cost))
        .ctrlc(false)
        .run();
    match finished {
        Ok(result) => result.solver.stop.unwrap_or(Stop::NoProgress),
        Err(error) => stop_of(&error),
    }
}

type Point = IterState<Vec<f64>, (), (), (), (), f64>;

/// The state of the method beside the point: buffers used again and again.
struct Iteration {
    residuals: Vec<f64>,
    jacobian: Vec<f64>,
    trial_residuals: Vec<f64>,
    trial_jacobian: Vec<f64>,
    model: Model,
    /// Marquardt's scaling D.
    scale: Vec<f64>,
    /// Parameters that no bound holds.
    free: Vec<bool>,
    step: Vec<f64>,
    trial: Vec<f64>,
    damping: f64,
    /// Factor of the next increase of the damping, 2 after an accepted step.
    growth: f64,
    stop: Option<Stop>,
}

impl Iteration {
    fn new(objective: &Objective) -> Self {
        let (n, m) = (objective.problem.parameters(), objective.problem.residual_count());
        Self {
            residuals: vec![0.0; m],
            jacobian: vec![0.0; n * m],
            trial_residuals: vec![0.0; m],
            trial_jacobian: vec![0.0; n * m],
            model: Model::new(n),
            scale: vec![0.0; n],
            free: vec![true; n],
            step: vec![0.0; n],
            trial: vec![0.0; n],
            damping: INITIAL_DAMPING,
            growth: 2.0,
            stop: None,
        }
    }

    /// Takes the Jacobian and residuals in the buffers as those at `p`.
    fn linearise(&mut self, objective: &Objective, p: &[f64], cost: f64) {
        self.model.assemble(&self.jacobian, &self.residuals);
        let mut steepest: f64 = 0.0;
        for (i, &(lo, hi)) in objective.problem.bounds().iter().enumerate() {
            let (g, square) = (self.model.gradient[i], self.model.diagonal(i));
            self.scale[i] = self.scale[i].max(square);
            self.free[i] = !(p[i] <= lo && g >= 0.0 || p[i] >= hi && g <= 0.0);
            if self.free[i] && square > 0.0 {
                steepest = steepest.max(g.abs() / (2.0 * cost * square).sqrt());
            }
        }
        if objective.is_perfect(cost) {
            self.stop = Some(Stop::CostTolerance);
        } else if steepest <= GRADIENT_TOLERANCE {
            self.stop = Some(Stop::GradientTolerance);
        }
    }

    /// One trial step from `p`; moves `p` and `cost` if it is accepted.
    fn advance(&mut self, objective: &Objective, p: &mut [f64], cost: &mut f64) -> Result<(), BudgetSpent> {
        let tolerance = objective.options.cost_tolerance;
        // Solve for the step and project it onto the bounds.
        let solved = self.model.solve(self.damping, &self.scale, &self.free, &mut self.step);
        if !solved || self.step.iter().any(|h| !h.is_finite()) {
            self.shorten();
            return Ok(());
        }
        for ((trial, x), h) in self.trial.iter_mut().zip(p.iter()).zip(&self.step) {
            *trial = x + h;
        }
        project(&mut self.trial, objective.problem.bounds());
        for ((h, trial), x) in self.step.iter_mut().zip(&self.trial).zip(p.iter()) {
            *h = trial - x;
        }
        let first = self.growth == 2.0;
        if first && norm(&self.step) <= STEP_TOLERANCE * (norm(p) + STEP_TOLERANCE) {
            self.stop = Some(Stop::StepTolerance);
            return Ok(());
        }
        // The projection may have turned the step uphill.
        let predictions = self.model.predicted_decrease(&self.step);
        let predicted = predictions[usize::from(self.model.secant)];
        if predicted.is_nan() || predicted <= 0.0 {
            self.shorten();
            return Ok(());
        }

        // Most first trials are accepted, most second ones follow a rejection
        // and are not: only the former get their Jacobian at once.
        let (r, j) = (&mut self.trial_residuals, &mut self.trial_jacobian);
        let mut trial_cost =
            if first { objective.evaluate(&self.trial, r, j)? } else { objective.residuals(&self.trial, r)? };
        let decrease = *cost - trial_cost;
        // Next time use the other model if that predicted clearly better.
        let errors = predictions.map(|prediction| (prediction - decrease).abs());
        let (own, other) = (usize::from(self.model.secant), usize::from(!self.model.secant));
        if MODEL_SWITCH * errors[other] < errors[own] {
            self.model.secant = !self.model.secant;
        }
        let stalled = predicted <= tolerance * *cost && decrease.abs() <= tolerance * *cost;
        if !first && decrease > 0.0 && !objective.jacobian(&self.trial, j) {
            trial_cost = f64::INFINITY;
        }
        if trial_cost < *cost {
            // Accept; trust the model as far as it predicted well.
            let gain = decrease / predicted;
            let factor = (1.0 - (2.0 * gain - 1.0).powi(3)).max(1.0 / 3.0);
            self.damping = (self.damping * factor).max(MIN_DAMPING);
            self.growth = 2.0;
            p.copy_from_slice(&self.trial);
            *cost = trial_cost;
            std::mem::swap(&mut self.residuals, &mut self.trial_residuals);
            std::mem::swap(&mut self.jacobian, &mut self.trial_jacobian);
            self.linearise(objective, p, *cost);
            self.model.learn(&self.step, &self.trial_jacobian, &self.residuals);
        } else {
            self.shorten();
        }
        if stalled {
            self.stop = Some(Stop::CostTolerance);
        }
        Ok(())
    }

    /// Increases the damping after a step that failed.
    fn shorten(&mut self) {
        self.damping *= self.growth;
        self.growth *= 2.0;
        if self.damping > MAX_DAMPING {
            self.stop = Some(Stop::NoProgress);
        }
    }
}

fn norm(x: &[f64]) -> f64 {
    x.iter().map(|x| x * x).sum::<f64>().sqrt()
}

impl<'a> ArgminSolver<&'a Objective<'a>, Point> for Iteration {
    fn name(&self) -> &str {
        "Levenberg-Marquardt"
    }

    fn init(
        &mut self,
        problem: &mut ArgminProblem<&'a Objective<'a>>,
        state: Point,
    ) -> Result<(Point, Option<KV>), Error> {
        let p = state.get_param().map_or(&[][..], Vec::as_slice);
        problem.problem("jacobian_count", |objective| {
            let cost = objective.residuals(p, &mut self.residuals)?;
            if objective.jacobian(p, &mut self.jacobian) {
                self.linearise(objective, p, cost);
            } else {
                self.stop = Some(Stop::Failure("Jacobian not finite".into()));
            }
            Ok(())
        })?;
        Ok((state, None))
    }

    fn next_iter(
        &mut self,
        problem: &mut ArgminProblem<&'a Objective<'a>>,
        mut state: Point,
    ) -> Result<(Point, Option<KV>), Error> {
        let (mut p, mut cost) = (state.take_param().unwrap_or_default(), state.get_cost());
        problem.problem("residuals_count", |objective| {
            objective.iterations.set(objective.iterations.get() + 1);
            Ok(self.advance(objective, &mut p, &mut cost)?)
        })?;
        Ok((state.param(p).cost(cost), None))
    }

    fn terminate(&mut self, _state: &Point) -> TerminationStatus {
        match &self.stop {
            Some(stop) => TerminationStatus::Terminated(TerminationReason::SolverExit(stop.to_string())),
            None => TerminationStatus::NotTerminated,
        }
    }
}
