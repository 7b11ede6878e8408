//! Fresnel reflectance of a microfacet, split into a grey part that is fitted and a tint that multiplies at run time.

use crate::real::{Constant, Real};
use serde::{Deserialize, Serialize};

/// Reflectance of the facets.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum Fresnel {
    /// 1 at every angle.
    None,
    /// F = f0 + (1 − f0)(1 − cos)⁵ (Schlick 1994).
    Schlick {
        /// Reflectance at normal incidence, RGB.
        f0: [f64; 3],
    },
    /// Unpolarised reflectance of a conductor of complex index eta + i k, RGB.
    Conductor {
        /// Real part of the index.
        eta: [f64; 3],
        /// Imaginary part of the index.
        k: [f64; 3],
    },
}

impl Fresnel {
    /// Reflectance of the mean of the three channels' parameters at the cosine `cos_d` between `wi` and the half vector.
    #[inline(always)]
    pub fn gray<T: Real>(&self, cos_d: T) -> T {
        match self {
            Fresnel::None => cos_d.lit(1.0),
            Fresnel::Schlick { f0 } => schlick(cos_d, mean(f0)),
            Fresnel::Conductor { eta, k } => conductor(cos_d, mean(eta), mean(k)),
        }
    }

    /// Reflectance of each channel over [`Fresnel::gray`]: `gray · tint` is the coloured reflectance exactly.
    pub fn tint(&self, cos_d: f64) -> [f64; 3] {
        let gray = self.gray(cos_d);
        if gray <= 0.0 {
            return [1.0; 3]; // only f0 = 0 at normal incidence: no channel reflects
        }
        match self {
            Fresnel::None => [1.0; 3],
            Fresnel::Schlick { f0 } => f0.map(|f0| schlick(cos_d, f0) / gray),
            Fresnel::Conductor { eta, k } => core::array::from_fn(|c| conductor(cos_d, eta[c], k[c]) / gray),
        }
    }
}

/// [`Fresnel::gray`] as a polynomial of u = cos (1 + b)/(cos + b), which spreads the steep rise next to grazing: two square
/// roots and two divisions less in the innermost loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct GrayPolynomial([Constant; DEGREE + 1]);

const DEGREE: usize = 8;
const BEND: f64 = 0.3;
/// Largest relative error with which the polynomial stands for the reflectance; most have 3e-5.
const POLYNOMIAL_ERROR: f64 = 1e-3;

impl GrayPolynomial {
    /// Interpolates at the Chebyshev points of [0, 1]; `None` where the reflectance is not that smooth (an index so large
    /// that its dip lies next to grazing), and for Schlick's formula, which is cheap already.
    pub(crate) fn new(fresnel: &Fresnel) -> Option<Self> {
        if !matches!(fresnel, Fresnel::Conductor { .. }) {
            return None;
        }
        let point = |i: usize| 0.5 - 0.5 * (core::f64::consts::PI * (i as f64 + 0.5) / (DEGREE + 1) as f64).cos();
        let x: [f64; DEGREE + 1] = core::array::from_fn(point);
        // Newton's divided differences, expanded to powers.
        let mut table = x.map(|u| fresnel.gray(BEND * u / (1.0 + BEND - u)));
        for step in 1..=DEGREE {
            for i in (step..=DEGREE).rev() {
                table[i] = (table[i] - table[i - 1]) / (x[i] - x[i - step]);
            }
        }
        let mut powers = [0.0; DEGREE + 1];
        for i in (0..=DEGREE).rev() {
            for k in (1..=DEGREE).rev() {
                powers[k] = powers[k - 1] - powers[k] * x[i];
            }
            powers[0] = table[i] - powers[0] * x[i];
        }
        let polynomial = Self(powers.map(Constant::from));
        let fits = |i: i32| {
            let cos = f64::from(i) / 200.0;
            let exact = fresnel.gray(cos);
            (polynomial.at(cos) - exact).abs() <= POLYNOMIAL_ERROR * exact
        };
        (0..=200).all(fits).then_some(polynomial)
    }

