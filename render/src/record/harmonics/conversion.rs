//! Hemispherical harmonics as spherical ones and back (Gautron et al. 2004): the way to turn a function of the hemisphere.
//! What the turn brings below the horizon is lost on the way back, as it should.

use super::basis::{BANDS, LANES, MAX_ORDER, PACKED, Rows, legendre, vectors, vectors_mut};
use super::projection::Sum;
use brdf_tables::gauss::gauss_legendre;
use core::f64::consts::{PI, SQRT_2};
use std::sync::OnceLock;

/// Bands for a function of order n: its zero half needs more of them than the function itself.
pub(crate) fn bands_for(order: usize) -> usize {
    (order + order / 3 + 3).min(BANDS)
}

/// ∫ Hₗᵐ Yₖᵐ over the hemisphere at place(c, k, l), m = 8c … 8c + 7. Integrals of different m are zero.
fn products() -> &'static [[f32; LANES]] {
    static PRODUCTS: OnceLock<Vec<[f32; LANES]>> = OnceLock::new();
    PRODUCTS.get_or_init(|| {
        // With z = t² the integrand is smooth at the horizon.
        const NODES: usize = 96;
        let mut sums = vec![[0f64; LANES]; place(CHUNKS, 0, 0)];
        for (x, weight) in gauss_legendre(NODES) {
            let t = 0.5 * (x + 1.0);
            let (z, weight) = (t * t, weight * t * 2.0 * PI * SQRT_2);
            for m in 0..MAX_ORDER {
                let hemispherical: Vec<f64> = (m..MAX_ORDER).map(|l| legendre(l, m, 2.0 * z - 1.0)).collect();
                for k in m..BANDS {
                    let spherical = weight * legendre(k, m, z);
                    for (i, h) in hemispherical.iter().enumerate() {
                        sums[place(m / LANES, k, m + i)][m % LANES] += spherical * h;
                    }
                }
            }
        }
        sums.into_iter().map(|v| v.map(|x| x as f32)).collect()
    })
}

/// ∫ Hₗᵐ Yₖᵐ over the hemisphere.
#[cfg(feature = "gpu")]
pub(super) fn product(m: usize, k: usize, l: usize) -> f32 {
    products()[place(m / LANES, k, l)][m % LANES]
}

/// Vectors of m that hemispherical rows are divided into.
const CHUNKS: usize = MAX_ORDER.div_ceil(LANES);

/// Place of the products of spherical band k with hemispherical band l.
const fn place(chunk: usize, k: usize, l: usize) -> usize {
    (chunk * BANDS + k) * MAX_ORDER + l
}

/// Vector number `chunk` of the rows that have one, by band.
#[inline(always)]
fn gather(bands: usize, chunk: usize, f: &Rows) -> [[f32; LANES]; BANDS] {
    let mut out = [[0f32; LANES]; BANDS];
    for (l, out) in out.iter_mut().enumerate().take(bands).skip(chunk * LANES) {
        *out = vectors(f, l)[chunk];
    }
    out
}

/// The spherical function, zero below the horizon, nearest to a hemispherical one.
#[inline(always)]
pub(super) fn to_sphere(order: usize, f: &Sum) -> Sum {
    let products = products();
    let mut out = [[0f32; PACKED]; 2];
    for (out, f) in out.iter_mut().zip(f) {
        for chunk in 0..order.div_ceil(LANES) {
            let (first, f) = (chunk * LANES, gather(order, chunk, f));
            for k in first..bands_for(order) {
                let mut sum = [0f32; LANES];
                let products = &products[place(chunk, k, first)..place(chunk, k, order)];
                for (p, f) in products.iter().zip(&f[first..order]) {
                    for i in 0..LANES {
                        sum[i] += p[i] * f[i];
                    }
                }
                vectors_mut(out, k)[chunk] = sum;
            }
        }
    }
    out
}

