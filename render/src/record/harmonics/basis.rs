//! Real orthonormal harmonics: on the sphere, and on the hemisphere by shifted Legendre functions (Gautron et al. 2004).
//!
//! Order n means the bands l = 0 … n − 1, n² functions. Inside this module functions are *packed*: a row of cosine terms
//! (m = 0 … l) per band, padded to whole vectors, and as many sine terms (m = −1 … −l stand at 1 … l). Outside, in records,
//! coefficients are *compact*: band l starts at l², its cosine terms first, then its sine terms.

use core::f64::consts::PI;
use glam::{DVec3, Vec3A};
use std::sync::OnceLock;

/// Largest order of a record, as in the papers: 841 coefficients.
pub const MAX_ORDER: usize = 29;

/// Bands that a hemispherical function is spread over when it is turned.
pub(super) const BANDS: usize = 40;

/// Lanes that rows are padded to.
pub(super) const LANES: usize = 8;

/// Longest padded row.
pub(super) const WIDTH: usize = BANDS.next_multiple_of(LANES);

/// Numbers of all rows of cosine or of sine terms.
pub(super) const PACKED: usize = row(BANDS);

/// All cosine terms, or all sine terms.
pub(super) type Rows = [f32; PACKED];

/// One number for every m.
pub(super) type PerM = [f32; WIDTH];

/// Which functions.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Basis {
    /// Hemispherical harmonics in the frame of the record: Legendre functions of 2cosθ − 1.
    #[default]
    Hemispherical,
    /// Spherical harmonics in the frame of the world, of light that is zero below the horizon (Křivánek 2005, §6.2).
    Spherical,
}

/// Padded length of row l.
pub(super) const fn row_length(l: usize) -> usize {
    (l + 1).next_multiple_of(LANES)
}

/// Place of row l: the rows before it come in groups of eight of one length.
pub(super) const fn row(l: usize) -> usize {
    let (q, r) = (l / LANES, l % LANES);
    LANES * (LANES * q * (q + 1) / 2 + r * (q + 1))
}

/// Row l of packed numbers as whole vectors, so that loops over them need no test of their bounds.
#[inline(always)]
pub(super) fn vectors(rows: &[f32], l: usize) -> &[[f32; LANES]] {
    rows[row(l)..row(l) + row_length(l)].as_chunks().0
}

/// The same, to write to.
#[inline(always)]
pub(super) fn vectors_mut(rows: &mut [f32], l: usize) -> &mut [[f32; LANES]] {
    rows[row(l)..row(l) + row_length(l)].as_chunks_mut().0
}

impl Basis {
    /// Argument of the Legendre functions, its sine, and the factor that makes the functions orthonormal on their domain.
    /// `rho2` is x² + y² of the direction.
    #[inline(always)]
    pub(super) fn argument(self, z: f32, rho2: f32) -> (f32, f32, f32) {
        match self {
            Self::Hemispherical => {
                let z = z.clamp(0.0, 1.0);
                (2.0 * z - 1.0, 2.0 * (z * rho2 / (1.0 + z)).sqrt(), core::f32::consts::SQRT_2)
            }
            Self::Spherical => (z, rho2.sqrt(), 1.0),
        }
    }

    /// One function at a unit direction by the textbook formula: slow, the twin that tests and tables are made with.
    /// `m` < 0 are the sine terms.
    pub fn value(self, l: usize, m: i32, direction: DVec3) -> f64 {
        let (x, scale) = match self {
            Self::Hemispherical if direction.z < 0.0 => return 0.0,
            Self::Hemispherical => (2.0 * direction.z - 1.0, core::f64::consts::SQRT_2),
            Self::Spherical => (direction.z, 1.0),
        };
        let order = m.unsigned_abs() as usize;
        let azimuth = f64::from(m.unsigned_abs()) * direction.y.atan2(direction.x);
        let turn = match m {
            0 => 1.0,
            1.. => core::f64::consts::SQRT_2 * azimuth.cos(),
            _ => core::f64::consts::SQRT_2 * azimuth.sin(),
        };
        scale * turn * legendre(l, order, x.clamp(-1.0, 1.0))
    }

