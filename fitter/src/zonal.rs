//! The integrals behind the zonal table: the mean of a radial cosine lobe over a cap as integrals around the rim.
//!
//! For ∫ over the cap of (w·m)₊ⁿ m dm = P c + R (w − c cos δ) (m mirrored directions, c the mirrored axis, δ its angle to
//! w), Stokes' theorem turns P and R into integrals over the rim t(ψ) = cos δ cos σ + sin δ sin σ cos ψ:
//!   J₀ = ∮ t₊ⁿ dψ,  J₁ = ∮ t₊ⁿ cos ψ dψ,  T = ∮ (1 − t₊ⁿ)/(1 − t²) (sin²σ cos δ − sin σ cos σ sin δ cos ψ) dψ,
//!   P = (T cos δ + sin²σ J₀)/(n+2),  R = (T − sin σ cos σ J₁ / sin δ)/(n+2).

use brdf_tables::brdf::Specular;
use brdf_tables::cap::Cap;
use brdf_tables::frame::mirror;
use brdf_tables::gauss::gauss_legendre;
use brdf_tables::zonal::{Zonal, ZonalAxes};
use core::f64::consts::{FRAC_PI_2, PI};
use glam::DVec3;
use rayon::prelude::*;
use std::sync::LazyLock;

/// Points of a Gauss–Legendre panel of the rim.
const PANEL: usize = 16;

/// (1 − tⁿ)/(1 − t²) for t ∈ (0, 1], n/2 at t = 1.
fn quotient(t: f64, n: f64) -> f64 {
    let log = t.ln();
    if log > -1e-12 { 0.5 * n } else { (n * log).exp_m1() / (2.0 * log).exp_m1() }
}

/// P(δ, σ) and R(δ, σ) for the exponent `n`, to about 1e-12 of P(0, σ). Angles in radian.
pub fn rim_integrals(n: f64, delta: f64, sigma: f64) -> (f64, f64) {
    // The half sphere may come as a little more, whose negative cosine has no power.
    let (sr, cr) = (sigma.sin(), sigma.cos().max(0.0));
    if delta < 1e-9 {
        let p = 2.0 * PI * (1.0 - cr.powf(n + 2.0)) / (n + 2.0);
        let r = (2.0 * PI * (1.0 - cr.powf(n)) - n * PI * sr * sr * cr.powf(n)) / (n + 2.0);
        return (p, r);
    }
    if delta - sigma >= FRAC_PI_2 {
        return (0.0, 0.0);
    }
    let (sd, cd) = delta.sin_cos();
    let nodes = 48 + (14.0 * n.sqrt() * sr) as usize;
    let (mut j0, mut j1, mut t) = (0.0, 0.0, 0.0);
    let mut add = |psi: f64, weight: f64| {
        let c = psi.cos();
        let x = (cd * cr + sd * sr * c).min(1.0);
        if x > 0.0 {
            let power = x.powf(n);
            j0 += weight * power;
            j1 += weight * power * c;
            t += weight * quotient(x, n) * (sr * sr * cd - sr * cr * sd * c);
        }
    };
    // Half the rim, doubled: it is symmetric in ψ.
    if delta + sigma <= FRAC_PI_2 {
        for i in 0..nodes {
            add(PI * (i as f64 + 0.5) / nodes as f64, 2.0 * PI / nodes as f64);
        }
    } else {
        // Part of the rim is below the horizon of w: Gauss–Legendre on panels of the lit arc, the rest of T in closed form.
        static RULE: LazyLock<Vec<(f64, f64)>> = LazyLock::new(|| gauss_legendre(PANEL));
        let lit = (-(cd * cr) / (sd * sr)).clamp(-1.0, 1.0).acos();
        let panels = nodes.div_ceil(PANEL);
        for panel in 0..panels {
            for (x, w) in RULE.iter() {
                add(lit * (panel as f64 + 0.5 * (x + 1.0)) / panels as f64, lit * w / panels as f64);
            }
        }
        let beta = (sr * lit.sin()).atan2(sr * lit.cos() * cd - cr * sd);
        t += 2.0 * (PI - beta);
    }
    ((t * cd + sr * sr * j0) / (n + 2.0), (t - sr * cr * j1 / sd) / (n + 2.0))
}

