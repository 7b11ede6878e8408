//! The solvers side by side on mean Phong lobes, and the time that
//! Levenberg–Marquardt spends outside of the problem: `cargo bench -p burnish-fitter --bench solvers`.

#[path = "../tests/solvers/lobes.rs"]
mod lobes;

use std::f64::consts::PI;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::time::Instant;

use divan::Bencher;
use fitter::solver::{LevenbergMarquardt, Options, Problem, Solver, SolverKind};
use lobes::{Coordinates, LobeFit, PhongCap};

fn main() {
    // `cargo test --benches` runs each bench once to see that it works.
    if !std::env::args().any(|arg| arg == "--test" || arg == "--list") {
        for coordinates in [Coordinates::Log, Coordinates::Raw] {
            compare(coordinates);
        }
        overhead();
    }
    divan::main();
}

/// Prints the table: exponents and caps are those of the paper's Fig. 4, every
/// solver starts from the same ring of lobes.
fn compare(coordinates: Coordinates) {
    println!("parameters: {coordinates:?}; error = √(∫e² / ∫F²)");
    println!("target        K solver         error %          cost  evaluations  Jacobians         ms  stop");
    for (exponent, fraction) in [(40.0, 10.0), (40.0, 30.0), (200.0, 10.0), (200.0, 100.0)] {
        let cap = PhongCap::new(exponent, PI / fraction);
        for lobes in [1, 2, 4] {
            let fit = cap.fit(coordinates, lobes);
            for kind in SolverKind::ALL {
                let report = kind.with(Options::default()).solve(&fit, &cap.guess(&fit), 1);
                println!(
                    "n {exponent:<3} π/{fraction:<4} {lobes:>3} {kind:<13} {:9.4} {:13.6e} {:12} {:10} {:10.3}  {}",
                    100.0 * fit.relative(report.cost),
                    report.cost,
                    report.evaluations,
                    report.jacobians,
                    1e3 * report.seconds,
                    report.stop,
                );
            }
        }
    }
}

/// A problem that knows how long its evaluations took, in nanoseconds.
struct Timed<'a> {
    problem: &'a LobeFit,
    spent: AtomicU64,
}

impl Timed<'_> {
    fn time(&self, evaluate: impl FnOnce()) {
        let started = Instant::now();
        evaluate();
        self.spent.fetch_add(started.elapsed().as_nanos() as u64, Relaxed);
    }
}

impl Problem for Timed<'_> {
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
        self.time(|| self.problem.residuals(p, r));
    }

    fn jacobian(&self, p: &[f64], j: &mut [f64]) {
        self.time(|| self.problem.jacobian(p, j));
    }

    fn evaluate(&self, p: &[f64], r: &mut [f64], j: &mut [f64]) {
        self.time(|| self.problem.evaluate(p, r, j));
    }
}

/// Prints what an iteration of Levenberg–Marquardt costs beside the problem.
fn overhead() {
    println!("Levenberg-Marquardt beside residuals and Jacobians");
    println!("parameters  residuals  iterations  µs per iteration");
    for lobes in [1, 2, 3, 4, 8] {
        let cap = PhongCap::new(200.0, PI / 10.0);
        let fit = cap.fit(Coordinates::Log, lobes);
        let start = cap.guess(&fit);
        let run = || {
            let timed = Timed { problem: &fit, spent: AtomicU64::new(0) };
            let report = LevenbergMarquardt::default().solve(&timed, &start, 0);
            let rest = report.seconds - 1e-9 * timed.spent.into_inner() as f64;
            (1e6 * rest / report.iterations as f64, report.iterations)
        };
        let (micros, iterations) = (0..20).map(|_| run()).min_by(|a, b| a.0.total_cmp(&b.0)).expect("20 runs");
        println!("{:10} {:10} {iterations:11} {micros:17.2}", 4 * lobes, fit.residual_count());
    }
}

#[divan::bench(args = [1, 2, 3, 4, 8])]
fn levenberg_marquardt(bencher: Bencher, lobes: usize) {
    let cap = PhongCap::new(40.0, PI / 30.0);
    let fit = cap.fit(Coordinates::Log, lobes);
    let start = cap.guess(&fit);
    let solver = LevenbergMarquardt { options: Options { cost_tolerance: 1e-6, ..Options::default() } };
    bencher.bench(|| solver.solve(&fit, &start, 0));
}