    /// Values of all functions at a unit direction, compact.
    pub fn values(self, order: usize, direction: Vec3A) -> Vec<f32> {
        let mut rows = [0.0; PACKED];
        let rho2 = direction.x * direction.x + direction.y * direction.y;
        let (x, sine, scale) = self.argument(direction.z, rho2);
        legendre_rows(order, x, sine, scale, &mut rows);
        let [cos, sin] = azimuths(direction);
        let mut out = vec![0.0; order * order];
        for l in 0..order {
            for m in 0..=l {
                out[l * l + m] = rows[row(l) + m] * cos[m];
            }
            for m in 1..=l {
                out[l * l + l + m] = rows[row(l) + m] * sin[m];
            }
        }
        out
    }
}

/// P̄ₗᵐ(x) with ∫ (P̄ₗᵐ)² dω = 1 over the sphere, without the Condon–Shortley sign; the factor √2 of m ≠ 0 left out.
pub(super) fn legendre(l: usize, m: usize, x: f64) -> f64 {
    if m > l {
        return 0.0;
    }
    let sine = (1.0 - x * x).max(0.0).sqrt();
    let diagonal = (1..=m).fold((1.0 / (4.0 * PI)).sqrt(), |p, m| p * sine * (1.0 + 0.5 / m as f64).sqrt());
    let (mut before, mut p) = (0.0, diagonal);
    for k in m + 1..=l {
        (before, p) = (p, step(k, m) * (x * p - back(k, m) * before));
    }
    p
}

/// P̄ₗᵐ = step · (x P̄ₗ₋₁ᵐ − back · P̄ₗ₋₂ᵐ).
fn step(l: usize, m: usize) -> f64 {
    let (l2, m2) = ((l * l) as f64, (m * m) as f64);
    ((4.0 * l2 - 1.0) / (l2 - m2)).sqrt()
}

fn back(l: usize, m: usize) -> f64 {
    let (k2, m2) = (((l - 1) * (l - 1)) as f64, (m * m) as f64);
    ((k2 - m2).max(0.0) / (4.0 * k2 - 1.0).max(1.0)).sqrt()
}

/// Factors of the recurrences, packed.
struct Recurrence {
    step: Rows,
    back: Rows,
    /// (1 − x²) dP̄ₗᵐ/dx = −l x P̄ₗᵐ + slope · P̄ₗ₋₁ᵐ.
    slope: Rows,
    /// P̄ₗˡ = diagonal · sine · P̄ₗ₋₁ˡ⁻¹.
    diagonal: PerM,
}

fn recurrence() -> &'static Recurrence {
    static TABLE: OnceLock<Recurrence> = OnceLock::new();
    TABLE.get_or_init(|| {
        let zero = [0.0; PACKED];
        let mut table = Recurrence { step: zero, back: zero, slope: zero, diagonal: [0.0; WIDTH] };
        table.diagonal[0] = (1.0 / (4.0 * PI)).sqrt() as f32;
        for l in 1..BANDS {
            table.diagonal[l] = (1.0 + 0.5 / l as f64).sqrt() as f32;
            for m in 0..l {
                let (lf, mf) = (l as f64, m as f64);
                table.step[row(l) + m] = step(l, m) as f32;
                table.back[row(l) + m] = back(l, m) as f32;
                table.slope[row(l) + m] = ((2.0 * lf + 1.0) * (lf - mf) * (lf + mf) / (2.0 * lf - 1.0)).sqrt() as f32;
            }
        }
        table
    })
}

/// Rows of scale · P̄ₗᵐ(x) for the bands below `order`.
#[inline(always)]
pub(super) fn legendre_rows(order: usize, x: f32, sine: f32, scale: f32, out: &mut Rows) {
    let table = recurrence();
    let (mut one, mut two) = ([0f32; WIDTH], [0f32; WIDTH]);
    let mut diagonal = scale;
    for l in 0..order {
        diagonal *= table.diagonal[l] * if l > 0 { sine } else { 1.0 };
        let factors = vectors(&table.step, l).iter().zip(vectors(&table.back, l));
        let values = one.as_chunks_mut::<LANES>().0.iter_mut().zip(two.as_chunks_mut::<LANES>().0);
        for ((step, back), (one, two)) in factors.zip(values) {
            for i in 0..LANES {
                let now = step[i] * (x * one[i] - back[i] * two[i]);
                (two[i], one[i]) = (one[i], now);
            }
        }
        one[l] = diagonal;
        out[row(l)..row(l) + row_length(l)].copy_from_slice(&one[..row_length(l)]);
    }
}

