//! Turning functions: spherical harmonics exactly, hemispherical ones by way of them.
//!
//! Any rotation is Rz(a) Ry(β) Rz(c), and Ry(β) = Rz(90°) Ry(90°) Rz(β + 180°) Ry(90°) Rz(90°). Turns about z are a cosine and
//! a sine for each m, and the quarter turn about y is one constant matrix per band: n³/3 products of cosine terms, as many of
//! sine terms, and twice that in all. The constants come from the recurrences of Ivanic and Ruedenberg (1996, corrected 1998).

use super::basis::{BANDS, LANES, PerM, WIDTH, multiples, row_length, vectors_mut};
use super::projection::Sum;
use core::cmp::Ordering;
use glam::{DMat3, Mat3A};
use std::sync::OnceLock;

/// A rotation, ready to be applied to functions of any order.
pub(super) struct Rotation {
    /// cos and sin of m(c + 90°), m(β + 180°), m(a + 90°).
    turns: [[PerM; 2]; 3],
}

impl Rotation {
    /// From its matrix: (Rf)(ω) = f(R⁻¹ω).
    #[inline(always)]
    pub(super) fn new(matrix: Mat3A) -> Self {
        let (x, y, z) = (matrix.x_axis, matrix.y_axis, matrix.z_axis);
        let sine = (z.x * z.x + z.y * z.y).sqrt();
        let ((ca, sa), (cc, sc)) = if sine > 1e-6 {
            ((z.x / sine, z.y / sine), (-x.z / sine, y.z / sine))
        } else {
            // About z alone, perhaps upside down.
            ((x.x * z.z.signum(), x.y * z.z.signum()), (1.0, 0.0))
        };
        Self { turns: [multiples(-sc, cc), multiples(-z.z, -sine), multiples(-sa, ca)] }
    }

    /// Turns a spherical function of `bands` bands.
    #[inline(always)]
    pub(super) fn apply(&self, bands: usize, f: &mut Sum) {
        about_z(bands, f, &self.turns[0]);
        quarter(bands, f);
        about_z(bands, f, &self.turns[1]);
        quarter(bands, f);
        about_z(bands, f, &self.turns[2]);
    }
}

/// Turns by an angle about z, given the cosines and sines of its multiples; right for either basis.
#[inline(always)]
pub(super) fn about_z(bands: usize, f: &mut Sum, [c, s]: &[PerM; 2]) {
    let [cos, sin] = f;
    let (c, s) = (c.as_chunks::<LANES>().0, s.as_chunks::<LANES>().0);
    for l in 0..bands {
        let terms = vectors_mut(cos, l).iter_mut().zip(vectors_mut(sin, l));
        for ((cos, sin), (c, s)) in terms.zip(c.iter().zip(s)) {
            let (x, y) = (*cos, *sin);
            *cos = core::array::from_fn(|i| x[i] * c[i] - y[i] * s[i]);
            *sin = core::array::from_fn(|i| x[i] * s[i] + y[i] * c[i]);
        }
    }
}

/// Turns by 90° about y.
#[inline(always)]
fn quarter(bands: usize, f: &mut Sum) {
    for (f, columns) in f.iter_mut().zip(quarter_columns()) {
        for l in 0..bands {
            let columns = &columns[column(l, 0)..column(l + 1, 0)];
            match row_length(l) / LANES {
                1 => quarter_band::<1>(columns, vectors_mut(f, l)),
                2 => quarter_band::<2>(columns, vectors_mut(f, l)),
                3 => quarter_band::<3>(columns, vectors_mut(f, l)),
                4 => quarter_band::<4>(columns, vectors_mut(f, l)),
                _ => quarter_band::<{ WIDTH / LANES }>(columns, vectors_mut(f, l)),
            }
        }
    }
}

/// A matrix of columns of N vectors times a row: the sums stay in registers.
#[inline(always)]
fn quarter_band<const N: usize>(columns: &[[f32; LANES]], row: &mut [[f32; LANES]]) {
    let mut out = [[0f32; LANES]; N];
    for (column, x) in columns.as_chunks::<N>().0.iter().zip(row.as_flattened()) {
        for (out, column) in out.iter_mut().zip(column) {
            for i in 0..LANES {
                out[i] += column[i] * x;
            }
        }
    }
    row.copy_from_slice(&out);
}

