//! The problem as every solver sees it: counted, limited, remembered.

use std::cell::{Cell, RefCell};
use std::time::Instant;

use super::{Options, Problem, Report, Stop};

/// Ends a run from inside a callback; argmin hands it through as an error.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("budget spent")]
pub(super) struct BudgetSpent;

/// What an error returned by argmin's executor means.
pub(super) fn stop_of(error: &argmin::core::Error) -> Stop {
    if error.is::<BudgetSpent>() { Stop::Budget } else { Stop::Failure(error.to_string()) }
}

/// One run of a method that minimises the objective, starting at its best point
/// so far, and tells why it stopped.
pub(super) fn run(
    problem: &dyn Problem,
    start: &[f64],
    options: Options,
    method: impl FnOnce(&Objective) -> Stop,
) -> Report {
    match Objective::begin(problem, start, options) {
        Ok(objective) => objective.report(method(&objective)),
        Err(report) => *report,
    }
}

/// Cost, relative to the start's, of a perfect fit: the residuals are then the
/// rounding errors of those at the start.
const PERFECT: f64 = 1e-28;

/// A [`Problem`] with its evaluations counted and limited and its best point
/// remembered, whatever happens to the solver.
pub(super) struct Objective<'a> {
    pub problem: &'a dyn Problem,
    pub options: Options,
    /// Iterations so far, counted by the method.
    pub iterations: Cell<usize>,
    started: Instant,
    start_cost: f64,
    ledger: RefCell<Ledger>,
}

struct Ledger {
    evaluations: usize,
    jacobians: usize,
    /// Last point evaluated, its residuals and cost: line searches end where
    /// the next iteration begins.
    last: Vec<f64>,
    residuals: Vec<f64>,
    cost: f64,
    best: Vec<f64>,
    best_cost: f64,
}

impl<'a> Objective<'a> {
    /// Projects the start onto the bounds and evaluates it.
    ///
    /// The error is the finished report of a run that cannot begin.
    fn begin(problem: &'a dyn Problem, start: &[f64], options: Options) -> Result<Self, Box<Report>> {
        let started = Instant::now();
        let refuse = |stop| {
            Box::new(Report {
                parameters: start.to_vec(),
                cost: f64::INFINITY,
                evaluations: 0,
                jacobians: 0,
                iterations: 0,
                seconds: started.elapsed().as_secs_f64(),
                stop,
            })
        };
        let bounds = problem.bounds();
        let n = problem.parameters();
        if n == 0 || start.len() != n || bounds.len() != n {
            return Err(refuse(Stop::Failure(format!(
                "{n} parameters, {} start values, {} bounds",
                start.len(),
                bounds.len()
            ))));
        }
        if let Some(i) = bounds.iter().position(|(lo, hi)| !holds_a_point(*lo, *hi)) {
            return Err(refuse(Stop::Failure(format!("bounds of parameter {i} hold no point"))));
        }
        if start.iter().any(|x| !x.is_finite()) {
            return Err(refuse(Stop::NonFiniteStart));
        }
        if options.evaluations == 0 {
            return Err(refuse(Stop::Budget));
        }

        let mut best = start.to_vec();
        project(&mut best, bounds);
        let mut objective = Self {
            problem,
            options,
            iterations: Cell::new(0),
            started,
            start_cost: f64::INFINITY,
            ledger: RefCell::new(Ledger {
                evaluations: 0,
                jacobians: 0,
                last: vec![f64::NAN; n],
                residuals: vec![0.0; problem.residual_count()],
                cost: f64::INFINITY,
                best: best.clone(),
                best_cost: f64::INFINITY,
            }),
        };
        match objective.cost(&best) {
            Ok(0.0) => Err(Box::new(objective.report(Stop::CostTolerance))),
            Ok(cost) if cost.is_finite() => {
                objective.start_cost = cost;
                Ok(objective)
            }
            _ => Err(Box::new(objective.report(Stop::NonFiniteStart))),
        }
    }

    /// Whether a cost is as good as zero.
    pub fn is_perfect(&self, cost: f64) -> bool {
        cost <= PERFECT * self.start_cost
    }

