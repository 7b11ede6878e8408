//! Classic least-squares problems with their published starts and minima
//! (Moré, Garbow and Hillstrom, ACM TOMS 7:17, 1981).

use std::f64::consts::PI;

use fitter::solver::Problem;

/// Residuals into the second argument, the Jacobian into the third.
type Formula = fn(&[f64], &mut [f64], &mut [f64]);

pub struct Classic {
    pub name: &'static str,
    pub start: Vec<f64>,
    pub bounds: Vec<(f64, f64)>,
    /// ½ Σ r² at the minimum.
    pub minimum: f64,
    rows: usize,
    formula: Formula,
}

impl Problem for Classic {
    fn parameters(&self) -> usize {
        self.start.len()
    }

    fn residual_count(&self) -> usize {
        self.rows
    }

    fn bounds(&self) -> &[(f64, f64)] {
        &self.bounds
    }

    fn residuals(&self, p: &[f64], r: &mut [f64]) {
        (self.formula)(p, r, &mut vec![0.0; self.rows * self.start.len()]);
    }

    fn jacobian(&self, p: &[f64], j: &mut [f64]) {
        (self.formula)(p, &mut vec![0.0; self.rows], j);
    }
}

fn classic(name: &'static str, start: &[f64], rows: usize, minimum: f64, formula: Formula) -> Classic {
    let bounds = vec![(f64::NEG_INFINITY, f64::INFINITY); start.len()];
    Classic { name, start: start.to_vec(), bounds, minimum, rows, formula }
}

/// All of them.
pub fn all() -> Vec<Classic> {
    vec![
        rosenbrock(),
        bounded_rosenbrock(),
        classic("Beale", &[1.0, 1.0], 3, 0.0, beale),
        classic("helical valley", &[-1.0, 0.0, 0.0], 3, 0.0, helical_valley),
        classic("Box 3D", &[0.0, 10.0, 20.0], 10, 0.0, box_3d),
        classic("Powell singular", &[3.0, -1.0, 0.0, 1.0], 4, 0.0, powell_singular),
        classic("Wood", &[-3.0, -1.0, -3.0, -1.0], 6, 0.0, wood),
        classic("Kowalik-Osborne", &[0.25, 0.39, 0.415, 0.39], 11, 0.5 * 3.075_056e-4, kowalik_osborne),
        classic("Jennrich-Sampson", &[0.3, 0.4], 10, 0.5 * 124.362_182, jennrich_sampson),
        classic("Brown-Dennis", &[25.0, 5.0, -5.0, -1.0], 20, 0.5 * 85_822.201_6, brown_dennis),
    ]
}

pub fn rosenbrock() -> Classic {
    classic("Rosenbrock", &[-1.2, 1.0], 2, 0.0, |p, r, j| {
        r.copy_from_slice(&[10.0 * (p[1] - p[0] * p[0]), 1.0 - p[0]]);
        j.copy_from_slice(&[-20.0 * p[0], 10.0, -1.0, 0.0]);
    })
}

/// The minimum lies on the bound x ≤ 1/2, at (1/2, 1/4).
pub fn bounded_rosenbrock() -> Classic {
    let bounds = vec![(-2.0, 0.5), (-1.0, 2.0)];
    Classic { name: "bounded Rosenbrock", bounds, minimum: 0.125, ..rosenbrock() }
}

fn beale(p: &[f64], r: &mut [f64], j: &mut [f64]) {
    for (i, y) in [1.5, 2.25, 2.625].into_iter().enumerate() {
        let k = i as i32 + 1;
        r[i] = y - p[0] * (1.0 - p[1].powi(k));
        j[2 * i] = p[1].powi(k) - 1.0;
        j[2 * i + 1] = p[0] * f64::from(k) * p[1].powi(k - 1);
    }
}

fn helical_valley(p: &[f64], r: &mut [f64], j: &mut [f64]) {
    let square = p[0] * p[0] + p[1] * p[1];
    let half_turn = if p[0] < 0.0 { 0.5 } else { 0.0 };
    let turns = (p[1] / p[0]).atan() / (2.0 * PI) + half_turn;
    r.copy_from_slice(&[10.0 * (p[2] - 10.0 * turns), 10.0 * (square.sqrt() - 1.0), p[2]]);
    let (angular, radial) = (100.0 / (2.0 * PI * square), 10.0 / square.sqrt());
    j.copy_from_slice(&[angular * p[1], -angular * p[0], 10.0, radial * p[0], radial * p[1], 0.0, 0.0, 0.0, 1.0]);
}

