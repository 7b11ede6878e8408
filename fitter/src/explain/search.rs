//! Models whose shape has several parameters, fitted to points of data by the solvers of this crate: each channel's kd and ks are
//! the least squares of a shape, so that only the shape is searched (Golub and Pereyra 1973, "variable projection").

use super::fit::{Colors, colors};
use super::{Fit, Point};
use crate::solver::{GeneticPolished, Options, Problem, Solver};
use brdf_tables::brdf::{Brdf, Lafortune, Specular};
use brdf_tables::material::Material;
use brdf_tables::measured::shape::{Gamma, Groove, Pair};
use core::f64::consts::{FRAC_1_PI, PI};
use glam::DVec3;

/// Models that are searched.
pub const MODELS: [&str; 3] = ["sgd", "abc", "lobes"];

/// Residual vectors a model may take, and the seed of its search.
const EVALUATIONS: usize = 3000;
const SEED: u64 = 1;
/// Every so many of the points are looked at by the search.
const STRIDE: usize = 3;
/// Lobes of `lobes`.
const LOBES: usize = 3;
/// Step of differences, relative to a parameter's range.
const STEP: f64 = 1e-6;

/// A shape by its parameters.
#[derive(Clone, Copy)]
enum Family {
    Gamma,
    Groove,
    Lobes,
}

/// A shape with its parameters.
enum Shape {
    Gamma(Gamma),
    Groove(Groove),
    Lobes(Lafortune),
}

impl Shape {
    /// The lobe at unit strength.
    fn lobe(&self, wi: DVec3, wo: DVec3, pair: &Pair) -> f64 {
        match self {
            Self::Gamma(shape) => shape.lobe(pair),
            Self::Groove(shape) => shape.lobe(pair),
            Self::Lobes(shape) => shape.eval(wi, wo),
        }
    }
}

impl Family {
    /// Bounds of the parameters, and where the search begins.
    fn space(self) -> (Vec<(f64, f64)>, Vec<f64>) {
        let (bounds, start) = match self {
            // ln α, p, f0, f1, ln λ, ln c, k, θ₀: shadowing that is none is at the lower bound of λ.
            Self::Gamma => (
                vec![
                    (-9.0, 1.5),
                    (0.0, 4.0),
                    (0.0, 1.0),
                    (-1.0, 1.0),
                    (-7.0, 5.0),
                    (-4.0, 6.0),
                    (0.5, 12.0),
                    (-0.5, 1.5),
                ],
                vec![-3.0, 0.7, 0.1, 0.0, -2.0, 0.0, 4.0, 0.5],
            ),
            // ln b, c, ln (index − 1).
            Self::Groove => (vec![(-2.0, 16.0), (0.1, 8.0), (-4.0, 4.0)], vec![6.0, 1.2, -0.7]),
            // Of each lobe Cx/Cz, ln n and its logarithmic strength beside the first.
            Self::Lobes => {
                let lobe = [(-1.6, 1.0), (-1.0, 7.5), (-14.0, 14.0)];
                let start = [[-1.0, 4.5, 0.0], [-1.05, 2.5, 0.0], [-0.8, 0.5, 0.0]];
                (lobe.repeat(LOBES), start.concat())
            }
        };
        (bounds, start)
    }

    fn shape(self, p: &[f64]) -> Option<Shape> {
        Some(match self {
            Self::Gamma => Shape::Gamma(Gamma {
                alpha: p[0].exp(),
                p: p[1],
                f0: p[2],
                f1: p[3],
                kap: 1.0,
                lambda: p[4].exp(),
                c: p[5].exp(),
                k: p[6],
                theta0: p[7],
            }),
            Self::Groove => Shape::Groove(Groove { b: p[0].exp(), c: p[1], ior: 1.0 + p[2].exp() }),
            Self::Lobes => Shape::Lobes(lobes(p, 1.0)?),
        })
    }
}

/// The lobes of parameters, times a strength: it goes into the coefficients. `None` where a model cannot hold it.
fn lobes(p: &[f64], strength: f64) -> Option<Lafortune> {
    let lobe = |p: &[f64]| {
        let n = p[1].exp();
        let scale = (p[2].exp() * strength * (n + 2.0) / (2.0 * PI)).powf(1.0 / n);
        // The direction of the coefficients has the length √3 of a mirroring lobe.
        let length = (2.0 * p[0] * p[0] + 1.0).sqrt() / 3f64.sqrt();
        let [across, up] = [p[0], 1.0].map(|x| x / length * scale);
        [across, across, up, n]
    };
    Lafortune::new(&p.chunks_exact(3).map(lobe).collect::<Vec<_>>()).ok()
}

/// Relative differences of a family's best colours from points.
struct Search<'a> {
    family: Family,
    bounds: Vec<(f64, f64)>,
    points: Vec<(&'a Point, Pair)>,
    floor: f64,
}

impl Search<'_> {
    fn values(&self, p: &[f64]) -> Option<(Vec<f64>, Colors)> {
        let shape = self.family.shape(p)?;
        let lobe: Vec<f64> = self.points.iter().map(|(at, pair)| shape.lobe(at.wi, at.wo, pair)).collect();
        let found = colors(self.points.iter().map(|(at, _)| *at), &lobe, self.floor, f64::INFINITY);
        Some((lobe, found))
    }
}

