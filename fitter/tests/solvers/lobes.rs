//! Sums of generalized cosine lobes as least-squares problems, shared by the
//! tests and the bench.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

use fitter::solver::Problem;

/// How a lobe is written as four parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Coordinates {
    /// (α, β, ln a, ln n): a max(0, axis·w)ⁿ, the axis tilted from the mirror
    /// direction by α within the plane of incidence and β out of it (radian).
    Log,
    /// (Cx, Cy, Cz, n): max(0, C·w)ⁿ, as published in 2015.
    Raw,
}

/// Fit K lobes to values at directions of the hemisphere.
pub struct LobeFit {
    pub coordinates: Coordinates,
    pub lobes: usize,
    /// Zenith angle of the mirror direction, in radians.
    pub mirror: f64,
    pub directions: Vec<[f64; 3]>,
    /// Square root of the solid angle of each direction.
    pub weights: Vec<f64>,
    pub target: Vec<f64>,
    bounds: Vec<(f64, f64)>,
}

/// Value of a lobe and its four derivatives.
struct Lobe {
    value: f64,
    gradient: [f64; 4],
}

impl LobeFit {
    /// `exponent` bounds n from above by four times itself.
    pub fn new(
        coordinates: Coordinates,
        lobes: usize,
        mirror: f64,
        exponent: f64,
        directions: Vec<[f64; 3]>,
        weights: Vec<f64>,
        target: Vec<f64>,
    ) -> Self {
        let one = match coordinates {
            Coordinates::Log => {
                let tilt = (-0.8, 0.8);
                [tilt, tilt, (-7.0, 2.0), (0.0, (4.0 * exponent).ln())]
            }
            Coordinates::Raw => [(-1.2, 1.2), (-1.2, 1.2), (0.0, 1.2), (1.0, 4.0 * exponent)],
        };
        let bounds = one.repeat(lobes);
        Self { coordinates, lobes, mirror, directions, weights, target, bounds }
    }

    fn lobe(&self, q: &[f64], w: [f64; 3]) -> Lobe {
        match self.coordinates {
            Coordinates::Log => {
                let ((sin_a, cos_a), (sin_b, cos_b)) = ((self.mirror + q[0]).sin_cos(), q[1].sin_cos());
                let (along, across) = (sin_a * w[0] + cos_a * w[2], cos_a * w[0] - sin_a * w[2]);
                let c = cos_b * along + sin_b * w[1];
                if c <= 0.0 {
                    return Lobe { value: 0.0, gradient: [0.0; 4] };
                }
                let n = q[3].exp();
                let value = (q[2] + n * c.ln()).exp();
                let slope = value * n / c;
                let tilt = [slope * cos_b * across, slope * (cos_b * w[1] - sin_b * along)];
                Lobe { value, gradient: [tilt[0], tilt[1], value, value * n * c.ln()] }
            }
            Coordinates::Raw => {
                let c = q[0] * w[0] + q[1] * w[1] + q[2] * w[2];
                if c <= 0.0 {
                    return Lobe { value: 0.0, gradient: [0.0; 4] };
                }
                let value = (q[3] * c.ln()).exp();
                let slope = value * q[3] / c;
                Lobe { value, gradient: [slope * w[0], slope * w[1], slope * w[2], value * c.ln()] }
            }
        }
    }

    /// Σ of the lobes at `w`.
    pub fn value(&self, p: &[f64], w: [f64; 3]) -> f64 {
        p.chunks_exact(4).map(|q| self.lobe(q, w).value).sum()
    }

    /// The same lobe in this problem's coordinates.
    pub fn encode(&self, [tilt_in, tilt_out, amplitude, exponent]: [f64; 4]) -> [f64; 4] {
        match self.coordinates {
            Coordinates::Log => [tilt_in, tilt_out, amplitude.ln(), exponent.ln()],
            Coordinates::Raw => {
                let length = (amplitude.ln() / exponent).exp();
                let (sin_a, cos_a) = (self.mirror + tilt_in).sin_cos();
                let (sin_b, cos_b) = tilt_out.sin_cos();
                [length * cos_b * sin_a, length * sin_b, length * cos_b * cos_a, exponent]
            }
        }
    }

    /// Relative error √(∫e² / ∫F²) that a cost stands for.
    pub fn relative(&self, cost: f64) -> f64 {
        let power = self.target.iter().zip(&self.weights).map(|(f, w)| (f * w).powi(2));
        (2.0 * cost / power.sum::<f64>()).sqrt()
    }
}

impl Problem for LobeFit {
    fn parameters(&self) -> usize {
        4 * self.lobes
    }

    fn residual_count(&self) -> usize {
        self.directions.len()
    }

    fn bounds(&self) -> &[(f64, f64)] {
        &self.bounds
    }