/// The upper half of a spherical function of [`bands_for`] bands, nearest in the hemispherical basis.
#[inline(always)]
pub(super) fn to_hemisphere(order: usize, f: &Sum) -> Sum {
    let products = products();
    let mut out = [[0f32; PACKED]; 2];
    for (out, f) in out.iter_mut().zip(f) {
        for chunk in 0..order.div_ceil(LANES) {
            let first = chunk * LANES;
            let mut sums = [[0f32; LANES]; BANDS];
            for k in first..bands_for(order) {
                let f = vectors(f, k)[chunk];
                let products = &products[place(chunk, k, first)..place(chunk, k, order)];
                for (p, sum) in products.iter().zip(&mut sums[first..order]) {
                    let old = *sum;
                    *sum = core::array::from_fn(|i| old[i] + p[i] * f[i]);
                }
            }
            for (l, sum) in sums.iter().enumerate().take(order).skip(first) {
                vectors_mut(out, l)[chunk] = *sum;
            }
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::super::basis::{Basis, row};
    use super::super::projection::compact;
    use super::super::rotation::Rotation;
    use super::*;
    use glam::{DVec3, Mat3A, Vec3A};

    /// Coefficients of a function by quadrature, packed, with its values at the nodes of the rule.
    fn project(basis: Basis, order: usize, f: impl Fn(DVec3) -> f64) -> Sum {
        let mut out = [[0f32; PACKED]; 2];
        let mut sums = [[0f64; PACKED]; 2];
        for (x, weight) in gauss_legendre(80) {
            let z = 0.5 * (x + 1.0);
            for k in 0..128 {
                let (s, c) = (2.0 * PI * f64::from(k) / 128.0).sin_cos();
                let r = (1.0 - z * z).sqrt();
                let d = DVec3::new(r * c, r * s, z);
                let value = f(d) * 0.5 * weight * 2.0 * PI / 128.0;
                let values = basis.values(order, d.as_vec3a());
                for l in 0..order {
                    for m in 0..=l {
                        sums[0][row(l) + m] += value * f64::from(values[l * l + m]);
                        if m > 0 {
                            sums[1][row(l) + m] += value * f64::from(values[l * l + l + m]);
                        }
                    }
                }
            }
        }
        for (out, sums) in out.iter_mut().zip(sums) {
            out.iter_mut().zip(sums).for_each(|(o, s)| *o = s as f32);
        }
        out
    }

    /// A lobe over the hemisphere turned by up to 25°, against the projection of the turned lobe: the share of its norm that is
    /// wrong. Orders are those that hold the lobes themselves to about one percent.
    #[test]
    fn turned_lobes_agree_with_their_projections() {
        for (order, exponent) in [(4, 2.0), (8, 12.0), (14, 40.0), (20, 90.0), (29, 180.0)] {
            for tilt in [0.0, 0.1, 0.25, 0.43] {
                let mut worst = 0f64;
                for (theta, phi) in [(0.0, 0.0), (0.5, 1.0), (0.8, 4.0)] {
                    let axis =
                        DVec3::new(f64::sin(theta) * f64::cos(phi), f64::sin(theta) * f64::sin(phi), f64::cos(theta));
                    let lobe = |d: DVec3| d.z.max(0.0) * d.dot(axis).max(0.0).powf(exponent);
                    let rotation = glam::DMat3::from_rotation_z(0.4) * glam::DMat3::from_rotation_y(tilt);
                    let from = project(Basis::Hemispherical, order, lobe);
                    let exact = project(Basis::Hemispherical, order, |d| lobe(rotation.transpose() * d));
                    let mut sphere = to_sphere(order, &from);
                    Rotation::new(Mat3A::from(rotation.as_mat3())).apply(bands_for(order), &mut sphere);
                    let found = to_hemisphere(order, &sphere);
                    let norm = |f: &Sum| f.iter().flatten().map(|x| f64::from(x * x)).sum::<f64>();
                    let mut wrong = found;
                    wrong.iter_mut().flatten().zip(exact.iter().flatten()).for_each(|(a, b)| *a -= b);
                    worst = worst.max((norm(&wrong) / norm(&exact)).sqrt());
                }
                println!("order {order}, n = {exponent}, turned by {tilt}: {:.2} % wrong", 100.0 * worst);
                assert!(worst < 0.05, "{order} {tilt} {worst}");
            }
        }
    }

    /// Upper values survive the way to the sphere; lower ones are about zero.
    #[test]
    fn the_lower_half_is_dark() {
        let f = project(Basis::Hemispherical, 10, |d| d.z * (1.0 + d.x));
        let sphere = to_sphere(10, &f);
        let bands = bands_for(10);
        let mut numbers = vec![0.0; bands * bands];
        compact(bands, &sphere, &mut numbers);
        for (d, exact) in [(Vec3A::new(0.6, 0.0, 0.8), 1.28), (Vec3A::new(0.6, 0.0, -0.8), 0.0), (-Vec3A::Z, 0.0)] {
            let basis = Basis::Spherical.values(bands, d);
            let found: f32 = numbers.iter().zip(&basis).map(|(a, b)| a * b).sum();
            assert!((found - exact).abs() < 0.01, "{d}: {found}");
        }
    }
}
