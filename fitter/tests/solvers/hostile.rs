//! Problems that are not what a solver hopes for.

use fitter::solver::{Options, Problem, Report, Solver, SolverKind, Stop};

use crate::classic;
use crate::lobes::{Coordinates, PhongCap};

/// A problem made of closures, without bounds unless they are given.
struct Custom<R, J> {
    bounds: Vec<(f64, f64)>,
    rows: usize,
    residuals: R,
    jacobian: J,
}

impl<R, J> Problem for Custom<R, J>
where
    R: Fn(&[f64], &mut [f64]) + Sync,
    J: Fn(&[f64], &mut [f64]) + Sync,
{
    fn parameters(&self) -> usize {
        self.bounds.len()
    }

    fn residual_count(&self) -> usize {
        self.rows
    }

    fn bounds(&self) -> &[(f64, f64)] {
        &self.bounds
    }

    fn residuals(&self, p: &[f64], r: &mut [f64]) {
        (self.residuals)(p, r);
    }

    fn jacobian(&self, p: &[f64], j: &mut [f64]) {
        (self.jacobian)(p, j);
    }
}

const FREE: (f64, f64) = (f64::NEG_INFINITY, f64::INFINITY);

fn solvers() -> impl Iterator<Item = Box<dyn Solver>> {
    let options = Options { evaluations: 5000, ..Options::default() };
    SolverKind::ALL.into_iter().map(move |kind| kind.with(options))
}

/// r = x − target, replaced by `poison` wherever `region` says so.
fn poisoned(target: f64, poison: f64, region: fn(f64) -> bool) -> impl Problem {
    Custom {
        bounds: vec![FREE; 2],
        rows: 2,
        residuals: move |p: &[f64], r: &mut [f64]| {
            let hit = p.iter().any(|x| region(*x));
            (r[0], r[1]) = if hit { (poison, poison) } else { (p[0] - target, p[1] - target) };
        },
        jacobian: move |p: &[f64], j: &mut [f64]| {
            let hit = p.iter().any(|x| region(*x));
            j.copy_from_slice(&if hit { [poison; 4] } else { [1.0, 0.0, 0.0, 1.0] });
        },
    }
}

fn assert_sound(report: &Report, at_most: f64) {
    assert!(report.cost <= at_most, "{report:?}");
    assert!(report.parameters.iter().all(|x| x.is_finite()), "{report:?}");
}

#[test]
fn regions_of_nan_and_infinity_are_walked_around() {
    for poison in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e200] {
        // The minimum itself is fine, but the first full step may overshoot.
        let reachable = poisoned(1.0, poison, |x| x > 1.5);
        // The minimum lies within the region: the best is its border.
        let unreachable = poisoned(2.0, poison, |x| x > 1.5);
        for solver in solvers() {
            let report = solver.solve(&reachable, &[-3.0, -2.0], 1);
            assert_sound(&report, 1e-2);
            let report = solver.solve(&unreachable, &[-3.0, -2.0], 1);
            assert_sound(&report, 18.0);
            assert!(report.parameters.iter().all(|x| *x <= 1.5), "{} {report:?}", solver.name());
        }
    }
}

#[test]
fn only_the_start_is_finite() {
    let problem = poisoned(7.0, f64::NAN, |x| x != 1.0);
    for solver in solvers() {
        let report = solver.solve(&problem, &[1.0, 1.0], 1);
        assert_eq!((report.cost, report.parameters.as_slice()), (36.0, &[1.0, 1.0][..]), "{}", solver.name());
        assert!(!matches!(report.stop, Stop::GradientTolerance | Stop::StepTolerance), "{report:?}");
    }
}

#[test]
fn a_start_that_is_not_finite_is_reported() {
    let problem = poisoned(0.0, f64::NAN, |x| x > 0.0);
    for solver in solvers() {
        for start in [[1.0, 1.0], [f64::NAN, 0.0], [0.0, f64::INFINITY], [0.0, -1e300]] {
            let report = solver.solve(&problem, &start, 1);
            assert_eq!((report.stop, report.cost), (Stop::NonFiniteStart, f64::INFINITY), "{}", solver.name());
        }
    }
}

#[test]
fn a_jacobian_that_is_not_finite_is_a_failure_of_those_who_need_it() {
    let residuals = |p: &[f64], r: &mut [f64]| r[0] = p[0].abs().sqrt();
    let jacobian = |p: &[f64], j: &mut [f64]| j[0] = 0.5 * p[0].signum() / p[0].abs().sqrt();
    let root = Custom { bounds: vec![FREE], rows: 1, residuals, jacobian };
    for solver in solvers() {
        assert_sound(&solver.solve(&root, &[4.0], 1), 2.0);
    }
    let blind = Custom { bounds: vec![FREE], rows: 1, residuals, jacobian: |_: &[f64], j: &mut [f64]| j[0] = f64::NAN };
    for kind in [SolverKind::LevenbergMarquardt, SolverKind::GaussNewton, SolverKind::Bfgs] {
        let report = kind.with(Options::default()).solve(&blind, &[4.0], 1);
        assert_eq!(report.stop, Stop::Failure("Jacobian not finite".into()), "{kind}");
        assert_eq!((report.cost, report.parameters), (2.0, vec![4.0]));
    }
}

