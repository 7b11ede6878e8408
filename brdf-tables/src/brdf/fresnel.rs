//! Fresnel reflectance of a microfacet, split into a grey part that is fitted and a tint that multiplies at run time.

use crate::real::Real;
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
    let large = ((a2_plus_b2 + difference.abs()) * cos.lit(0.5)).sqrt();
    let a = T::select(difference.lt(cos.lit(0.0)), cos.lit(eta * k) / large, large);
    let twice = a * cos * cos.lit(2.0);
    let s = (a2_plus_b2 + cos2 - twice) / (a2_plus_b2 + cos2 + twice);
    let (sum, product) = (cos2 * a2_plus_b2 + sin2.sq(), twice * sin2);
    let p = s * (sum - product) / (sum + product);
    ((s + p) * cos.lit(0.5)).clamp(cos.lit(0.0), cos.lit(1.0))
}
