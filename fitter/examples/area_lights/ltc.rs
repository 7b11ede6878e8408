//! Linearly transformed cosines (Heitz, Dupuy, Hill and Neubelt 2016, "Real-Time Polygonal-Light Shading with Linearly Transformed
//! Cosines"): f_r cosθ as a clamped cosine turned and stretched by a matrix, fitted view by view, with a closed form over polygons.

use brdf_tables::brdf::{Brdf, Specular};
use core::f64::consts::{FRAC_PI_2, PI, TAU};
use fitter::solver::{NelderMead, Options, Problem, Solver};
use glam::{DMat3, DVec2, DVec3, Mat3, Vec2, Vec3};
use rayon::prelude::*;

/// Views that are fitted, evenly spaced in zenith angle to the last, which is short of the horizon as in the paper.
const VIEWS: usize = 64;
const LAST: f64 = FRAC_PI_2 - 0.02;
/// Samples along each side of the squares from which directions are drawn, by the lobe and by the cosine.
const SIDE: usize = 48;
/// Vertices of the polygons that stand for discs.
const DISC: usize = 16;
/// Smallest entries of a matrix's diagonal.
const NARROWEST: f64 = 1e-4;

/// The fit of an isotropic BRDF.
pub struct Ltc {
    /// Inverse matrices by zenith angle of the view, from the frame whose x axis is below the eye, and ∫ f_r cosθ.
    views: Vec<(Mat3, f32)>,
    /// Share of √∫(f_r cosθ)² that is missed from along the normal, at two thirds of the angle to the last view, and there.
    pub missed: [f64; 3],
}

/// Directions with their f_r cosθ, and one over their density.
struct Fit {
    samples: Vec<(DVec3, f64, f64)>,
    /// ∫ f_r cosθ.
    albedo: f64,
    /// Columns: below the eye, across, and the mean direction of the lobe.
    frame: DMat3,
}

impl Fit {
    fn new(specular: &Specular, wo: DVec3) -> Self {
        let square = |i: usize| DVec2::new((i % SIDE) as f64 + 0.5, (i / SIDE) as f64 + 0.5) / SIDE as f64;
        let cosine = |u: DVec2| {
            let (r, (s, c)) = (u.x.sqrt(), (TAU * u.y).sin_cos());
            DVec3::new(r * c, r * s, (1.0 - u.x).sqrt())
        };
        let by_lobe = (0..SIDE * SIDE).filter_map(|i| specular.sample(wo, square(i)));
        let directions = by_lobe.chain((0..SIDE * SIDE).map(|i| cosine(square(i))));
        let samples: Vec<_> = directions
            .map(|wi| {
                let density = (specular.pdf(wi, wo) + wi.z / PI) * (SIDE * SIDE) as f64;
                (wi, specular.eval(wi, wo) * wi.z, density.recip())
            })
            .collect();
        let albedo = samples.iter().map(|(_, f, weight)| f * weight).sum();
        let mean: DVec3 = samples.iter().map(|(wi, f, weight)| *wi * f * weight).sum();
        let z = DVec3::new(mean.x, 0.0, mean.z).normalize_or(DVec3::Z);
        Self { samples, albedo, frame: DMat3::from_cols(DVec3::Y.cross(z), DVec3::Y, z) }
    }

    fn matrix(&self, p: &[f64]) -> DMat3 {
        self.frame
            * DMat3::from_cols(DVec3::new(p[0], 0.0, 0.0), DVec3::new(0.0, p[1], 0.0), DVec3::new(p[2], 0.0, 1.0))
    }

    /// Share of √∫(f_r cosθ)² that is missed, squared.
    fn missed(&self, p: &[f64]) -> f64 {
        let mut residuals = vec![0.0; self.samples.len()];
        self.residuals(p, &mut residuals);
        residuals.iter().map(|r| r * r).sum()
    }
}

impl Problem for Fit {
    fn parameters(&self) -> usize {
        3
    }

    fn residual_count(&self) -> usize {
        self.samples.len()
    }

    fn bounds(&self) -> &[(f64, f64)] {
        &[(NARROWEST, f64::INFINITY), (NARROWEST, f64::INFINITY), (f64::NEG_INFINITY, f64::INFINITY)]
    }

    fn residuals(&self, p: &[f64], residuals: &mut [f64]) {
        let inverse = self.matrix(p).inverse();
        let determinant = inverse.determinant().abs();
        let norm: f64 = self.samples.iter().map(|(_, f, weight)| f * f * weight).sum();
        for ((wi, f, weight), residual) in self.samples.iter().zip(residuals) {
            let back = inverse * *wi;
            let length = back.length();
            let density = back.z.max(0.0) / length / PI * determinant / length.powi(3);
            *residual = (self.albedo * density - f) * (weight / norm).sqrt();
        }
    }