/// Mean of a max(0, cos α)ⁿ over a cap that does not cross the horizon, in sr⁻¹: the closed form of eq. 9 for modified
/// Phong, to about 1e-12 of its peak. `None` for a clipped cap.
pub fn radial_mean((a, n): (f64, f64), cap: &Cap, wo: DVec3) -> Option<f64> {
    let (sigma, cz) = (cap.half_angle(), cap.axis().z);
    if cap.theta() + sigma > FRAC_PI_2 + 1e-9 {
        return None;
    }
    let chord = 0.5 * (wo - mirror(cap.axis())).length();
    let delta = 2.0 * chord.min(1.0).asin();
    let (p, r) = rim_integrals(n, delta, sigma);
    Some(a * (p * cz + r * (wo.z - cz * delta.cos())) / cap.projected_solid_angle())
}

/// Builds the zonal table of a radial model; `None` when the model is not radial.
pub fn build(specular: Specular, rows: usize, columns: usize) -> Option<Zonal> {
    let values = tabulate(&specular, rows, columns)?;
    let scale = scale(&values);
    Zonal::new(specular, rows, columns, pack(&values, scale), scale).ok()
}

/// (T_P, T_R) at the nodes of the zonal table of a radial model; `None` when the model is not radial.
pub(crate) fn tabulate(specular: &Specular, rows: usize, columns: usize) -> Option<Vec<(f64, f64)>> {
    let (_, n) = specular.radial_exponent()?;
    let axes = ZonalAxes::new(n);
    let values: Vec<(f64, f64)> = (0..rows * columns)
        .into_par_iter()
        .map(|i| {
            // A cap of radius zero has the limit of a tiny one.
            let u = ((i / columns) as f64 / (rows - 1) as f64).max(1e-5);
            let (sigma, delta) = axes.angles(u, (i % columns) as f64 / (columns - 1) as f64);
            let (p, r) = rim_integrals(n, delta, sigma);
            let peak = rim_integrals(n, 0.0, sigma).0;
            // P c + R (w − c cos δ) = (P − R cos δ) c + R w
            ((p - r * delta.cos()) / peak, r / peak)
        })
        .collect();
    Some(centred(&values, rows, columns))
}

/// Offsets and steps that hold all of the values in 16 bits each.
pub(crate) fn scale(values: &[(f64, f64)]) -> [[f64; 2]; 2] {
    let range = |pick: fn(&(f64, f64)) -> f64| {
        let (lo, hi) = values.iter().map(pick).fold((0f64, 0f64), |(lo, hi), x| (lo.min(x), hi.max(x)));
        [lo, (hi - lo).max(f64::MIN_POSITIVE) / 65535.0]
    };
    [range(|v| v.0), range(|v| v.1)]
}

/// The cells of a table.
pub(crate) fn pack(values: &[(f64, f64)], scale: [[f64; 2]; 2]) -> Vec<u32> {
    let pack = |x: f64, [lo, step]: [f64; 2]| ((x - lo) / step).round().clamp(0.0, 65535.0) as u32;
    values.iter().map(|&(p, r)| pack(p, scale[0]) | pack(r, scale[1]) << 16).collect()
}