/// Rows of `factor` · (1 − x²) dP̄ₗᵐ/dx, from those of P̄ₗᵐ.
#[inline(always)]
pub(super) fn slope_rows(order: usize, x: f32, factor: f32, rows: &Rows, out: &mut Rows) {
    let table = recurrence();
    let mut before = [0f32; WIDTH];
    for l in 0..order {
        let lx = l as f32 * x;
        let (before, slopes) = (before.as_chunks_mut::<LANES>().0, vectors(&table.slope, l));
        let values = vectors(rows, l).iter().zip(vectors_mut(out, l));
        for ((slope, before), (p, out)) in slopes.iter().zip(before).zip(values) {
            for i in 0..LANES {
                out[i] = factor * (slope[i] * before[i] - lx * p[i]);
                before[i] = p[i];
            }
        }
    }
}

/// cos mφ and sin mφ of a direction's azimuth, times √2 for m ≠ 0.
#[inline(always)]
pub(super) fn azimuths(direction: Vec3A) -> [PerM; 2] {
    let rho = (direction.x * direction.x + direction.y * direction.y).sqrt();
    let (c, s) = if rho > 1e-20 { (direction.x / rho, direction.y / rho) } else { (1.0, 0.0) };
    let [mut cos, mut sin] = multiples(c, s);
    for m in 1..WIDTH {
        cos[m] *= core::f32::consts::SQRT_2;
        sin[m] *= core::f32::consts::SQRT_2;
    }
    [cos, sin]
}

/// cos mφ and sin mφ, given those of φ. Doubling m keeps the chain of roundings short.
#[inline(always)]
pub(super) fn multiples(c: f32, s: f32) -> [PerM; 2] {
    let (mut cos, mut sin) = ([0f32; WIDTH], [0f32; WIDTH]);
    (cos[0], cos[1], sin[1]) = (1.0, c, s);
    for m in 2..WIDTH {
        let (a, b) = (m / 2, m - m / 2);
        cos[m] = cos[a] * cos[b] - sin[a] * sin[b];
        sin[m] = sin[a] * cos[b] + cos[a] * sin[b];
    }
    [cos, sin]
}

#[cfg(test)]
mod tests {
    use super::*;
    use brdf_tables::gauss::gauss_legendre;
    use glam::DVec3;

    const BASES: [Basis; 2] = [Basis::Hemispherical, Basis::Spherical];

    /// Nodes and weights over the domain of a basis: exact for products of two functions.
    fn rule(basis: Basis) -> Vec<(DVec3, f64)> {
        let azimuths = 2 * MAX_ORDER + 2;
        let mut nodes = Vec::new();
        for (x, weight) in gauss_legendre(MAX_ORDER + 1) {
            let (z, share) = if basis == Basis::Hemispherical { (0.5 * (x + 1.0), 0.5) } else { (x, 1.0) };
            for k in 0..azimuths {
                let (s, c) = (2.0 * PI * k as f64 / azimuths as f64).sin_cos();
                let r = (1.0 - z * z).sqrt();
                nodes.push((DVec3::new(r * c, r * s, z), weight * share * 2.0 * PI / azimuths as f64));
            }
        }
        nodes
    }

    /// All 841 functions of either basis, against each other: to 1e-4 in single precision.
    #[test]
    fn functions_are_orthonormal() {
        for basis in BASES {
            let count = MAX_ORDER * MAX_ORDER;
            let rows: Vec<(Vec<f32>, f64)> =
                rule(basis).into_iter().map(|(d, w)| (basis.values(MAX_ORDER, d.as_vec3a()), w)).collect();
            let mut worst = 0f64;
            // Every function with itself, its neighbours in the list, and some far away.
            for i in 0..count {
                for j in (i..(i + 4).min(count)).chain((i..count).step_by(97)) {
                    let sum: f64 = rows.iter().map(|(v, w)| w * f64::from(v[i]) * f64::from(v[j])).sum();
                    worst = worst.max((sum - if i == j { 1.0 } else { 0.0 }).abs());
                }
            }
            println!("{basis:?}: orthonormal to {worst:.1e}");
            assert!(worst < 1e-4, "{basis:?} {worst}");
        }
    }

