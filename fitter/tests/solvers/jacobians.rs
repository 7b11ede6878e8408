//! The Jacobians of the test problems against finite differences: a solver
//! tested with a wrong one would be tested for nothing.

use fitter::solver::Problem;

use crate::classic;
use crate::lobes::{Coordinates, PhongCap};

/// Largest difference from central differences, relative to the largest entry
/// of the column.
fn mismatch(problem: &dyn Problem, p: &[f64]) -> f64 {
    let (n, m) = (problem.parameters(), problem.residual_count());
    let (mut r, mut j, mut alone) = (vec![0.0; m], vec![0.0; n * m], vec![0.0; n * m]);
    problem.evaluate(p, &mut r, &mut j);
    problem.jacobian(p, &mut alone);
    assert_eq!(j, alone);
    let mut worst: f64 = 0.0;
    for column in 0..n {
        let h = 1e-5 * p[column].abs().max(0.1);
        let [above, below] = [h, -h].map(|h| {
            let mut q = p.to_vec();
            q[column] += h;
            let mut r = vec![0.0; m];
            problem.residuals(&q, &mut r);
            r
        });
        let entries = || (0..m).map(|i| j[i * n + column]);
        let scale = entries().fold(0.0, |a: f64, x| a.max(x.abs()));
        for (i, exact) in entries().enumerate() {
            let difference = (above[i] - below[i]) / (2.0 * h);
            worst = worst.max((exact - difference).abs() / scale);
        }
    }
    worst
}

#[test]
fn classic_jacobians_are_right() {
    for problem in classic::all() {
        let p: Vec<f64> = problem.start.iter().map(|x| 0.9 * x + 0.05).collect();
        let error = mismatch(&problem, &p);
        assert!(error < 1e-6, "{}: {error:e}", problem.name);
    }
}

#[test]
fn lobe_jacobians_are_right() {
    let cap = PhongCap::new(40.0, 0.3);
    for coordinates in [Coordinates::Log, Coordinates::Raw] {
        let fit = cap.fit(coordinates, 3);
        let error = mismatch(&fit, &cap.guess(&fit));
        assert!(error < 1e-5, "{coordinates:?}: {error:e}");
    }
}
