//! Quadratic model of the cost around a point, c(p + h) ≈ c + gᵀh + ½ hᵀBh.
//!
//! The Hessian of ½ Σ r² is JᵀJ + Σ rᵢ∇²rᵢ. Gauss-Newton and classic
//! Levenberg–Marquardt drop the second term; a sum of lobes that cannot match
//! its target keeps residuals so large, and JᵀJ so nearly singular, that they
//! then crawl for thousands of steps. Dennis, Gay and Welsch (NL2SOL, ACM TOMS
//! 7:348, 1981) learn that term S from the change of the gradient.

/// The model, with room for one damped factorisation: nothing is allocated
/// after construction. Matrices are row-major, of symmetric ones only the lower
/// triangle is kept.
pub(super) struct Model {
    n: usize,
    /// JᵀJ.
    a: Vec<f64>,
    /// Secant approximation of Σ rᵢ∇²rᵢ.
    s: Vec<f64>,
    /// Jᵀr.
    pub gradient: Vec<f64>,
    /// Whether B = JᵀJ + S; otherwise B = JᵀJ.
    pub secant: bool,
    /// Cholesky factor of the last damped matrix.
    factor: Vec<f64>,
    /// Vector of the secant update.
    u: Vec<f64>,
}

impl Model {
    pub fn new(n: usize) -> Self {
        Self {
            n,
            a: vec![0.0; n * n],
            s: vec![0.0; n * n],
            gradient: vec![0.0; n],
            secant: false,
            factor: vec![0.0; n * n],
            u: vec![0.0; n],
        }
    }

    /// (JᵀJ)ᵢᵢ, the squared norm of column i.
    pub fn diagonal(&self, i: usize) -> f64 {
        self.a[i * self.n + i]
    }

    /// Forms JᵀJ and g from the row-major Jacobian and the residuals.
    pub fn assemble(&mut self, jacobian: &[f64], residuals: &[f64]) {
        let n = self.n;
        self.a.fill(0.0);
        self.gradient.fill(0.0);
        // Four rows per pass: each entry of A is then loaded and stored once
        // for four products.
        let mut rows = jacobian.chunks_exact(4 * n);
        let mut rs = residuals.chunks_exact(4);
        for (block, r) in (&mut rows).zip(&mut rs) {
            let (r0, rest) = block.split_at(n);
            let (r1, rest) = rest.split_at(n);
            let (r2, r3) = rest.split_at(n);
            for i in 0..n {
                let (x0, x1, x2, x3) = (r0[i], r1[i], r2[i], r3[i]);
                self.gradient[i] += x0 * r[0] + x1 * r[1] + x2 * r[2] + x3 * r[3];
                let a = &mut self.a[i * n..=i * n + i];
                let columns = r0.iter().zip(r1).zip(r2.iter().zip(r3));
                for (a, ((y0, y1), (y2, y3))) in a.iter_mut().zip(columns) {
                    *a += x0 * y0 + x1 * y1 + x2 * y2 + x3 * y3;
                }
            }
        }
        for (row, r) in rows.remainder().chunks_exact(n).zip(rs.remainder()) {
            for i in 0..n {
                self.gradient[i] += row[i] * r;
                for j in 0..=i {
                    self.a[i * n + j] += row[i] * row[j];
                }
            }
        }
    }

    /// Teaches S the curvature along `step`, which led here from a point with
    /// the Jacobian `previous`: S·step should be (J − J_previous)ᵀ r. This is the
    /// symmetric rank-one update; to be called after [`Self::assemble`].
    pub fn learn(&mut self, step: &[f64], previous: &[f64], residuals: &[f64]) {
        let n = self.n;
        // u = (J − J_previous)ᵀ r − S·step, what S has yet to learn.
        self.u.copy_from_slice(&self.gradient);
        for (row, r) in previous.chunks_exact(n).zip(residuals) {
            for (u, x) in self.u.iter_mut().zip(row) {
                *u -= x * r;
            }
        }
        for i in 0..n {
            for j in 0..=i {
                let s = self.s[i * n + j];
                self.u[i] -= s * step[j];
                if j < i {
                    self.u[j] -= s * step[i];
                }
            }
        }
        // S ← S + u uᵀ / uᵀstep, unless that quotient is made of rounding.
        let us = dot(&self.u, step);
        if us.abs() > 1e-8 * (dot(&self.u, &self.u) * dot(step, step)).sqrt() {
            for i in 0..n {
                for j in 0..=i {
                    self.s[i * n + j] += self.u[i] * self.u[j] / us;
                }
            }
        }
    }

    /// Solves (B + μ D) h = −g on the free parameters, h = 0 on the others.
    ///
    /// False when the damped matrix is not positive definite in floating point.
    pub fn solve(&mut self, mu: f64, scale: &[f64], free: &[bool], h: &mut [f64]) -> bool {
        let n = self.n;
        let l = &mut self.factor;
        // A column that was zero at every point so far must not make the
        // damped matrix singular.
        let damping = |d: f64| mu * if d > 0.0 { d } else { 1.0 };
        for i in 0..n {
            for j in 0..=i {
                let k = i * n + j;
                let entry = match (free[i] && free[j], i == j) {
                    (true, diagonal) => {
                        self.a[k]
                            + if self.secant { self.s[k] } else { 0.0 }
                            + if diagonal { damping(scale[i]) } else { 0.0 }
                    }
                    (false, diagonal) => f64::from(u8::from(diagonal)),
                };
                let (upper, lower) = l.split_at_mut(i * n);
                let done = if i == j { &lower[..j] } else { &upper[j * n..j * n + j] };
                let rest = entry - dot(&lower[..j], done);
                l[k] = if i == j {
                    if rest.is_nan() || rest <= f64::EPSILON * entry {
                        return false;
                    }
                    rest.sqrt()
                } else {
                    rest / l[j * n + j]
                };
            }
        }
        // L y = −g, then Lᵀ h = y, both in place.
        for i in 0..n {
            let g = if free[i] { self.gradient[i] } else { 0.0 };
            h[i] = (-g - dot(&l[i * n..i * n + i], &h[..i])) / l[i * n + i];
        }
        for i in (0..n).rev() {
            let below: f64 = (i + 1..n).map(|k| l[k * n + i] * h[k]).sum();
            h[i] = (h[i] - below) / l[i * n + i];
        }
        true
    }