/// Place of a column of the quarter turn, in vectors: Σ (k + 1)⌈(k + 1)/8⌉ over the bands before, in groups of eight.
const fn column(l: usize, m: usize) -> usize {
    let (q, r) = (l / LANES, l % LANES);
    let mut start = 0;
    let mut g = 0;
    while g < q {
        start += (g + 1) * (LANES * LANES * g + LANES * (LANES + 1) / 2);
        g += 1;
    }
    start + (q + 1) * (LANES * q * r + r * (r + 1) / 2) + m * row_length(l) / LANES
}

/// The element of the quarter turn of band l from m to m′.
#[cfg(feature = "gpu")]
pub(super) fn quarter_turn(sine: bool, l: usize, from: usize, to: usize) -> f32 {
    quarter_columns()[usize::from(sine)][column(l, from) + to / LANES][to % LANES]
}

/// Columns of the quarter turn, for cosine and for sine terms, which it does not mix.
fn quarter_columns() -> &'static [Vec<[f32; LANES]>; 2] {
    static COLUMNS: OnceLock<[Vec<[f32; LANES]>; 2]> = OnceLock::new();
    COLUMNS.get_or_init(|| {
        let turn = DMat3::from_rotation_y(core::f64::consts::FRAC_PI_2);
        let mut columns = [(); 2].map(|()| vec![[0.0; LANES]; column(BANDS, 0)]);
        for (l, band) in matrices(turn, BANDS).into_iter().enumerate() {
            for from in 0..=l as i32 {
                for to in 0..=l as i32 {
                    let (vector, lane) = (column(l, from as usize) + to as usize / LANES, to as usize % LANES);
                    columns[0][vector][lane] = band.at(to, from) as f32;
                    if from > 0 && to > 0 {
                        columns[1][vector][lane] = band.at(-to, -from) as f32;
                    }
                }
            }
        }
        columns
    })
}

/// The matrix of one band; indices are −l … l.
struct Band {
    l: i32,
    numbers: Vec<f64>,
}

impl Band {
    fn at(&self, to: i32, from: i32) -> f64 {
        self.numbers[((to + self.l) * (2 * self.l + 1) + from + self.l) as usize]
    }
}

/// Matrices of a rotation in the first bands: slow, for tables and as the twin of [`Rotation`].
fn matrices(rotation: DMat3, bands: usize) -> Vec<Band> {
    // Band 1 is the rotation itself in the order y, z, x.
    let axis = [1, 2, 0];
    let one = |i: i32, j: i32| rotation.col(axis[(j + 1) as usize])[axis[(i + 1) as usize]];
    let mut all = vec![Band { l: 0, numbers: vec![1.0] }];
    for l in 1..bands as i32 {
        let before = &all[l as usize - 1];
        let mut numbers = Vec::with_capacity((2 * l as usize + 1).pow(2));
        for m in -l..=l {
            for n in -l..=l {
                numbers.push(if l == 1 { one(m, n) } else { element(&one, before, l, m, n) });
            }
        }
        all.push(Band { l, numbers });
    }
    all
}

