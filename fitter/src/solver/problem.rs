//! What a solver is given and what it promises.

use super::Report;

/// A nonlinear least-squares problem: minimise ½ Σ rᵢ(p)² over a box.
pub trait Problem: Sync {
    /// Number of parameters, the length of `p`.
    fn parameters(&self) -> usize;

    /// Number of residuals, the length of `r`.
    fn residual_count(&self) -> usize;

    /// Lower and upper bound of every parameter; either may be infinite.
    fn bounds(&self) -> &[(f64, f64)];

    /// Writes the residuals at `p`, which is finite and within the bounds.
    /// They may be NaN or infinite: the solver then rejects the point.
    fn residuals(&self, p: &[f64], r: &mut [f64]);

    /// Writes ∂rᵢ/∂pⱼ at `j[i * parameters + j]`, at a point as above.
    fn jacobian(&self, p: &[f64], j: &mut [f64]);

    /// Residuals and Jacobian at once, for problems whose parts they share.
    fn evaluate(&self, p: &[f64], r: &mut [f64], j: &mut [f64]) {
        self.residuals(p, r);
        self.jacobian(p, j);
    }
}

/// An optimiser with its options.
pub trait Solver: Sync {
    /// The name the command line knows it by.
    fn name(&self) -> &'static str;

    /// Minimises from `start`, which is first projected onto the bounds.
    ///
    /// The result depends on the arguments only: the same seed gives the same
    /// bits. Methods without randomness ignore the seed
    /// ([`SolverKind::is_random`](super::SolverKind::is_random)).
    fn solve(&self, problem: &dyn Problem, start: &[f64], seed: u64) -> Report;
}

/// What every solver honours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// The most residual vectors that may be computed.
    pub evaluations: usize,
    /// Relative decrease of the cost that no longer counts as progress; the
    /// exact test of each method is at [`Stop::CostTolerance`](super::Stop).
    pub cost_tolerance: f64,
}

impl Default for Options {
    fn default() -> Self {
        Self { evaluations: 20_000, cost_tolerance: 1e-10 }
    }
}
