//! One cell: the least-squares problem of a sum of lobes, its first guesses, and the escalation of their number.

use crate::solver::{Problem, Report, Solver};
use brdf_tables::lobe::Lobe;
use glam::DVec3;

/// What the lobes of a fit may be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Ansatz {
    /// Axes stay in the plane of incidence (isotropic materials).
    pub in_plane: bool,
    /// Amplitudes may be negative.
    pub signed: bool,
}

/// F at directions of the mirror frame of a cap, to be fitted.
pub(super) struct Target {
    /// Unit vectors, mirror frame.
    pub directions: Vec<DVec3>,
    /// Solid angles, sr.
    pub weights: Vec<f64>,
    /// F, sr⁻¹.
    pub values: Vec<f64>,
    /// max F.
    pub peak: f64,
}

/// Parameters of lobe k: tan of the axis offset in x (and in y unless in-plane), amplitude over peak (its logarithm when
/// positive), ln n. The residuals are the square root of the solid angle, over that of the lobe's support, times the error
/// over the peak: the cost is half the square of rmse_lobe, its tail included.
struct LobeProblem<'a> {
    target: &'a Target,
    ansatz: Ansatz,
    scale: Vec<f64>,
    bounds: Vec<(f64, f64)>,
}

const OFFSET: (f64, f64) = (-3.0, 3.0);
const LOG_EXPONENT: (f64, f64) = (-1.2, 14.0);
/// Signed amplitudes beyond this only cancel each other, at the cost of the digits of f32.
const AMPLITUDE: (f64, f64) = (-20.0, 20.0);
const LOG_AMPLITUDE: (f64, f64) = (-14.0, 3.0);

impl<'a> LobeProblem<'a> {
    fn new(target: &'a Target, ansatz: Ansatz, count: usize) -> Self {
        let support = |(f, w): (&f64, &f64)| if *f > 0.01 * target.peak { *w } else { 0.0 };
        let area: f64 = target.values.iter().zip(&target.weights).map(support).sum();
        let scale = target.weights.iter().map(|w| (w / area).sqrt()).collect();
        let amplitude = if ansatz.signed { AMPLITUDE } else { LOG_AMPLITUDE };
        let mut lobe = vec![OFFSET; if ansatz.in_plane { 1 } else { 2 }];
        lobe.extend([amplitude, LOG_EXPONENT]);
        Self { target, ansatz, scale, bounds: lobe.repeat(count) }
    }

    fn per_lobe(&self) -> usize {
        if self.ansatz.in_plane { 3 } else { 4 }
    }

    fn pack(&self, lobes: &[Lobe]) -> Vec<f64> {
        let mut p = Vec::new();
        for lobe in lobes {
            let z = lobe.axis.z.max(0.05);
            p.push(lobe.axis.x / z);
            if !self.ansatz.in_plane {
                p.push(lobe.axis.y / z);
            }
            let a = lobe.amplitude / self.target.peak;
            p.push(if self.ansatz.signed { a } else { a.max(1e-6).ln() });
            p.push(lobe.exponent.ln());
        }
        p
    }

    fn unpack(&self, p: &[f64]) -> Vec<Lobe> {
        let lobe = |p: &[f64]| {
            let (offset, rest) = p.split_at(self.per_lobe() - 2);
            let axis = DVec3::new(offset[0], offset.get(1).copied().unwrap_or(0.0), 1.0).normalize();
            let a = if self.ansatz.signed { rest[0] } else { rest[0].exp() };
            Lobe { axis, amplitude: a * self.target.peak, exponent: rest[1].exp() }
        };
        p.chunks(self.per_lobe()).map(lobe).collect()
    }
}