/// Ivanic and Ruedenberg's u U + v V + w W.
fn element(one: &impl Fn(i32, i32) -> f64, before: &Band, l: i32, m: i32, n: i32) -> f64 {
    let p = |i: i32, mu: i32| match n {
        n if n == -l => one(i, 1) * before.at(mu, 1 - l) + one(i, -1) * before.at(mu, l - 1),
        n if n == l => one(i, 1) * before.at(mu, l - 1) - one(i, -1) * before.at(mu, 1 - l),
        n => one(i, 0) * before.at(mu, n),
    };
    let a = m.abs();
    let below = if n.abs() < l { (l + n) * (l - n) } else { 2 * l * (2 * l - 1) };
    let root = |x: i32| (f64::from(x) / f64::from(below)).sqrt();
    let root_two = core::f64::consts::SQRT_2;
    let mut sum = 0.0;
    if a < l {
        sum += root((l + m) * (l - m)) * p(0, m);
    }
    let v = 0.5 * root((l + a - 1) * (l + a));
    sum += match m.cmp(&0) {
        Ordering::Equal => -root_two * v * (p(1, 1) + p(-1, -1)),
        Ordering::Greater if m == 1 => v * root_two * p(1, 0),
        Ordering::Greater => v * (p(1, m - 1) - p(-1, 1 - m)),
        Ordering::Less if m == -1 => v * root_two * p(-1, 0),
        Ordering::Less => v * (p(1, m + 1) + p(-1, -m - 1)),
    };
    if m != 0 && a < l - 1 {
        let w = -0.5 * root((l - a - 1) * (l - a));
        sum += w * if m > 0 { p(1, m + 1) + p(-1, -m - 1) } else { p(1, m - 1) - p(-1, 1 - m) };
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::super::basis::{Basis, PACKED, row};
    use super::super::projection::compact;
    use super::*;
    use glam::{DVec3, Mat3A, Vec3A};

    #[test]
    fn columns_follow_one_another() {
        for l in 0..BANDS {
            assert_eq!(column(l + 1, 0), column(l, l + 1));
        }
    }

    fn rotations() -> Vec<DMat3> {
        let mut out = vec![DMat3::IDENTITY, DMat3::from_rotation_z(0.7), DMat3::from_rotation_x(core::f64::consts::PI)];
        for i in 0..6 {
            let x = f64::from(i);
            out.push(
                DMat3::from_rotation_z(1.1 * x)
                    * DMat3::from_rotation_y(0.4 + 0.5 * x)
                    * DMat3::from_rotation_z(2.3 * x),
            );
        }
        out
    }

    /// Some coefficients that fall off slowly, packed.
    fn function(bands: usize) -> Sum {
        let mut f = [[0f32; PACKED]; 2];
        for l in 0..bands {
            for m in 0..=l {
                let number = |k: usize| ((l * 31 + m * 17 + k * 7) % 13) as f32 / 13.0 - 0.5;
                f[0][row(l) + m] = number(0);
                f[1][row(l) + m] = if m > 0 { number(1) } else { 0.0 };
            }
        }
        f
    }

    fn value(f: &Sum, bands: usize, d: DVec3) -> f64 {
        let mut numbers = vec![0.0; bands * bands];
        compact(bands, f, &mut numbers);
        let basis = Basis::Spherical.values(bands, d.as_vec3a());
        numbers.iter().zip(&basis).map(|(a, b)| f64::from(a * b)).sum()
    }

    /// (Rf)(ω) = f(R⁻¹ω) at points of the sphere, for turns about z, half turns, and any.
    #[test]
    fn turned_functions_have_the_values_of_the_others() {
        for rotation in rotations() {
            for bands in [1, 2, 3, 8, 29, BANDS] {
                let f = function(bands);
                let mut turned = f;
                Rotation::new(Mat3A::from(rotation.as_mat3())).apply(bands, &mut turned);
                for d in [DVec3::Z, -DVec3::Y, DVec3::new(0.48, 0.6, 0.64), DVec3::new(-0.8, 0.36, -0.48)] {
                    let (found, exact) = (value(&turned, bands, d), value(&f, bands, rotation.transpose() * d));
                    let size = (bands * bands) as f64;
                    assert!((found - exact).abs() < 2e-5 * size.max(8.0), "{rotation} {bands} {d}: {found} {exact}");
                }
            }
        }
    }

    /// The matrices are orthogonal, and those of two turns multiply.
    #[test]
    fn matrices_are_a_representation() {
        let (a, b) = (rotations()[4], rotations()[6]);
        let [ma, mb, mab] = [a, b, a * b].map(|r| matrices(r, 12));
        for l in 0..12 {
            let range = || -(l as i32)..=l as i32;
            for i in range() {
                for j in range() {
                    let product: f64 = range().map(|k| ma[l].at(i, k) * mb[l].at(k, j)).sum();
                    assert!((product - mab[l].at(i, j)).abs() < 1e-10, "{l} {i} {j}");
                    let dot: f64 = range().map(|k| ma[l].at(i, k) * ma[l].at(j, k)).sum();
                    assert!((dot - f64::from(u8::from(i == j))).abs() < 1e-10, "{l} {i} {j}");
                }
            }
        }
    }

    #[test]
    fn turns_about_z_leave_the_pole() {
        let f = function(6);
        let mut turned = f;
        about_z(6, &mut turned, &multiples(0.6, 0.8));
        let d = Vec3A::new(0.0, 0.6, 0.8);
        let back = Vec3A::new(0.6 * d.x + 0.8 * d.y, 0.6 * d.y - 0.8 * d.x, d.z);
        assert!((value(&turned, 6, d.as_dvec3()) - value(&f, 6, back.as_dvec3())).abs() < 1e-5);
    }
}
