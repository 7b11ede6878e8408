//! Levenberg–Marquardt against the `levenberg-marquardt` crate, a port of
//! MINPACK, on random sums of lobes with noise.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

use fitter::solver::{Options, Problem, SolverKind};
use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt};
use nalgebra::{DMatrix, DVector, Dyn, Owned};
use rand::{Rng, RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use crate::lobes::{Coordinates, LobeFit, grid};

struct Oracle<'a> {
    fit: &'a LobeFit,
    p: DVector<f64>,
}

impl LeastSquaresProblem<f64, Dyn, Dyn> for Oracle<'_> {
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, Dyn>;
    type ParameterStorage = Owned<f64, Dyn>;

    fn set_params(&mut self, p: &DVector<f64>) {
        self.p.copy_from(p);
    }

    fn params(&self) -> DVector<f64> {
        self.p.clone()
    }

    fn residuals(&self) -> Option<DVector<f64>> {
        let mut r = DVector::zeros(self.fit.residual_count());
        self.fit.residuals(self.p.as_slice(), r.as_mut_slice());
        Some(r)
    }

    fn jacobian(&self) -> Option<DMatrix<f64>> {
        let (m, n) = (self.fit.residual_count(), self.fit.parameters());
        let mut j = vec![0.0; m * n];
        self.fit.jacobian(self.p.as_slice(), &mut j);
        Some(DMatrix::from_row_slice(m, n, &j))
    }
}

/// Two or three random lobes with 1 % noise, and a perturbed start.
fn random_fit(rng: &mut impl Rng) -> (LobeFit, Vec<f64>) {
    let lobes = rng.random_range(2..=3);
    let (directions, weights) = grid(FRAC_PI_4, FRAC_PI_2, 16, 16);
    let zero = vec![0.0; directions.len()];
    let mut fit = LobeFit::new(Coordinates::Log, lobes, FRAC_PI_4, 200.0, directions, weights, zero);
    let (mut truth, mut start) = (Vec::new(), Vec::new());
    for _ in 0..lobes {
        let tilts = [0; 2].map(|_| rng.random_range(-0.4..0.4));
        let (a, n) = (rng.random_range(-1.5..0.0), rng.random_range(1.5..4.0));
        truth.extend([tilts[0], tilts[1], a, n]);
        let mut near = |x: f64, by: f64| x + rng.random_range(-by..by);
        start.extend([near(tilts[0], 0.1), near(tilts[1], 0.1), near(a, 0.5), near(n, 0.5)]);
    }
    let noisy = |w: &[f64; 3]| fit.value(&truth, *w) + 0.01 * rng.random_range(-1.0..1.0);
    fit.target = fit.directions.iter().map(noisy).collect();
    (fit, start)
}

#[test]
fn is_as_good_as_minpack_and_evaluates_no_more() {
    let solver = SolverKind::LevenbergMarquardt.with(Options { cost_tolerance: 1e-12, ..Options::default() });
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(11);
    let (mut same, mut better, mut worse) = (0, 0, 0);
    let (mut ours, mut theirs) = (0, 0);
    for _ in 0..100 {
        let (fit, start) = random_fit(&mut rng);
        let report = solver.solve(&fit, &start, 0);
        assert!(report.stop.converged(), "{report:?}");
        let oracle = Oracle { fit: &fit, p: DVector::from_vec(start) };
        let (_, minpack) = LevenbergMarquardt::new().with_ftol(1e-12).with_xtol(1e-12).minimize(oracle);
        ours += report.evaluations;
        theirs += minpack.number_of_evaluations;
        let ratio = report.cost / minpack.objective_function;
        match ratio {
            _ if (ratio - 1.0).abs() < 1e-9 => same += 1,
            _ if ratio < 1.0 => better += 1,
            _ => worse += 1,
        }
    }
    println!("same {same}, better {better}, worse {worse}; evaluations {ours} against {theirs}");
    assert!(same >= 80, "{same} of 100 minima agree");
    assert!(worse <= better + 5, "{worse} worse, {better} better");
    assert!(ours <= theirs, "{ours} evaluations against {theirs}");
}
