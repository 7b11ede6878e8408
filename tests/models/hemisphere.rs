//! Adaptive quadrature over the hemisphere, on cells graded towards the mirror direction.

use brdf_tables::brdf::Specular;
use brdf_tables::frame::{mirror, spherical};
use brdf_tables::gauss::gauss_legendre;
use core::f64::consts::{FRAC_PI_2, PI};
use glam::DVec3;
use std::sync::LazyLock;

/// Cell edges in zenith angle and azimuth, ascending.
pub struct Grid {
    pub theta: Vec<f64>,
    pub phi: Vec<f64>,
}

/// `[low, high]` of zenith angle and azimuth.
pub type Cell = [[f64; 2]; 2];

static RULE: LazyLock<Vec<(f64, f64)>> = LazyLock::new(|| gauss_legendre(6));

impl Grid {
    /// Edges at distances that double from half the lobe's width around the mirror direction of `wo`.
    pub fn around_mirror(specular: &Specular, wo: DVec3) -> Self {
        let axis = mirror(wo);
        let (theta, phi) = (axis.z.acos(), axis.y.atan2(axis.x));
        let width = specular.lobe_width();
        let graded = |centre: f64, width: f64, low: f64, high: f64| {
            let steps = (0..12).map(|k| width * 0.5 * f64::from(1 << k));
            let mut edges: Vec<f64> = steps.flat_map(|d| [centre - d, centre + d]).collect();
            edges.push(centre);
            edges.retain(|&e| e > low + 1e-3 * width && e < high - 1e-3 * width);
            edges.extend([low, high]);
            edges.sort_by(f64::total_cmp);
            edges
        };
        Self {
            theta: graded(theta, width, 0.0, FRAC_PI_2),
            phi: graded(phi, width / theta.sin().max(width), phi - PI, phi + PI),
        }
    }

    pub fn cells(&self) -> impl Iterator<Item = Cell> {
        self.theta.windows(2).flat_map(|t| self.phi.windows(2).map(|p| [[t[0], t[1]], [p[0], p[1]]]))
    }

    /// Which of [`Grid::cells`] holds `w`.
    pub fn find(&self, w: DVec3) -> usize {
        let theta = w.z.clamp(-1.0, 1.0).acos();
        let phi = w.y.atan2(w.x);
        let phi = self.phi[0] + (phi - self.phi[0]).rem_euclid(2.0 * PI);
        let interval = |edges: &[f64], x: f64| edges[1..edges.len() - 1].partition_point(|&e| e <= x);
        interval(&self.theta, theta) * (self.phi.len() - 1) + interval(&self.phi, phi)
    }
}

/// ∫ f dw over `cell`, split until a split changes the result by less than `tolerance`.
pub fn integrate(f: &dyn Fn(DVec3) -> f64, cell: Cell, tolerance: f64) -> f64 {
    refine(f, cell, gauss(f, cell), tolerance, 12)
}

fn refine(f: &dyn Fn(DVec3) -> f64, [[t0, t1], [p0, p1]]: Cell, whole: f64, tolerance: f64, depth: u32) -> f64 {
    let (t, p) = (0.5 * (t0 + t1), 0.5 * (p0 + p1));
    let parts = [[[t0, t], [p0, p]], [[t0, t], [p, p1]], [[t, t1], [p0, p]], [[t, t1], [p, p1]]];
    let values = parts.map(|part| gauss(f, part));
    let sum: f64 = values.iter().sum();
    if depth == 0 || (sum - whole).abs() <= tolerance {
        return sum;
    }
    parts.iter().zip(values).map(|(&part, value)| refine(f, part, value, tolerance, depth - 1)).sum()
}

fn gauss(f: &dyn Fn(DVec3) -> f64, [[t0, t1], [p0, p1]]: Cell) -> f64 {
    let (half_t, half_p) = (0.5 * (t1 - t0), 0.5 * (p1 - p0));
    let mut sum = 0.0;
    for &(x, wx) in RULE.iter() {
        let theta = t0 + half_t * (1.0 + x);
        for &(y, wy) in RULE.iter() {
            sum += wx * wy * theta.sin() * f(spherical(theta, p0 + half_p * (1.0 + y)));
        }
    }
    sum * half_t * half_p
}

/// ∫ f_r(wi, wo) cosᵢ dwi.
pub fn albedo(specular: &Specular, wo: DVec3) -> f64 {
    use brdf_tables::brdf::Brdf;
    let f = |wi: DVec3| specular.eval(wi, wo) * wi.z;
    Grid::around_mirror(specular, wo).cells().map(|cell| integrate(&f, cell, 1e-7)).sum()
}

/// The rule integrates a steep known function, so that the tests that use it test the models.
#[test]
fn known_integrals() {
    let specular = super::examples().next().unwrap().1;
    let grid = Grid::around_mirror(&specular, spherical(0.7, 0.2));
    let steep = |w: DVec3| w.z.powi(1000);
    let sum: f64 = grid.cells().map(|cell| integrate(&steep, cell, 1e-9)).sum();
    assert!((sum - 2.0 * PI / 1001.0).abs() < 1e-8, "{sum}");
    for (at, [[t0, t1], [p0, p1]]) in grid.cells().enumerate() {
        assert_eq!(grid.find(spherical(0.5 * (t0 + t1), 0.5 * (p0 + p1))), at);
    }
}