    /// Nelder and Mead ask for none; by differences, for whoever does.
    fn jacobian(&self, p: &[f64], jacobian: &mut [f64]) {
        const STEP: f64 = 1e-6;
        for j in 0..3 {
            let [low, high] = [-STEP, STEP].map(|step| {
                let mut moved = p.to_vec();
                moved[j] += step;
                let mut residuals = vec![0.0; self.samples.len()];
                self.residuals(&moved, &mut residuals);
                residuals
            });
            for (i, (low, high)) in low.iter().zip(&high).enumerate() {
                jacobian[3 * i + j] = (high - low) / (2.0 * STEP);
            }
        }
    }
}

impl Ltc {
    /// Fits an isotropic model.
    pub fn new(specular: &Specular) -> Self {
        let width = specular.lobe_width();
        let solver = NelderMead { options: Options { evaluations: 2000, cost_tolerance: 1e-8 } };
        let fitted: Vec<_> = (0..VIEWS)
            .into_par_iter()
            .map(|i| {
                let (s, c) = (LAST * i as f64 / (VIEWS - 1) as f64).sin_cos();
                let fit = Fit::new(specular, DVec3::new(s, 0.0, c));
                // From the wide lobe of the model, and from one that is longer than wide.
                let starts = [[width, width, 0.0], [0.5 * width, width, 0.0], [1.0, 1.0, 0.0]];
                let best = starts.iter().map(|start| solver.solve(&fit, start, 0).parameters);
                let best = best.min_by(|a, b| fit.missed(a).total_cmp(&fit.missed(b))).expect("three starts");
                let inverse = fit.matrix(&best).inverse();
                // Only its directions count: the last entry is 1, as it is interpolated.
                let inverse = inverse * inverse.z_axis.z.recip();
                ((inverse.as_mat3(), fit.albedo as f32), fit.missed(&best))
            })
            .collect();
        let missed = [0, VIEWS * 2 / 3, VIEWS - 1].map(|i| fitted[i].1.sqrt());
        Self { views: fitted.into_iter().map(|(view, _)| view).collect(), missed }
    }

    /// To the space of the cosine, and ∫ f_r cosθ, for a local direction to the eye.
    fn transform(&self, wo: Vec3) -> (Mat3, f32) {
        let place = wo.z.clamp(-1.0, 1.0).acos() * ((VIEWS - 1) as f32 / LAST as f32);
        let i = (place as usize).min(VIEWS - 2);
        let t = (place - i as f32).min(1.0);
        let ((a, x), (b, y)) = (self.views[i], self.views[i + 1]);
        let x_axis = Vec2::new(wo.x, wo.y).try_normalize().unwrap_or(Vec2::X);
        let to_eye = Mat3::from_cols(Vec3::new(x_axis.x, -x_axis.y, 0.0), Vec3::new(x_axis.y, x_axis.x, 0.0), Vec3::Z);
        ((a * (1.0 - t) + b * t) * to_eye, x + (y - x) * t)
    }

    /// Reflected radiance of a polygon of radiance 1, whose vertices (in the local frame, as seen from the surface) run
    /// counterclockwise.
    pub fn polygon(&self, vertices: &[Vec3], wo: Vec3) -> f32 {
        let (inverse, albedo) = self.transform(wo);
        let mut clipped = [Vec3::ZERO; DISC + 4];
        let mut count = 0;
        let moved = |i: usize| inverse * vertices[i % vertices.len()];
        for i in 0..vertices.len() {
            let (a, b) = (moved(i), moved(i + 1));
            if a.z > 0.0 {
                clipped[count] = a.normalize();
                count += 1;
            }
            if (a.z > 0.0) != (b.z > 0.0) {
                clipped[count] = (a + (b - a) * (a.z / (a.z - b.z))).normalize();
                count += 1;
            }
        }
        let edges = (0..count).map(|i| edge(clipped[i], clipped[(i + 1) % count]));
        albedo * edges.sum::<f32>().abs()
    }

    /// The same of all directions within `sigma` of an axis, as a polygon of as much solid angle.
    pub fn cap(&self, axis: Vec3, sigma: f32, wo: Vec3) -> f32 {
        let (x, y) = axis.any_orthonormal_pair();
        // On the plane before the axis, a regular polygon has the area of its disc at this radius.
        let step = core::f32::consts::TAU / DISC as f32;
        let radius = sigma.tan() * (step / step.sin()).sqrt();
        let vertices: [Vec3; DISC] = core::array::from_fn(|i| {
            let (s, c) = (step * i as f32).sin_cos();
            axis + (x * c + y * s) * radius
        });
        self.polygon(&vertices, wo)
    }
}

/// The share of an edge in the form factor of a polygon; its angle over 2π and its sine by the approximation of the authors' shader.
fn edge(a: Vec3, b: Vec3) -> f32 {
    let x = a.dot(b);
    let y = x.abs();
    let v = (0.854_398_5 + (0.496_515_5 + 0.014_520_6 * y) * y) / (3.417_594 + (4.161_672_4 + y) * y);
    let angle = if x > 0.0 { v } else { 0.5 * (1.0 - x * x).max(1e-7).sqrt().recip() - v };
    angle * (a.x * b.y - a.y * b.x)
}
