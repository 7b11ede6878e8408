//! Fresnel's equations for unpolarised light.

use crate::scene::Rgb;
use glam::Vec3A;

/// Light that meets a smooth interface of two dielectrics.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Interface {
    /// Reflected share.
    pub reflectance: f32,
    /// Cosine on the other side, of the sign opposite to the incident one; 0 on total reflection.
    pub cos_t: f32,
    /// Index on the other side over the index on this side.
    pub eta: f32,
}

/// Interface met under the cosine `cos` (negative: from inside) with index `eta` inside over outside.
#[inline]
pub(crate) fn dielectric(cos: f32, eta: f32) -> Interface {
    let eta = if cos < 0.0 { 1.0 / eta } else { eta };
    let cos_i = cos.abs();
    let cos2_t = 1.0 - (1.0 - cos_i * cos_i) / (eta * eta);
    if cos2_t <= 0.0 {
        return Interface { reflectance: 1.0, cos_t: 0.0, eta };
    }
    let cos_t = cos2_t.sqrt();
    let s = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
    let p = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
    let reflectance = if eta == 1.0 { 0.0 } else { 0.5 * (s * s + p * p) };
    Interface { reflectance, cos_t: -cos_t.copysign(cos), eta }
}

/// Direction into which `w` continues on the other side of an interface with unit normal `h`.
#[inline]
pub(crate) fn refract(w: Vec3A, h: Vec3A, interface: &Interface) -> Vec3A {
    h * (w.dot(h) / interface.eta + interface.cos_t) - w / interface.eta
}

/// Reflectance of a conductor of complex index eta + i k (Born and Wolf 1999, §14.2).
#[inline]
pub(crate) fn conductor(cos: f32, eta: Rgb, k: Rgb) -> Rgb {
    let cos2 = Rgb::splat(cos * cos);
    let sin2 = Rgb::ONE - cos2;
    let difference = eta * eta - k * k - sin2;
    let a2_plus_b2 = (difference * difference + 4.0 * eta * eta * k * k).max(Rgb::ZERO).map(f32::sqrt);
    let a = (0.5 * (a2_plus_b2 + difference)).max(Rgb::ZERO).map(f32::sqrt);
    let twice = 2.0 * cos * a;
    let s = (a2_plus_b2 + cos2 - twice) / (a2_plus_b2 + cos2 + twice);
    let (sum, product) = (cos2 * a2_plus_b2 + sin2 * sin2, twice * sin2);
    let p = s * ((sum - product) / (sum + product));
    (0.5 * (s + p)).clamp(Rgb::ZERO, Rgb::ONE)
}

/// Reflectance of an interface under diffuse light, index `eta` over that of the light's side (polynomials of Egan and
/// Hilgeman 1979 for eta < 1, of d'Eon and Irving 2011 otherwise; error below 2e-3).
pub(crate) fn diffuse_reflectance(eta: f32) -> f32 {
    let x = 1.0 / eta;
    if eta < 1.0 {
        0.0636 * x + 0.6681 + eta * (0.7099 - 1.4399 * eta)
    } else {
        0.919317 + x * (-3.4793 + x * (6.75335 + x * (-7.80989 + x * (4.98554 - 1.36881 * x))))
    }
}