    /// Decrease of the cost that the model predicts for a step, without S and
    /// with it.
    pub fn predicted_decrease(&self, h: &[f64]) -> [f64; 2] {
        let gauss_newton = -dot(&self.gradient, h) - 0.5 * quadratic(&self.a, h);
        [gauss_newton, gauss_newton - 0.5 * quadratic(&self.s, h)]
    }
}

/// xᵀMx of a symmetric matrix from its lower triangle.
fn quadratic(m: &[f64], x: &[f64]) -> f64 {
    let n = x.len();
    let row = |i: usize| x[i] * (2.0 * dot(&m[i * n..i * n + i], &x[..i]) + m[i * n + i] * x[i]);
    (0..n).map(row).sum()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{DMatrix, DVector};
    use rand::{RngExt, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    fn random(n: usize, rows: usize) -> (Model, DMatrix<f64>, DVector<f64>) {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(n as u64);
        let j: Vec<f64> = (0..n * rows).map(|_| rng.random_range(-1.0..1.0)).collect();
        let r: Vec<f64> = (0..rows).map(|_| rng.random_range(-1.0..1.0)).collect();
        let mut normal = Model::new(n);
        normal.assemble(&j, &r);
        let (j, r) = (DMatrix::from_row_slice(rows, n, &j), DVector::from_vec(r));
        (normal, j.tr_mul(&j), j.tr_mul(&r))
    }

    #[test]
    fn agrees_with_nalgebra() {
        for n in 1..=32 {
            let (mut normal, a, g) = random(n, 3 * n + 1);
            let scale: Vec<f64> = (0..n).map(|i| 0.5 + i as f64).collect();
            let damped = &a + 0.1 * DMatrix::from_diagonal(&DVector::from_row_slice(&scale));
            let expected = -damped.cholesky().unwrap().solve(&g);

            let mut h = vec![0.0; n];
            assert!(normal.solve(0.1, &scale, &vec![true; n], &mut h));
            let h = DVector::from_vec(h);
            assert!((&h - &expected).norm() < 1e-10 * expected.norm());

            let decrease = -g.dot(&h) - 0.5 * h.dot(&(&a * &h));
            assert!((normal.predicted_decrease(h.as_slice())[0] - decrease).abs() < 1e-10 * decrease);
        }
    }

    #[test]
    fn a_held_parameter_does_not_move_and_leaves_the_rest_alone() {
        let (mut normal, a, g) = random(3, 20);
        let mut h = vec![0.0; 3];
        assert!(normal.solve(0.0, &[1.0; 3], &[true, false, true], &mut h));
        let expected = -a
            .select_rows([0, 2].iter())
            .select_columns([0, 2].iter())
            .cholesky()
            .unwrap()
            .solve(&g.select_rows([0, 2].iter()));
        assert_eq!(h[1], 0.0);
        assert!((h[0] - expected[0]).abs() + (h[2] - expected[1]).abs() < 1e-12);
    }

    #[test]
    fn a_singular_or_nan_matrix_is_refused() {
        let mut normal = Model::new(2);
        normal.assemble(&[1.0, 2.0, 2.0, 4.0], &[1.0, 1.0]);
        assert!(!normal.solve(0.0, &[1.0; 2], &[true; 2], &mut [0.0; 2]));
        normal.assemble(&[1.0, f64::NAN, 2.0, 4.0], &[1.0, 1.0]);
        assert!(!normal.solve(1.0, &[1.0; 2], &[true; 2], &mut [0.0; 2]));
    }

    /// S·step = (J − J_previous)ᵀ r, and the prediction with S takes it into account.
    #[test]
    fn the_secant_term_learns_the_curvature_along_the_step() {
        let (n, rows) = (5, 20);
        let (mut model, ..) = random(n, rows);
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(9);
        let mut draw = |count: usize| -> Vec<f64> { (0..count).map(|_| rng.random_range(-1.0..1.0)).collect() };
        let (previous, jacobian, r, step) = (draw(n * rows), draw(n * rows), draw(rows), draw(n));
        model.assemble(&jacobian, &r);
        model.learn(&step, &previous, &r);

        let [before, after] = [previous, jacobian].map(|j| DMatrix::from_row_slice(rows, n, &j));
        let expected = (after - before).tr_mul(&DVector::from_vec(r));
        let s = DMatrix::from_fn(n, n, |i, j| model.s[i.max(j) * n + i.min(j)]);
        let h = DVector::from_vec(step);
        assert!((&s * &h - &expected).norm() < 1e-12 * expected.norm());

        let [plain, secant] = model.predicted_decrease(h.as_slice());
        assert!((plain - secant - 0.5 * h.dot(&expected)).abs() < 1e-12 * plain.abs());
    }
}
