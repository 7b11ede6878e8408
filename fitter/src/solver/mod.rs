//! The optimisers behind a fit: bounded nonlinear least squares, several
//! methods behind one signature so that they can be reported side by side.
//!
//! Minimised is the cost ½ Σ rᵢ(p)² over the box lo ≤ p ≤ hi. Every solver
//! rejects points where the residuals are not finite, returns the best point it
//! ever evaluated (so never one worse than the start), and says in a [`Report`]
//! why it stopped: not converging is a report, not an error.
//!
//! | name | method | derivatives | random |
//! |---|---|---|---|
//! | `lm` | [`LevenbergMarquardt`], ours: the work horse | Jacobian | no |
//! | `ga` | [`Genetic`], ours: real-coded genetic algorithm | none | yes |
//! | `ga-lm` | [`GeneticPolished`]: the genetic algorithm, then `lm` | Jacobian | yes |
//! | `nelder-mead` | [`NelderMead`] of argmin, restarted | none | no |
//! | `gauss-newton` | [`GaussNewton`] of argmin, backtracking line search | Jacobian | no |
//! | `bfgs` | [`Bfgs`] of argmin, backtracking line search | Jacobian | no |
//!
//! Tried on the same problems and left out, all from argmin: L-BFGS needs two to
//! four times the evaluations of BFGS, the trust region methods (Steihaug,
//! dogleg, Cauchy point) up to a hundred times those of `lm`, particle swarms
//! end far above `ga` from four lobes on.

mod argmin_view;
mod bfgs;
mod gauss_newton;
mod genetic;
mod kind;
mod levenberg_marquardt;
mod model;
mod nelder_mead;
mod objective;
mod polished;
mod problem;
mod report;
mod unbounded;
mod variation;

pub use bfgs::Bfgs;
pub use gauss_newton::GaussNewton;
pub use genetic::Genetic;
pub use kind::{SolverKind, UnknownSolver};
pub use levenberg_marquardt::LevenbergMarquardt;
pub use nelder_mead::NelderMead;
pub use polished::GeneticPolished;
pub use problem::{Options, Problem, Solver};
pub use report::{Report, Stop};