#[test]
fn a_singular_jacobian_is_no_panic() {
    // The second parameter does nothing, the third is fixed by its bounds.
    let idle = Custom {
        bounds: vec![(-5.0, 5.0), (-5.0, 5.0), (2.0, 2.0)],
        rows: 2,
        residuals: |p: &[f64], r: &mut [f64]| (r[0], r[1]) = (p[0] - 1.0, p[0] * p[2] - 2.0),
        jacobian: |p: &[f64], j: &mut [f64]| j.copy_from_slice(&[1.0, 0.0, 0.0, p[2], 0.0, p[0]]),
    };
    for solver in solvers() {
        let report = solver.solve(&idle, &[4.0, 1.0, 2.0], 1);
        if solver.name() == "gauss-newton" {
            assert_eq!(report.stop, Stop::Failure("Non-invertible matrix".into()));
        } else {
            assert_sound(&report, 1e-9);
        }
    }
}

#[test]
fn an_all_zero_target_is_fitted_by_vanishing_lobes() {
    for coordinates in [Coordinates::Log, Coordinates::Raw] {
        let cap = PhongCap::new(40.0, 0.3);
        let mut fit = cap.fit(coordinates, 2);
        let start = cap.guess(&fit);
        fit.target.fill(0.0);
        for solver in solvers() {
            let report = solver.solve(&fit, &start, 1);
            // The bound on ln a leaves lobes of 10⁻³.
            assert_sound(&report, 1e-5);
        }
    }
}

#[test]
fn a_perfect_start_is_left_alone() {
    let problem = classic::rosenbrock();
    for solver in solvers() {
        let report = solver.solve(&problem, &[1.0, 1.0], 1);
        assert_eq!((report.cost, report.stop.clone()), (0.0, Stop::CostTolerance), "{}", solver.name());
        assert_eq!((report.parameters.as_slice(), report.evaluations), (&[1.0, 1.0][..], 1));
    }
}

#[test]
fn a_start_outside_the_bounds_is_projected() {
    let problem = classic::bounded_rosenbrock();
    for solver in solvers() {
        let report = solver.solve(&problem, &[30.0, -1e6], 1);
        // That is (1/2, −1), from where all but Gauss-Newton find the minimum.
        let expected = if solver.name() == "gauss-newton" { 100.0 } else { 0.1251 };
        assert_sound(&report, expected);
    }
}

#[test]
fn bad_input_is_a_failure_and_no_panic() {
    let mut problem = classic::rosenbrock();
    for solver in solvers() {
        let report = solver.solve(&problem, &[1.0], 1);
        assert_eq!(report.stop, Stop::Failure("2 parameters, 1 start values, 2 bounds".into()));
    }
    for bad in [(1.0, 0.0), (f64::NAN, 1.0), (0.0, f64::NAN), (f64::INFINITY, f64::INFINITY)] {
        problem.bounds[1] = bad;
        for solver in solvers() {
            let report = solver.solve(&problem, &[1.0, 1.0], 1);
            assert_eq!(report.stop, Stop::Failure("bounds of parameter 1 hold no point".into()));
        }
    }
    let empty = Custom {
        bounds: vec![],
        rows: 1,
        residuals: |_: &[f64], r: &mut [f64]| r[0] = 1.0,
        jacobian: |_: &[f64], _: &mut [f64]| {},
    };
    for solver in solvers() {
        assert!(matches!(solver.solve(&empty, &[], 1).stop, Stop::Failure(_)));
    }
}

/// Bounds so wide that their difference overflows, and residuals likewise.
#[test]
fn extreme_scales_are_no_panic() {
    let wide = |x: f64| Custom {
        bounds: vec![(-f64::MAX, f64::MAX); 2],
        rows: 2,
        residuals: move |p: &[f64], r: &mut [f64]| (r[0], r[1]) = (x * (p[0] - 3.0), (p[1] - 5.0) / x),
        jacobian: move |_: &[f64], j: &mut [f64]| j.copy_from_slice(&[x, 0.0, 0.0, 1.0 / x]),
    };
    for scale in [1.0, 1e-100, 1e100, 1e150] {
        for solver in solvers() {
            let report = solver.solve(&wide(scale), &[1.0, 1.0], 1);
            assert_sound(&report, 0.5 * ((2.0 * scale).powi(2) + (4.0 / scale).powi(2)));
        }
    }
}