/// Nodes moved so that the bilinear interpolant is right on average over each cell, not at its corners: a line between
/// exact values of a convex function lies above it, by h²f″/12 in the mean, and the excess of all cells adds up in the
/// energy. Halves the error of a smooth function too.
fn centred(values: &[(f64, f64)], rows: usize, columns: usize) -> Vec<(f64, f64)> {
    let bend = |i: usize, step: usize, inner: bool, pick: fn(&(f64, f64)) -> f64| {
        if inner { pick(&values[i - step]) - 2.0 * pick(&values[i]) + pick(&values[i + step]) } else { 0.0 }
    };
    let moved = |i: usize, pick: fn(&(f64, f64)) -> f64| {
        let (row, column) = (i / columns, i % columns);
        let across = bend(i, columns, row > 0 && row + 1 < rows, pick);
        let along = bend(i, 1, column > 0 && column + 1 < columns, pick);
        let value = pick(&values[i]);
        let shifted = value - (across + along) / 12.0;
        // Nothing may fall below zero in the tail.
        if value >= 0.0 { shifted.max(0.0) } else { shifted }
    };
    (0..values.len()).map(|i| (moved(i, |v| v.0), moved(i, |v| v.1))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use brdf_tables::frame::{basis, spherical};
    use core::f64::consts::TAU;

    /// P and R by a product rule over the cap: the projections of ∫ (w·m)₊ⁿ m dm on the axis and on what of w is normal to it.
    #[test]
    fn rim_integrals_match_the_area() {
        let rule = gauss_legendre(60);
        for n in [1.0, 2.0, 7.0, 50.0, 400.0] {
            for (delta, sigma) in [(0.0, 0.4), (0.3, 0.2), (0.5, 0.5), (1.2, 0.3), (1.4, 0.8), (0.9, 1.5), (2.0, 0.7)] {
                let frame = basis(DVec3::Z);
                let w = spherical(delta, 0.0);
                let (mut along, mut across) = (0.0, 0.0);
                let spokes = 2000;
                for &(x, weight) in &rule {
                    let beta = 0.5 * sigma * (x + 1.0);
                    for spoke in 0..spokes {
                        let m = frame * spherical(beta, TAU * (f64::from(spoke) + 0.5) / f64::from(spokes));
                        let term =
                            0.5 * sigma * weight * beta.sin() * w.dot(m).max(0.0).powf(n) * TAU / f64::from(spokes);
                        along += term * m.z;
                        across += term * m.x;
                    }
                }
                let (p, r) = rim_integrals(n, delta, sigma);
                let peak = rim_integrals(n, 0.0, sigma).0;
                // V = P c + R (w − c cos δ): the part of w across c has length sin δ. The kink of n = 1 limits the rule.
                let bound = if n < 2.0 { 3e-4 } else { 2e-6 } * peak;
                assert!((p - along).abs() < bound, "n {n} delta {delta} sigma {sigma}: P {p} {along}");
                assert!((r * delta.sin() - across).abs() < bound, "n {n} delta {delta} sigma {sigma}: R {r} {across}");
            }
        }
    }

    /// Half a sphere whose angle is rounded up is one.
    #[test]
    fn half_a_sphere_has_integrals() {
        for n in [1.3, 1.5064635056831326, 7.7] {
            for delta in [0.0, 0.4, 1.5] {
                let at = |sigma| rim_integrals(n, delta, sigma);
                let (exact, above) = (at(FRAC_PI_2 - 1e-12), at(FRAC_PI_2 + 4e-16));
                assert!((exact.0 - above.0).abs() < 1e-9 && (exact.1 - above.1).abs() < 1e-9, "{n} {delta}: {above:?}");
            }
        }
    }

    /// P does not jump where δ vanishes or the rim dips below the horizon of w.
    #[test]
    fn rim_integrals_are_continuous() {
        for n in [1.0, 30.0, 1e4] {
            for (delta, sigma) in [(1e-9, 0.3), (FRAC_PI_2 - 0.4, 0.4), (FRAC_PI_2 + 0.4, 0.4)] {
                let peak = rim_integrals(n, 0.0, sigma).0;
                let (below, above) = (rim_integrals(n, delta - 1e-10, sigma), rim_integrals(n, delta + 1e-10, sigma));
                assert!((below.0 - above.0).abs() < 1e-7 * peak, "n {n}: P {below:?} {above:?}");
                assert!((below.1 - above.1).abs() < 1e-4 * peak, "n {n}: R {below:?} {above:?}");
            }
        }
    }
}