    fn residuals(&self, p: &[f64], r: &mut [f64]) {
        for (i, r) in r.iter_mut().enumerate() {
            *r = self.weights[i] * (self.value(p, self.directions[i]) - self.target[i]);
        }
    }

    fn jacobian(&self, p: &[f64], j: &mut [f64]) {
        self.evaluate(p, &mut vec![0.0; self.residual_count()], j);
    }

    fn evaluate(&self, p: &[f64], r: &mut [f64], j: &mut [f64]) {
        for (i, row) in j.chunks_exact_mut(4 * self.lobes).enumerate() {
            let (w, weight) = (self.directions[i], self.weights[i]);
            let mut sum = -self.target[i];
            for (q, columns) in p.chunks_exact(4).zip(row.chunks_exact_mut(4)) {
                let lobe = self.lobe(q, w);
                sum += lobe.value;
                for (column, g) in columns.iter_mut().zip(lobe.gradient) {
                    *column = weight * g;
                }
            }
            r[i] = weight * sum;
        }
    }
}

/// Directions within `radius` of the mirror direction at zenith angle `mirror`
/// and above the horizon, with the square roots of their solid angles.
pub fn grid(mirror: f64, radius: f64, rings: usize, spokes: usize) -> (Vec<[f64; 3]>, Vec<f64>) {
    let (mut directions, mut weights) = (Vec::new(), Vec::new());
    for i in 0..rings {
        let delta = radius * (i as f64 + 0.5) / rings as f64;
        let area = delta.sin() * radius / rings as f64 * 2.0 * PI / spokes as f64;
        for k in 0..spokes {
            let w = around(mirror, delta, 2.0 * PI * (k as f64 + 0.5) / spokes as f64);
            if w[2] > 0.0 {
                directions.push(w);
                weights.push(area.sqrt());
            }
        }
    }
    (directions, weights)
}

/// The direction at angle `delta` from the zenith angle `centre` (azimuth 0).
fn around(centre: f64, delta: f64, psi: f64) -> [f64; 3] {
    let ((sin_c, cos_c), (sin_d, cos_d)) = (centre.sin_cos(), delta.sin_cos());
    let (across, out) = (sin_d * psi.cos(), sin_d * psi.sin());
    [sin_c * cos_d + cos_c * across, out, cos_c * cos_d - sin_c * across]
}

/// The mean of a Phong lobe over a cap at 45° (peak near 1), as a sum of many
/// rotated lobes: the case the fitter meets in every cell.
pub struct PhongCap {
    pub exponent: f64,
    /// Half angle of the cap, in radians.
    pub radius: f64,
}

impl PhongCap {
    /// From the exponent and the solid angle in steradians.
    pub fn new(exponent: f64, solid_angle: f64) -> Self {
        Self { exponent, radius: (1.0 - solid_angle / (2.0 * PI)).acos() }
    }

    /// The fit of K lobes to it.
    pub fn fit(&self, coordinates: Coordinates, lobes: usize) -> LobeFit {
        let reach = (self.radius + 4.5 / self.exponent.sqrt()).min(FRAC_PI_2);
        let (directions, weights) = grid(FRAC_PI_4, reach, 20, 24);
        // Midpoints in the cosine of the angle are equal solid angles.
        let (rings, spokes) = (16, 40);
        let mut nodes = Vec::new();
        for i in 0..rings {
            let t = (i as f64 + 0.5) / rings as f64;
            let delta = (1.0 - t * (1.0 - self.radius.cos())).acos();
            for k in 0..spokes {
                let m = around(FRAC_PI_4, delta, 2.0 * PI * (k as f64 + 0.5) / spokes as f64);
                nodes.push((m, m[2]));
            }
        }
        let cosines: f64 = nodes.iter().map(|(_, cosine)| cosine).sum();
        let mean = |w: &[f64; 3]| {
            let lobe = |m: &[f64; 3]| (m[0] * w[0] + m[1] * w[1] + m[2] * w[2]).max(0.0).powf(self.exponent);
            nodes.iter().map(|(m, cosine)| cosine * lobe(m)).sum::<f64>() / cosines
        };
        let target = directions.iter().map(mean).collect();
        LobeFit::new(coordinates, lobes, FRAC_PI_4, self.exponent, directions, weights, target)
    }

    /// Lobes on a ring of 0.7 times the radius of the cap, each as wide as its
    /// share of it.
    pub fn guess(&self, fit: &LobeFit) -> Vec<f64> {
        let k = fit.lobes as f64;
        let exponent = 1.0 / (1.0 / self.exponent + self.radius.powi(2) / (4.0 * k));
        let ring = if fit.lobes == 1 { 0.0 } else { 0.7 * self.radius };
        let lobe = |i: usize| {
            let (sin, cos) = (2.0 * PI * i as f64 / k + 0.3).sin_cos();
            fit.encode([ring * cos, ring * sin, 0.8 / k, exponent])
        };
        (0..fit.lobes).flat_map(lobe).collect()
    }
}