    /// The vector recurrences agree with the textbook formula, poles and horizon included.
    #[test]
    fn fast_values_agree_with_the_formula() {
        let heights = [1.0, 1.0 - 1e-7, 0.99, 0.7, 0.31, 0.02, 1e-6, 0.0];
        for basis in BASES {
            for (i, z) in heights.into_iter().enumerate() {
                let (s, c) = (1.3 + 0.9 * i as f64).sin_cos();
                let r = (1.0f64 - z * z).sqrt();
                let d = DVec3::new(r * c, r * s, z);
                let fast = basis.values(MAX_ORDER, d.as_vec3a());
                for l in 0..MAX_ORDER {
                    for m in -(l as i32)..=l as i32 {
                        let at = if m >= 0 { l * l + m as usize } else { l * l + l + m.unsigned_abs() as usize };
                        let exact = basis.value(l, m, d);
                        assert!(
                            (f64::from(fast[at]) - exact).abs() < 2e-4,
                            "{basis:?} {l} {m} {z}: {} {exact}",
                            fast[at]
                        );
                    }
                }
            }
        }
    }

    /// The first bands as the papers print them.
    #[test]
    fn low_orders_have_their_closed_forms() {
        let d = DVec3::new(0.48, 0.6, 0.64);
        let (theta, phi) = (d.z.acos(), d.y.atan2(d.x));
        let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-12, "{a} {b}");
        let y = |l, m| Basis::Spherical.value(l, m, d);
        close(y(0, 0), 0.5 / PI.sqrt());
        close(y(1, 0), (3.0 / (4.0 * PI)).sqrt() * d.z);
        close(y(1, 1), (3.0 / (4.0 * PI)).sqrt() * d.x);
        close(y(1, -1), (3.0 / (4.0 * PI)).sqrt() * d.y);
        close(y(2, -2), (15.0 / (4.0 * PI)).sqrt() * d.x * d.y);
        close(y(2, 0), (5.0 / (16.0 * PI)).sqrt() * (3.0 * d.z * d.z - 1.0));
        // Gautron et al. 2004, eqs. for l ≤ 1.
        let h = |l, m| Basis::Hemispherical.value(l, m, d);
        close(h(0, 0), 1.0 / (2.0 * PI).sqrt());
        close(h(1, 0), (3.0 / (2.0 * PI)).sqrt() * (2.0 * d.z - 1.0));
        let side = (3.0 / (2.0 * PI)).sqrt() * 2.0 * (theta.cos() - theta.cos().powi(2)).sqrt();
        close(h(1, 1), side * phi.cos());
        close(h(1, -1), side * phi.sin());
        close(Basis::Hemispherical.value(3, 2, -d), 0.0);
    }

    /// dP̄/dx by the recurrence against differences of the formula.
    #[test]
    fn slopes_agree_with_differences() {
        let (mut rows, mut slopes) = ([0.0; PACKED], [0.0; PACKED]);
        for x in [-0.97, -0.4, 0.0, 0.33, 0.98] {
            let sine = (1.0f64 - x * x).sqrt();
            legendre_rows(MAX_ORDER, x as f32, sine as f32, 1.0, &mut rows);
            slope_rows(MAX_ORDER, x as f32, 1.0, &rows, &mut slopes);
            for l in 0..MAX_ORDER {
                for m in 0..=l {
                    let h = 1e-6;
                    let exact = (1.0 - x * x) * (legendre(l, m, x + h) - legendre(l, m, x - h)) / (2.0 * h);
                    assert!((f64::from(slopes[row(l) + m]) - exact).abs() < 1e-3, "{l} {m} {x}");
                }
            }
        }
    }

    #[test]
    fn rows_follow_one_another() {
        for l in 0..BANDS {
            assert_eq!(row(l + 1), row(l) + row_length(l));
        }
    }
}