impl Problem for LobeProblem<'_> {
    fn parameters(&self) -> usize {
        self.bounds.len()
    }

    fn residual_count(&self) -> usize {
        self.scale.len()
    }

    fn bounds(&self) -> &[(f64, f64)] {
        &self.bounds
    }

    fn residuals(&self, p: &[f64], r: &mut [f64]) {
        let lobes = self.unpack(p);
        for (i, r) in r.iter_mut().enumerate() {
            let w = self.target.directions[i];
            let value: f64 = lobes.iter().map(|lobe| lobe.value(w)).sum();
            *r = self.scale[i] * (value - self.target.values[i]) / self.target.peak;
        }
    }

    fn jacobian(&self, p: &[f64], j: &mut [f64]) {
        let lobes = self.unpack(p);
        let per_lobe = self.per_lobe();
        for (i, row) in j.chunks_mut(p.len()).enumerate() {
            let w = self.target.directions[i];
            for (lobe, row) in lobes.iter().zip(row.chunks_mut(per_lobe)) {
                let cos = lobe.axis.dot(w);
                if cos <= 1e-12 {
                    row.fill(0.0);
                    continue;
                }
                let amplitude = lobe.amplitude / self.target.peak * self.scale[i];
                let power = cos.powf(lobe.exponent);
                // The axis is u/|u| with u = (tan x, tan y, 1) and |u| = 1/axis.z.
                let slope = amplitude * lobe.exponent * power / cos * lobe.axis.z;
                row[0] = slope * (w.x - cos * lobe.axis.x);
                if !self.ansatz.in_plane {
                    row[1] = slope * (w.y - cos * lobe.axis.y);
                }
                row[per_lobe - 2] = power * if self.ansatz.signed { self.scale[i] } else { amplitude };
                row[per_lobe - 1] = amplitude * power * lobe.exponent * cos.ln();
            }
        }
    }
}

/// Best lobes found for a cell.
pub(super) struct CellFit {
    /// The lobes, mirror frame.
    pub lobes: Vec<Lobe>,
    /// The report of the run that found them.
    pub report: Report,
    /// Residual evaluations of all runs.
    pub evaluations: usize,
}

impl Target {
    fn value(lobes: &[Lobe], w: DVec3) -> f64 {
        lobes.iter().map(|lobe| lobe.value(w)).sum()
    }

    /// Index of the largest |target − lobes|.
    fn largest_residual(&self, lobes: &[Lobe]) -> usize {
        let residual = |i: &usize| (self.values[*i] - Self::value(lobes, self.directions[*i])).abs();
        (0..self.values.len()).max_by(|a, b| residual(a).total_cmp(&residual(b))).unwrap_or(0)
    }

    /// A lobe at the largest value, as sharp as the integral says: ∫ cosⁿ = 2π/(n + 1).
    fn first_guess(&self) -> Lobe {
        let integral: f64 = self.values.iter().zip(&self.weights).map(|(f, w)| f * w).sum();
        let exponent = (core::f64::consts::TAU * self.peak / integral - 1.0).clamp(0.5, 1e6);
        Lobe { axis: self.directions[self.largest_residual(&[])], amplitude: self.peak, exponent }
    }

    /// First guesses with one lobe more than `lobes`: at the largest residual, sharper or wider, and concentric with the
    /// strongest lobe with the opposite sign.
    fn grown(&self, lobes: &[Lobe], ansatz: Ansatz) -> Vec<Vec<Lobe>> {
        let Some(main) = lobes.iter().copied().max_by(|a, b| a.amplitude.total_cmp(&b.amplitude)) else {
            return vec![vec![self.first_guess()]];
        };
        let at = self.largest_residual(lobes);
        let residual = self.values[at] - Self::value(lobes, self.directions[at]);
        let amplitude = if ansatz.signed { residual } else { residual.abs() };
        let with = |lobe: Lobe| lobes.iter().copied().chain([lobe]).collect::<Vec<_>>();
        let there = |factor: f64| with(Lobe { axis: self.directions[at], amplitude, exponent: main.exponent * factor });
        let mut guesses = vec![there(2.5), there(0.4)];
        if ansatz.signed {
            guesses.push(with(Lobe { amplitude: -0.3 * main.amplitude, exponent: 2.5 * main.exponent, ..main }));
        }
        guesses
    }