    /// By Estrin's scheme, a third as deep as Horner's.
    #[inline(always)]
    pub(crate) fn at<T: Real>(&self, cos: T) -> T {
        let u = cos * (cos + cos.lit(BEND)).recip() * cos.lit(1.0 + BEND);
        let [c0, c1, c2, c3, c4, c5, c6, c7, c8] = self.0;
        let (u2, u4) = (u.sq(), u.sq().sq());
        let low = pair(u, c3, c2).mul_add(u2, pair(u, c1, c0));
        let high = pair(u, c7, c6).mul_add(u2, pair(u, c5, c4));
        u.constant(c8).mul_add(u4, high).mul_add(u4, low)
    }
}

/// a u + b.
#[inline(always)]
fn pair<T: Real>(u: T, a: Constant, b: Constant) -> T {
    u.constant(a).mul_add(u, u.constant(b))
}

fn mean(rgb: &[f64; 3]) -> f64 {
    (rgb[0] + rgb[1] + rgb[2]) / 3.0
}

#[inline(always)]
fn schlick<T: Real>(cos: T, f0: f64) -> T {
    let m = (cos.lit(1.0) - cos).max(cos.lit(0.0));
    m.sq().sq() * m * cos.lit(1.0 - f0) + cos.lit(f0)
}

/// Born and Wolf 1999, §14.2, in the form a² − b² = η² − k² − sin², ab = ηk (both factors taken from the sum that does
/// not cancel).
#[inline(always)]
fn conductor<T: Real>(cos: T, eta: f64, k: f64) -> T {
    let cos2 = cos.sq();
    let sin2 = (cos.lit(1.0) - cos2).max(cos.lit(0.0));
    let difference = cos.lit(eta * eta - k * k) - sin2;
    let a2_plus_b2 = (difference.sq() + cos.lit(4.0 * eta * eta * k * k)).sqrt();
    let large2 = (a2_plus_b2 + difference.abs()) * cos.lit(0.5);
    let over_large = large2.sqrt().recip();
    let a = T::select(difference.lt(cos.lit(0.0)), cos.lit(eta * k) * over_large, large2 * over_large);
    let twice = a * cos * cos.lit(2.0);
    let s = (a2_plus_b2 + cos2 - twice) * (a2_plus_b2 + cos2 + twice).recip();
    let (sum, product) = (cos2 * a2_plus_b2 + sin2.sq(), twice * sin2);
    let p = s * (sum - product) * (sum + product).recip();
    ((s + p) * cos.lit(0.5)).clamp(cos.lit(0.0), cos.lit(1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Metals and plastics are smooth enough; the worst error lies below the bound also between the points it was tested at.
    #[test]
    fn polynomials_stand_for_metals_and_plastics() {
        let conductor = |eta: [f64; 3], k: [f64; 3]| Fresnel::Conductor { eta, k };
        let gold = conductor([0.143, 0.375, 1.442], [3.983, 2.386, 1.603]);
        let aluminium = conductor([1.66, 0.88, 0.52], [9.22, 6.27, 4.84]);
        let plastic = conductor([1.5; 3], [0.01; 3]);
        let water = conductor([1.33; 3], [0.01; 3]);
        for fresnel in [gold, aluminium, plastic, water] {
            let polynomial = GrayPolynomial::new(&fresnel).expect("smooth");
            let error = |i: i32| {
                let cos = (f64::from(i) + 0.37) / 5001.0;
                (polynomial.at(cos) / fresnel.gray(cos) - 1.0).abs()
            };
            let worst = (0..5000).map(error).fold(0.0, f64::max);
            assert!(worst < 1.5 * POLYNOMIAL_ERROR, "{fresnel:?}: {worst:e}");
        }
        assert_eq!(GrayPolynomial::new(&conductor([100.0; 3], [0.01; 3])), None);
    }
}
