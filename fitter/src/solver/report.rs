//! How a solver ended.

use std::fmt;

/// The outcome of one run of a solver.
#[derive(Clone, Debug, PartialEq)]
pub struct Report {
    /// Best point found, within the bounds.
    pub parameters: Vec<f64>,
    /// ½ Σ r² there, never above that of the (projected) start; infinite when
    /// the start itself is not finite.
    pub cost: f64,
    /// Residual vectors computed.
    pub evaluations: usize,
    /// Jacobians computed.
    pub jacobians: usize,
    /// Iterations of the method: trial steps, simplex moves or generations.
    pub iterations: usize,
    /// Wall clock, in seconds.
    pub seconds: f64,
    /// Why it stopped.
    pub stop: Stop,
}

/// Why a solver stopped. Throughout, c is the cost, g = Jᵀr its gradient, p the
/// parameters, h the step, tol [`Options::cost_tolerance`](super::Options).
#[derive(Clone, Debug, PartialEq)]
pub enum Stop {
    /// The cost hardly falls any more:
    /// - any method: c ≤ 1e-28 times the cost of the start;
    /// - `lm`: |c − c_new| ≤ tol·c and the decrease predicted for the step ≤ tol·c;
    /// - `gauss-newton`, `bfgs`: 0 < c_old − c ≤ tol·c over one iteration;
    /// - `nelder-mead`: c_old − c ≤ tol·c over 20 (n + 1) moves of the simplex of
    ///   n + 1 vertices, and a fresh simplex around the result gained no more;
    /// - `ga`: c_old − c ≤ tol·c over 60 generations, and two renewed populations
    ///   in a row gained no more.
    CostTolerance,
    /// The gradient is as good as zero:
    /// - `lm`: maxᵢ |gᵢ| / (‖r‖ ‖Jᵢ‖) ≤ 1e-10, the cosine between the residuals
    ///   and every column Jᵢ of the Jacobian that no bound holds;
    /// - `bfgs`: ‖∂c/∂u‖ ≤ 2e-12 times the cost of the start, u the parameters
    ///   mapped to variables without bounds.
    GradientTolerance,
    /// ‖h‖ ≤ 1e-12 (‖p‖ + 1e-12) for a step that nothing shortened (`lm`).
    StepTolerance,
    /// The next evaluation would exceed
    /// [`Options::evaluations`](super::Options).
    Budget,
    /// No step, however short, lowers the cost further, although no tolerance
    /// above is met.
    NoProgress,
    /// The residuals at the start are not finite.
    NonFiniteStart,
    /// The method cannot go on, for the reason given: a singular matrix, a
    /// Jacobian that is not finite, bounds that exclude every point.
    Failure(String),
}

impl Stop {
    /// Whether one of the tolerances was met.
    pub fn converged(&self) -> bool {
        matches!(self, Stop::CostTolerance | Stop::GradientTolerance | Stop::StepTolerance)
    }
}

impl fmt::Display for Stop {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Stop::CostTolerance => "cost tolerance",
            Stop::GradientTolerance => "gradient tolerance",
            Stop::StepTolerance => "step tolerance",
            Stop::Budget => "budget spent",
            Stop::NoProgress => "no progress",
            Stop::NonFiniteStart => "start not finite",
            Stop::Failure(reason) => reason,
        })
    }
}