    /// Fits up to `most` lobes, stopping at the fewest whose `good` test holds. `warm` are the lobes of a neighbour, tried as
    /// one more first guess for their own number. Slow global solvers get one guess per number of lobes.
    pub fn fit(
        &self,
        ansatz: Ansatz,
        most: usize,
        warm: &[Lobe],
        solver: &dyn Solver,
        (thorough, seed): (bool, u64),
        good: impl Fn(&[Lobe]) -> bool,
    ) -> CellFit {
        let mut best: Option<CellFit> = None;
        let mut evaluations = 0;
        for count in 1..=most {
            let found: &[Lobe] = best.as_ref().map_or(&[], |b| &b.lobes);
            let mut guesses = self.grown(found, ansatz);
            if !thorough {
                guesses.truncate(1);
            }
            if warm.len() == count {
                guesses.insert(0, warm.to_vec());
            }
            let problem = LobeProblem::new(self, ansatz, count);
            for guess in guesses {
                let report = solver.solve(&problem, &problem.pack(&guess), seed);
                evaluations += report.evaluations;
                if best.as_ref().is_none_or(|b| report.cost < b.report.cost) {
                    best = Some(CellFit { lobes: problem.unpack(&report.parameters), report, evaluations: 0 });
                }
            }
            if best.as_ref().is_some_and(|b| good(&b.lobes)) {
                break;
            }
        }
        let mut best = best.expect("every count has a first guess");
        best.evaluations = evaluations;
        best
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solver::{Options, SolverKind};
    use brdf_tables::frame::spherical;

    fn target(values: impl Fn(DVec3) -> f64) -> Target {
        let directions: Vec<DVec3> =
            (0..400).map(|i| spherical(0.03 * (i / 20) as f64, 0.314 * (i % 20) as f64)).collect();
        let values: Vec<f64> = directions.iter().map(|&w| values(w)).collect();
        let peak = values.iter().fold(0f64, |m, &f| m.max(f));
        Target { weights: vec![0.003; 400], directions, values, peak }
    }

    #[test]
    fn jacobian_matches_differences() {
        let target = target(|w| w.z.powi(30));
        for ansatz in [Ansatz { in_plane: true, signed: true }, Ansatz { in_plane: false, signed: false }] {
            let problem = LobeProblem::new(&target, ansatz, 2);
            let lobe =
                |x: f64, a: f64, n: f64| Lobe { axis: DVec3::new(x, 0.0, 1.0).normalize(), amplitude: a, exponent: n };
            let p = problem.pack(&[lobe(0.1, 0.7, 20.0), lobe(-0.05, 0.2, 60.0)]);
            let (m, n) = (problem.residual_count(), p.len());
            let mut jacobian = vec![0.0; m * n];
            problem.jacobian(&p, &mut jacobian);
            for k in 0..n {
                let step = |h: f64| {
                    let (mut q, mut r) = (p.clone(), vec![0.0; m]);
                    q[k] += h;
                    problem.residuals(&q, &mut r);
                    r
                };
                let (up, down) = (step(1e-6), step(-1e-6));
                for i in 0..m {
                    let difference = (up[i] - down[i]) / 2e-6;
                    assert!((difference - jacobian[i * n + k]).abs() < 1e-7, "residual {i} parameter {k}");
                }
            }
        }
    }

    #[test]
    fn recovers_two_lobes() {
        let truth =
            |w: DVec3| w.z.max(0.0).powi(40) + 0.5 * DVec3::new(0.3, 0.0, 1.0).normalize().dot(w).max(0.0).powi(150);
        let target = target(truth);
        let solver = SolverKind::LevenbergMarquardt.with(Options::default());
        let ansatz = Ansatz { in_plane: true, signed: true };
        let fit = target.fit(ansatz, 2, &[], &*solver, (true, 1), |_| false);
        assert!(fit.report.cost < 1e-20, "{:?}", fit.report);
    }

    #[test]
    fn order_of_the_lobes_does_not_matter() {
        let target = target(|w| w.z.powi(30));
        let problem = LobeProblem::new(&target, Ansatz { in_plane: false, signed: true }, 2);
        let a = Lobe { axis: DVec3::new(0.1, 0.2, 1.0).normalize(), amplitude: 0.7, exponent: 20.0 };
        let b = Lobe { axis: DVec3::Z, amplitude: -0.2, exponent: 50.0 };
        let cost = |lobes: &[Lobe]| {
            let mut r = vec![0.0; problem.residual_count()];
            problem.residuals(&problem.pack(lobes), &mut r);
            r.iter().map(|x| x * x).sum::<f64>()
        };
        assert!((cost(&[a, b]) - cost(&[b, a])).abs() < 1e-15);
    }
}