    /// Evaluations left.
    pub fn remaining(&self) -> usize {
        self.options.evaluations - self.ledger.borrow().evaluations
    }

    /// Best point and cost so far.
    pub fn best(&self) -> (Vec<f64>, f64) {
        let ledger = self.ledger.borrow();
        (ledger.best.clone(), ledger.best_cost)
    }

    /// Cost at `p`, which must lie within the bounds; infinite where `p` or a
    /// residual is not finite.
    pub fn cost(&self, p: &[f64]) -> Result<f64, BudgetSpent> {
        let mut ledger = self.ledger.borrow_mut();
        if ledger.last == p {
            return Ok(ledger.cost);
        }
        ledger.charge(self.options.evaluations)?;
        let ledger = &mut *ledger;
        if p.iter().all(|x| x.is_finite()) {
            self.problem.residuals(p, &mut ledger.residuals);
        } else {
            ledger.residuals.fill(f64::INFINITY);
        }
        Ok(ledger.record(p))
    }

    /// Cost at `p`, and its residuals into `r`.
    pub fn residuals(&self, p: &[f64], r: &mut [f64]) -> Result<f64, BudgetSpent> {
        let cost = self.cost(p)?;
        r.copy_from_slice(&self.ledger.borrow().residuals);
        Ok(cost)
    }

    /// Jacobian at `p`, finite and within the bounds; whether it is finite.
    pub fn jacobian(&self, p: &[f64], j: &mut [f64]) -> bool {
        self.ledger.borrow_mut().jacobians += 1;
        self.problem.jacobian(p, j);
        j.iter().all(|x| x.is_finite())
    }

    /// Residuals and Jacobian at `p`, finite and within the bounds: the cost,
    /// infinite where either is not finite.
    pub fn evaluate(&self, p: &[f64], r: &mut [f64], j: &mut [f64]) -> Result<f64, BudgetSpent> {
        let mut ledger = self.ledger.borrow_mut();
        ledger.charge(self.options.evaluations)?;
        ledger.jacobians += 1;
        let ledger = &mut *ledger;
        self.problem.evaluate(p, &mut ledger.residuals, j);
        let cost = ledger.record(p);
        r.copy_from_slice(&ledger.residuals);
        Ok(if j.iter().all(|x| x.is_finite()) { cost } else { f64::INFINITY })
    }

    /// The report of a run that ends now.
    fn report(&self, stop: Stop) -> Report {
        let ledger = self.ledger.borrow();
        Report {
            parameters: ledger.best.clone(),
            cost: ledger.best_cost,
            evaluations: ledger.evaluations,
            jacobians: ledger.jacobians,
            iterations: self.iterations.get(),
            seconds: self.started.elapsed().as_secs_f64(),
            stop,
        }
    }
}

impl Ledger {
    /// Pays for one evaluation.
    fn charge(&mut self, limit: usize) -> Result<(), BudgetSpent> {
        if self.evaluations >= limit {
            return Err(BudgetSpent);
        }
        self.evaluations += 1;
        Ok(())
    }

    /// Cost of the residuals just computed at `p`; remembers the best point.
    fn record(&mut self, p: &[f64]) -> f64 {
        let cost = half_square(&self.residuals);
        self.cost = if cost.is_finite() { cost } else { f64::INFINITY };
        self.last.copy_from_slice(p);
        if self.cost < self.best_cost {
            self.best_cost = self.cost;
            self.best.copy_from_slice(p);
        }
        self.cost
    }
}

/// ½ Σ r².
fn half_square(r: &[f64]) -> f64 {
    0.5 * r.iter().map(|x| x * x).sum::<f64>()
}

fn holds_a_point(lo: f64, hi: f64) -> bool {
    lo <= hi && lo < f64::INFINITY && hi > f64::NEG_INFINITY
}

/// Moves `p` to the nearest point within the bounds.
pub(super) fn project(p: &mut [f64], bounds: &[(f64, f64)]) {
    for (x, (lo, hi)) in p.iter_mut().zip(bounds) {
        *x = x.clamp(*lo, *hi);
    }
}
