//! What every solver promises, whatever the problem.

use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

use fitter::solver::{Options, Problem, Report, SolverKind, Stop};

use crate::classic;
use crate::lobes::{Coordinates, LobeFit, PhongCap};

/// Counts the calls and checks that every point is finite and within bounds.
struct Watched<'a> {
    problem: &'a dyn Problem,
    residuals: AtomicUsize,
    jacobians: AtomicUsize,
}

impl<'a> Watched<'a> {
    fn new(problem: &'a dyn Problem) -> Self {
        Self { problem, residuals: AtomicUsize::new(0), jacobians: AtomicUsize::new(0) }
    }

    fn check(&self, p: &[f64]) {
        for (x, (lo, hi)) in p.iter().zip(self.bounds()) {
            assert!(x.is_finite() && (lo..=hi).contains(&x), "{x} is not in {lo}..{hi}");
        }
    }
}

impl Problem for Watched<'_> {
    fn parameters(&self) -> usize {
        self.problem.parameters()
    }

    fn residual_count(&self) -> usize {
        self.problem.residual_count()
    }

    fn bounds(&self) -> &[(f64, f64)] {
        self.problem.bounds()
    }

    fn residuals(&self, p: &[f64], r: &mut [f64]) {
        self.check(p);
        self.residuals.fetch_add(1, Relaxed);
        self.problem.residuals(p, r);
    }

    fn jacobian(&self, p: &[f64], j: &mut [f64]) {
        self.check(p);
        self.jacobians.fetch_add(1, Relaxed);
        self.problem.jacobian(p, j);
    }
}

fn small_fit() -> (LobeFit, Vec<f64>) {
    let cap = PhongCap::new(40.0, 0.3);
    let fit = cap.fit(Coordinates::Log, 2);
    let guess = cap.guess(&fit);
    (fit, guess)
}

/// Equal but for the time it took.
fn assert_same(a: &Report, b: &Report) {
    let bits = |r: &Report| r.parameters.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
    assert_eq!(bits(a), bits(b));
    assert_eq!(a.cost.to_bits(), b.cost.to_bits());
    assert_eq!(Report { seconds: 0.0, ..a.clone() }, Report { seconds: 0.0, ..b.clone() });
}

#[test]
fn the_same_seed_gives_the_same_bits_and_only_random_solvers_mind_it() {
    let (fit, start) = small_fit();
    for kind in SolverKind::ALL {
        let solve = |seed| kind.with(Options { evaluations: 3000, ..Options::default() }).solve(&fit, &start, seed);
        let report = solve(1);
        assert_same(&report, &solve(1));
        assert_eq!(kind.is_random(), report.parameters != solve(2).parameters, "{kind}");
    }
}

#[test]
fn the_budget_holds_and_the_counts_are_true() {
    let (fit, start) = small_fit();
    for kind in SolverKind::ALL {
        for evaluations in [0, 1, 2, 5, 9, 10, 40, 70, 150, 2000] {
            let watched = Watched::new(&fit);
            let report = kind.with(Options { evaluations, cost_tolerance: 0.0 }).solve(&watched, &start, 1);
            assert!(report.evaluations <= evaluations, "{kind} {report:?}");
            assert_eq!(report.evaluations, watched.residuals.into_inner(), "{kind}");
            assert_eq!(report.jacobians, watched.jacobians.into_inner(), "{kind}");
            // Something is left for the polishing.
            assert!(evaluations < 5 || kind != SolverKind::GeneticPolished || report.jacobians > 0);
            assert!(evaluations > 10 || report.stop == Stop::Budget, "{kind} {report:?}");
        }
    }
}

/// Also with a budget that never ends it, except for the genetic algorithm: it
/// would creep along the valley of Powell's function for 10⁷ evaluations.
#[test]
fn the_cost_never_rises_and_is_that_of_the_parameters() {
    for problem in classic::all() {
        for kind in SolverKind::ALL {
            let watched = Watched::new(&problem);
            let evaluations = if kind.is_random() { 20_000 } else { usize::MAX };
            let options = Options { evaluations, cost_tolerance: 1e-4 };
            let report = kind.with(options).solve(&watched, &problem.start, 5);
            assert!(report.cost <= cost(&problem, &problem.start), "{} {kind}", problem.name);
            assert_eq!(report.cost, cost(&problem, &report.parameters), "{} {kind}", problem.name);
            assert!(kind.is_random() || report.stop != Stop::Budget);
        }
    }
}

#[test]
fn a_tighter_tolerance_costs_evaluations_and_lowers_the_cost() {
    let cap = PhongCap::new(40.0, 0.3);
    let fit = cap.fit(Coordinates::Log, 1);
    let start = fit.encode([0.1, 0.1, 0.5, 20.0]);
    for kind in SolverKind::ALL {
        let solve = |cost_tolerance| kind.with(Options { cost_tolerance, ..Options::default() }).solve(&fit, &start, 1);
        let (loose, tight) = (solve(1e-1), solve(1e-9));
        assert!(loose.evaluations < tight.evaluations, "{kind}: {loose:?} {tight:?}");
        assert!(tight.cost <= loose.cost, "{kind}: {loose:?} {tight:?}");
    }
}

#[test]
fn the_order_of_the_lobes_does_not_matter() {
    let (mut fit, _) = small_fit();
    let lobes = [[-0.2, 0.0, 0.5, 60.0], [0.3, 0.1, 0.3, 30.0]].map(|lobe| fit.encode(lobe));
    fit.target = fit.directions.iter().map(|w| fit.value(&lobes.concat(), *w)).collect();
    let start = lobes.map(|lobe| lobe.map(|x| 0.9 * x));
    let [forth, back] = [[start[0], start[1]].concat(), [start[1], start[0]].concat()];
    assert!((cost(&fit, &forth) / cost(&fit, &back) - 1.0).abs() < 1e-12);
    for kind in [SolverKind::LevenbergMarquardt, SolverKind::GaussNewton, SolverKind::Bfgs] {
        let solve = |start: &[f64]| kind.with(Options::default()).solve(&fit, start, 0);
        let (a, b) = (solve(&forth), solve(&back));
        let swapped = b.parameters[4..].iter().chain(&b.parameters[..4]);
        assert!(a.parameters.iter().zip(swapped).all(|(x, y)| (x - y).abs() < 1e-6), "{kind}: {a:?} {b:?}");
    }
}

#[test]
fn names_are_unique_and_parse_back() {
    for kind in SolverKind::ALL {
        assert_eq!(kind.to_string().parse(), Ok(kind));
        assert_eq!(kind.with(Options::default()).name(), kind.name());
    }
    let error = "simplex".parse::<SolverKind>().unwrap_err().to_string();
    assert_eq!(error, "unknown solver `simplex`, expected one of lm, ga, ga-lm, nelder-mead, gauss-newton, bfgs");
}

fn cost(problem: &dyn Problem, p: &[f64]) -> f64 {
    let mut r = vec![0.0; problem.residual_count()];
    problem.residuals(p, &mut r);
    0.5 * r.iter().map(|x| x * x).sum::<f64>()
}
