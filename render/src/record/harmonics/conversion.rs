//! Hemispherical harmonics as spherical ones and back (Gautron et al. 2004): the way to turn a function of the hemisphere.
//! What the turn brings below the horizon is lost on the way back, as it should.

use super::basis::{BANDS, LANES, MAX_ORDER, PACKED, legendre, row, row_length};
use super::projection::Sum;
use brdf_tables::gauss::gauss_legendre;
use core::f64::consts::{PI, SQRT_2};
use std::sync::OnceLock;

/// Bands for a function of order n: its zero half needs more of them than the function itself.
pub(super) fn bands_for(order: usize) -> usize {
    (order + order / 3 + 3).min(BANDS)
}

/// ∫ Hₗᵐ Yₗ′ᵐ over the hemisphere for all m at place(l′, l) + m. Other integrals are zero.
fn products() -> &'static [f32] {
    static PRODUCTS: OnceLock<Vec<f32>> = OnceLock::new();
    PRODUCTS.get_or_init(|| {
        // With z = t² the integrand is smooth at the horizon.
        const NODES: usize = 96;
        let count = MAX_ORDER * PACKED;
        let mut sums = vec![0f64; BANDS * count];
        for (x, weight) in gauss_legendre(NODES) {
            let t = 0.5 * (x + 1.0);
            let (z, weight) = (t * t, weight * t * 2.0 * PI * SQRT_2);
            for m in 0..MAX_ORDER {
                let hemispherical: Vec<f64> = (m..MAX_ORDER).map(|l| legendre(l, m, 2.0 * z - 1.0)).collect();
                for k in m..BANDS {
                    let spherical = weight * legendre(k, m, z);
                    for (i, h) in hemispherical.iter().enumerate() {
                        sums[place(k, m + i) + m] += spherical * h;
                    }
                }
            }
        }
        sums.into_iter().map(|x| x as f32).collect()
    })
}

/// Place of the products of spherical band k with hemispherical band l.
const fn place(k: usize, l: usize) -> usize {
    k * MAX_ORDER_ROWS + row(l)
}

/// Numbers of all hemispherical rows.
const MAX_ORDER_ROWS: usize = row(MAX_ORDER);

#[inline(always)]
fn add_products(out: &mut [f32], a: &[f32], b: &[f32]) {
    let factors = a.as_chunks::<LANES>().0.iter().zip(b.as_chunks::<LANES>().0);
    for (out, (a, b)) in out.as_chunks_mut::<LANES>().0.iter_mut().zip(factors) {
        let sum = *out;
        *out = core::array::from_fn(|i| sum[i] + a[i] * b[i]);
    }
}

/// The spherical function, zero below the horizon, nearest to a hemispherical one.
#[inline(always)]
pub(super) fn to_sphere(order: usize, f: &Sum) -> Sum {
    let products = products();
    let mut out = [[0f32; PACKED]; 2];
    for k in 0..bands_for(order) {
        for l in 0..order {
            let length = row_length(l.min(k));
            let products = &products[place(k, l)..place(k, l) + length];
            for (out, f) in out.iter_mut().zip(f) {
                let (out, f) = (&mut out[row(k)..row(k) + length], &f[row(l)..row(l) + length]);
                add_products(out, products, f);
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
    for l in 0..order {
        for k in 0..bands_for(order) {
            let length = row_length(l.min(k));
            let products = &products[place(k, l)..place(k, l) + length];
            for (out, f) in out.iter_mut().zip(f) {
                let (out, f) = (&mut out[row(l)..row(l) + length], &f[row(k)..row(k) + length]);
                add_products(out, products, f);
            }
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::super::basis::Basis;
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