impl Problem for Search<'_> {
    fn parameters(&self) -> usize {
        self.bounds.len()
    }

    fn residual_count(&self) -> usize {
        3 * self.points.len()
    }

    fn bounds(&self) -> &[(f64, f64)] {
        &self.bounds
    }

    fn residuals(&self, p: &[f64], r: &mut [f64]) {
        let Some((lobe, Colors { kd, ks, .. })) = self.values(p) else { return r.fill(f64::NAN) };
        for (((at, _), lobe), r) in self.points.iter().zip(lobe).zip(r.chunks_exact_mut(3)) {
            for c in 0..3 {
                r[c] = (kd[c] * FRAC_1_PI + ks[c] * lobe - at.rgb[c]) / (at.rgb[c] + self.floor);
            }
        }
    }

    fn jacobian(&self, p: &[f64], j: &mut [f64]) {
        let (count, width) = (self.residual_count(), self.bounds.len());
        let [mut low, mut high] = [vec![0.0; count], vec![0.0; count]];
        for (k, &(least, most)) in self.bounds.iter().enumerate() {
            let step = STEP * (most - least);
            let moved = |by: f64, r: &mut Vec<f64>| {
                let mut p = p.to_vec();
                p[k] = (p[k] + by).clamp(least, most);
                self.residuals(&p, r);
                p[k]
            };
            let span = moved(step, &mut high) - moved(-step, &mut low);
            for (i, (high, low)) in high.iter().zip(&low).enumerate() {
                j[i * width + k] = (high - low) / span;
            }
        }
    }
}

/// The model of a name that is nearest to the points in the sense of relative squares.
pub(super) fn candidate(name: &str, points: &[Point], floor: f64) -> Option<Fit> {
    let family = match name {
        "sgd" => Family::Gamma,
        "abc" => Family::Groove,
        _ => Family::Lobes,
    };
    let (bounds, start) = family.space();
    let with_pairs = |stride| points.iter().step_by(stride).map(|at| (at, Pair::new(at.wi, at.wo))).collect();
    let search = Search { family, bounds: Vec::clone(&bounds), points: with_pairs(STRIDE), floor };
    let solver = GeneticPolished { options: Options { evaluations: EVALUATIONS, cost_tolerance: 1e-6 } };
    let p = solver.solve(&search, &start, SEED).parameters;
    // Colours are those of all points.
    let all = Search { family, bounds, points: with_pairs(1), floor };
    let (_, Colors { kd, ks, .. }) = all.values(&p)?;
    let fit = match family.shape(&p)? {
        Shape::Gamma(shape) => {
            let shape = Gamma { kap: 1.0, ..shape };
            let normal = shape.normalised();
            let ks = ks.map(|x| (x / normal.kap).min(1e3));
            let value = move |wi, wo| {
                let lobe = normal.lobe(&Pair::new(wi, wo));
                core::array::from_fn(|c| kd[c] * FRAC_1_PI + ks[c] * lobe)
            };
            Fit::function("sgd", normal.text(kd, ks), Box::new(value))?
        }
        Shape::Groove(shape) => {
            let value = move |wi, wo| {
                let lobe = shape.lobe(&Pair::new(wi, wo));
                core::array::from_fn(|c| kd[c] * FRAC_1_PI + ks[c] * lobe)
            };
            Fit::function("abc", shape.text(kd, ks), Box::new(value))?
        }
        Shape::Lobes(_) => {
            // What ks may not be goes into the lobes.
            let most = ks.iter().copied().fold(0.0, f64::max);
            let ks = if most > 0.0 { ks.map(|x| x / most) } else { ks };
            let specular = if most > 0.0 { Some(Specular::Lafortune(lobes(&p, most)?)) } else { None };
            Fit::of(Material { kd, ks, specular })
        }
    };
    Some(fit)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measured::VIEWS;
    use brdf_tables::frame::spherical;

    /// Root mean square of relative differences of a fit from the function it was fitted to.
    fn error_of(name: &str, value: impl Fn(DVec3, DVec3) -> f64) -> f64 {
        let mut points = Vec::new();
        for (view, degrees) in VIEWS.into_iter().enumerate() {
            let wo = spherical(degrees.to_radians(), 0.0);
            for i in 0..240 {
                let theta = (f64::from(i / 12) / 20.0 + 0.02).powi(2) * 1.5;
                let half = spherical(theta, PI * (f64::from(i % 12) + 0.5) / 12.0);
                let wi = 2.0 * wo.dot(half) * half - wo;
                if wi.z > 0.05 {
                    let f = value(wi, wo);
                    points.push(Point { wi, wo, rgb: [f, 0.5 * f, 0.2], view });
                }
            }
        }
        let fit = candidate(name, &points, 1e-3).unwrap();
        let apart = |p: &Point| {
            let found = (fit.value)(p.wi, p.wo);
            (0..3).map(|c| ((found[c] - p.rgb[c]) / (p.rgb[c] + 1e-3)).powi(2)).sum::<f64>() / 3.0
        };
        let error = (points.iter().map(apart).sum::<f64>() / points.len() as f64).sqrt();
        println!("{name}: {error:.2e}, {}", fit.recipe.replace('\n', "; "));
        error
    }

    #[test]
    fn known_shapes_are_found() {
        let groove = Groove { b: 80.0, c: 1.3, ior: 1.6 };
        let abc = |wi, wo| 0.05 + 2.0 * groove.lobe(&Pair::new(wi, wo));
        assert!(error_of("abc", abc) < 1e-3);
        assert!(error_of("lobes", abc) > 0.02);
        let gamma =
            Gamma { alpha: 0.08, p: 0.9, f0: 0.4, f1: 0.05, kap: 4.0, lambda: 1.0, c: 0.3, k: 4.0, theta0: 0.2 };
        assert!(error_of("sgd", |wi, wo| 0.03 + 0.2 * gamma.lobe(&Pair::new(wi, wo))) < 0.02);
        let lobes = Lafortune::new(&[[-1.0, -1.0, 1.0, 60.0], [-0.9, -0.9, 0.8, 6.0]]).unwrap();
        assert!(error_of("lobes", |wi, wo| 0.04 + 0.1 * lobes.eval(wi, wo)) < 0.05);
    }
}