fn box_3d(p: &[f64], r: &mut [f64], j: &mut [f64]) {
    for (i, row) in j.chunks_exact_mut(3).enumerate() {
        let t = 0.1 * (i as f64 + 1.0);
        let (a, b, c) = ((-t * p[0]).exp(), (-t * p[1]).exp(), (-t).exp() - (-10.0 * t).exp());
        r[i] = a - b - p[2] * c;
        row.copy_from_slice(&[-t * a, t * b, -c]);
    }
}

/// The Jacobian is singular at the minimum.
fn powell_singular(p: &[f64], r: &mut [f64], j: &mut [f64]) {
    let (s5, s10) = (5.0_f64.sqrt(), 10.0_f64.sqrt());
    let (a, b) = (p[1] - 2.0 * p[2], p[0] - p[3]);
    r.copy_from_slice(&[p[0] + 10.0 * p[1], s5 * (p[2] - p[3]), a * a, s10 * b * b]);
    j.fill(0.0);
    (j[0], j[1]) = (1.0, 10.0);
    (j[6], j[7]) = (s5, -s5);
    (j[9], j[10]) = (2.0 * a, -4.0 * a);
    (j[12], j[15]) = (2.0 * s10 * b, -2.0 * s10 * b);
}

fn wood(p: &[f64], r: &mut [f64], j: &mut [f64]) {
    let (s90, s10) = (90.0_f64.sqrt(), 10.0_f64.sqrt());
    r[..3].copy_from_slice(&[10.0 * (p[1] - p[0] * p[0]), 1.0 - p[0], s90 * (p[3] - p[2] * p[2])]);
    r[3..].copy_from_slice(&[1.0 - p[2], s10 * (p[1] + p[3] - 2.0), (p[1] - p[3]) / s10]);
    j.fill(0.0);
    (j[0], j[1], j[4]) = (-20.0 * p[0], 10.0, -1.0);
    (j[10], j[11], j[14]) = (-2.0 * s90 * p[2], s90, -1.0);
    (j[17], j[19]) = (s10, s10);
    (j[21], j[23]) = (1.0 / s10, -1.0 / s10);
}

fn kowalik_osborne(p: &[f64], r: &mut [f64], j: &mut [f64]) {
    let y = [0.1957, 0.1947, 0.1735, 0.1600, 0.0844, 0.0627, 0.0456, 0.0342, 0.0323, 0.0235, 0.0246];
    let u = [4.0, 2.0, 1.0, 0.5, 0.25, 0.167, 0.125, 0.1, 0.0833, 0.0714, 0.0625];
    for (i, row) in j.chunks_exact_mut(4).enumerate() {
        let u = u[i];
        let (above, below) = (u * u + u * p[1], u * u + u * p[2] + p[3]);
        r[i] = y[i] - p[0] * above / below;
        let slope = p[0] * above / (below * below);
        row.copy_from_slice(&[-above / below, -p[0] * u / below, slope * u, slope]);
    }
}

/// Large residuals: Gauss-Newton fails here.
fn jennrich_sampson(p: &[f64], r: &mut [f64], j: &mut [f64]) {
    for (i, row) in j.chunks_exact_mut(2).enumerate() {
        let k = i as f64 + 1.0;
        let (a, b) = ((k * p[0]).exp(), (k * p[1]).exp());
        r[i] = 2.0 + 2.0 * k - a - b;
        row.copy_from_slice(&[-k * a, -k * b]);
    }
}

/// Large residuals as well.
fn brown_dennis(p: &[f64], r: &mut [f64], j: &mut [f64]) {
    for (i, row) in j.chunks_exact_mut(4).enumerate() {
        let t = (i as f64 + 1.0) / 5.0;
        let (a, b) = (p[0] + t * p[1] - t.exp(), p[2] + p[3] * t.sin() - t.cos());
        r[i] = a * a + b * b;
        row.copy_from_slice(&[2.0 * a, 2.0 * a * t, 2.0 * b, 2.0 * b * t.sin()]);
    }
}
