//! Cap cubature: the mean BRDF by a product rule that follows both the cap and the lobe seen from `wo`.
//!
//! Directions are written in the frame of `wo` (azimuth 0, so `wo` = (sinθo, 0, cosθo)) with the pole on the y axis:
//! wi = (cos b sin a, sin b, cos b cos a). In these coordinates
//! - the horizon is |a| = π/2, a straight cut, so caps that cross it need nothing special;
//! - the cap meets the meridian a in one interval of q = sin b, in closed form, and dω = da dq;
//! - a specular lobe sits at a = −θo, q = 0, with a width in q that shrinks with cosθo (the elongation of highlights).
//!
//! Both variables pass through an algebraic map, x = κ s/(1 − s²), whose κ is the width of the lobe there: a rule of n
//! points then resolves the cap when it is smaller than the lobe, the lobe when it is smaller than the cap, and the
//! tails of both. The outer variable is sin(a − a_cap) = sinρ sin τ first, which removes the square root at the rim.
//!
//! A cap smaller than the lobe needs none of that: a few nodes on rings about its axis do ([`Rule::Disc`]).

mod bins;
mod disc;
mod lookup;
mod rule;
mod spread;
mod table;

pub(crate) use bins::Bins;
pub use bins::{Node, OUTER};
pub use rule::{Grid, NONE, RULES, Rule};
pub use table::Cubature;

/// Numbers that shaders share with the look-up.
#[cfg(feature = "wgsl")]
pub(crate) mod constants {
    pub(crate) use super::bins::{CHORD_STEPS, COSINES, FAR, OUTER, SHIFT};
}
#[cfg(feature = "wgsl")]
pub(crate) use rule::numbers as rule_numbers;

use crate::brdf::{Footprint, Formula};
use crate::real::Real;
use core::f64::consts::FRAC_PI_2;

/// An interval mapped through x = κ s/(1 − s²): midpoint and half length in s.
struct Mapped<T> {
    middle: T,
    half: T,
    kappa: T,
}

impl<T: Real> Mapped<T> {
    /// The interval [lo, lo + length] relative to the centre of the map. `length` is separate so that the shortest
    /// intervals keep their digits: with w = √(κ² + 4x²), s = 2x/(κ + w), and the difference of two s is written without
    /// cancellation.
    #[inline(always)]
    fn new(lo: T, length: T, kappa: T) -> Self {
        let (hi, k2, four) = (lo + length, kappa.sq(), lo.lit(4.0));
        let (w0, w1) = ((k2 + four * lo.sq()).sqrt(), (k2 + four * hi.sq()).sqrt());
        let (d0, d1) = ((kappa + w0).recip(), (kappa + w1).recip());
        let half = length * (kappa + w0 - four * lo * (lo + hi) * (w0 + w1).recip()) * (d0 * d1);
        Self { middle: (lo + lo) * d0 + half, half: half.max(lo.lit(0.0)), kappa }
    }

    /// Value and Jacobian at the node `x` ∈ [−1, 1] of a rule.
    #[inline(always)]
    fn at(&self, x: T) -> (T, T) {
        let s = self.half.mul_add(x, self.middle);
        let s2 = s.sq();
        let r = (s.lit(1.0) - s2).max(s.lit(1e-6)).recip();
        let kr = self.kappa * r;
        (kr * s, kr * r * self.half * (s.lit(1.0) + s2))
    }
}

/// Which part of a cap to integrate over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// The part above the horizon.
    Above,
    /// The part below it (where cosθi is negative), for a formula that holds there too. Caps that hold a pole of the frame
    /// are integrated above all the same: see [`holds_pole`].
    Below,
}

/// Whether a cap, given in the frame of `wo`, holds a pole of the coordinates: a cap on the horizon, far to the side.
#[inline(always)]
pub fn holds_pole<T: Real>(axis: [T; 3], height: T) -> T::Mask {
    (axis[0].sq() + axis[2].sq()).lt(height * (height.lit(2.0) - height))
}

/// ∫ f_r(wi, wo) cosθi dwi over the part of the cap above the horizon (or below it): the numerator of eq. 9.
///
/// `axis` is the cap axis in the frame of `wo`, `height` = 1 − cos σ, `rotation` = (cos, sin) of the azimuth of `wo`,
/// which takes directions back to the surface frame for an anisotropic formula; (1, 0) for an isotropic one. `grid` holds
/// the nodes of a product rule.
#[inline(always)]
pub fn numerator<T: Real, F: Formula>(
    formula: &F,
    lobe: &Footprint,
    rotation: (f64, f64),
    axis: [T; 3],
    height: T,
    side: Side,
    grid: &Grid<T::Lanes>,
) -> T {
    let one = height.lit(1.0);
    let (zero, tiny) = (one.lit(0.0), one.lit(1e-12));
    // Back to the surface frame, which matters to an anisotropic model only (the others come with the identity).
    let turn = rotation != (1.0, 0.0);
    let (cos_p, sin_p) = (one.lit(rotation.0), one.lit(rotation.1));
    let wo = [one.lit(lobe.sin_o), zero, one.lit(lobe.cos_o)];
    let wo = if turn { turned(wo, cos_p, sin_p) } else { wo };

    // The cap: its meridian a_cap, and sinρ, the half width in a.
    let cos_r = one - height;
    let sin2_r = height * (one.lit(2.0) - height);
    let sin_r = sin2_r.sqrt();
    let in_plane2 = (axis[0].sq() + axis[2].sq()).max(tiny);
    let in_plane = in_plane2.sqrt();
    let over_plane = in_plane.recip();
    let (sin_c, cos_c) = (axis[0] * over_plane, axis[2] * over_plane);
    let has_pole = holds_pole(axis, height);
    let any_pole = T::any(has_pole);
    let sin_rho = T::select(has_pole, one, (sin_r * over_plane).min(one));

    // τ range: the horizon cuts the side the cap leans to (both sides when the cap holds the pole, where τ = a − a_cap).
    let quarter = one.lit(FRAC_PI_2);
    let (mut lo, mut hi) = (-quarter, quarter);
    let over_rho = sin_rho.recip();
    if side == Side::Below || any_pole || T::any(cos_c.lt(sin_rho)) {
        let cut = (cos_c * over_rho).min(one).asin();
        let leans_right = zero.lt(sin_c);
        let a_cap = sin_c.asin();
        (lo, hi) = match side {
            Side::Above => (T::select(leans_right, -quarter, -cut), T::select(leans_right, cut, quarter)),
            Side::Below => (T::select(leans_right, cut, -quarter), T::select(leans_right, quarter, -cut)),
        };
        hi = T::select(has_pole, quarter - a_cap, hi);
        lo = T::select(has_pole, -quarter - a_cap, lo);
    }

    // The lobe in τ: its centre, or the nearest rim, and its width there.
    let sin_d = one.lit(lobe.sin_peak) * cos_c - one.lit(lobe.cos_peak) * sin_c;
    let excess = (sin_d.abs() - sin_rho).max(zero);
    let reach = (one.lit(lobe.width_a * lobe.width_a) + excess.sq()).sqrt() * over_rho;
    let clamped = (sin_d * over_rho).clamp(-one, one);
    let centre = clamped.asin();
    let kappa = reach * (one - clamped.sq() + reach).sqrt().recip();
    let tau_map = Mapped::new(lo - centre, hi - lo, kappa);

    let mut sum = zero;
    for (node, weight) in &grid.outer {
        let (offset, jacobian) = tau_map.at(one.load(node));
        let (sin_t, cos_t) = (centre + offset).sin_cos();
        // d = a − a_cap
        let x = sin_rho * sin_t;
        let cos2 = (one - x.sq()).max(tiny);
        let root = cos2.sqrt();
        let cos_d = T::select(has_pole, cos_t, root);
        let jacobian = jacobian * T::select(has_pole, one, sin_rho * cos_t * root.recip());
        let sin_a = sin_c * cos_d + cos_c * x;
        let cos_a = cos_c * cos_d - sin_c * x;

        // The interval of q = sin b on this meridian: b₀ ± β with (p, axis.y) = R (cos b₀, sin b₀), cos β = cosσ / R.
        let p = in_plane * cos_d;
        let r2 = (p.sq() + axis[1].sq()).max(tiny);
        let root = T::select(has_pole, (sin2_r - in_plane.sq() * x.sq()).max(zero).sqrt(), sin_r * cos_t);
        // R² sin(b₀ ± β) and R² cos(b₀ ± β); past a pole of the frame the interval ends at the pole.
        let inverse = r2.recip();
        let (mid, half) = (axis[1] * cos_r * inverse, p * root * inverse);
        let (mut q_lo, mut length) = (mid - half, half + half);
        if any_pole {
            let (mid_c, half_c) = (p * cos_r, axis[1] * root);
            let q_hi = T::select((mid_c - half_c).lt(zero), one, mid + half);
            q_lo = T::select((mid_c + half_c).lt(zero), -one, q_lo);
            length = T::select(has_pole, q_hi - q_lo, length);
        }

        let along = sin_a - one.lit(lobe.sin_peak);
        let scale = one.lit(lobe.h0) + one.lit(lobe.h1) * cos_a;
        let ridge = one.lit(lobe.tilt) * along;
        let kappa_q = (one.lit(lobe.k0) * scale.sq() + one.lit(lobe.k1) * along.sq()).max(tiny).sqrt();
        let q_map = Mapped::new(q_lo - ridge, length, kappa_q);
        let mut row = zero;
        for (node, weight) in &grid.inner {
            let (offset, jacobian) = q_map.at(one.load(node));
            let q = ridge + offset;
            let cos_b = (one - q.sq()).max(tiny).sqrt();
            let wi = [cos_b * sin_a, q, cos_b * cos_a];
            let wi = if turn { turned(wi, cos_p, sin_p) } else { wi };
            let measure = jacobian * one.load(weight) * wi[2];
            row = measure.mul_add(formula.rest(wi, wo), row);
        }
        let measure = jacobian * one.load(weight);
        sum = measure.mul_add(row, sum);
    }
    sum * formula.factor(wo)
}

/// A vector rotated about z.
#[inline(always)]
fn turned<T: Real>([x, y, z]: [T; 3], cos: T, sin: T) -> [T; 3] {
    [x * cos - y * sin, x * sin + y * cos, z]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The mapped rule integrates 1 over any interval, and a bell of the width of the map far better than a plain one.
    #[test]
    fn mapped_intervals() {
        let rule = crate::gauss::gauss_legendre(8);
        for (lo, length, kappa) in [(-1.0, 2.0, 2.0), (0.3, 1e-6, 0.5), (-3.0, 1.0, 0.5), (-0.2, 0.4, 10.0)] {
            let map = Mapped::<f64>::new(lo, length, kappa);
            let (first, last) = (map.at(-1.0).0, map.at(1.0).0);
            assert!((first - lo).abs() < 1e-6 * kappa.max(length), "{lo} {length} {kappa}: {first}");
            assert!((last - lo - length).abs() < 1e-6 * kappa.max(length), "{lo} {length} {kappa}: {last}");
            let sum = |f: &dyn Fn(f64) -> f64| {
                rule.iter().map(|&(x, w)| (map.at(x), w)).map(|((x, j), w)| w * j * f(x)).sum::<f64>()
            };
            assert!((sum(&|_| 1.0) / length - 1.0).abs() < 0.02, "{lo} {length} {kappa}: {}", sum(&|_| 1.0));
        }
        let map = Mapped::<f64>::new(-1.0, 2.0, 0.1);
        let bell: f64 =
            rule.iter().map(|&(x, w)| (map.at(x), w)).map(|((x, j), w)| w * j * (-(x / 0.03).powi(2)).exp()).sum();
        assert!((bell / (0.03 * core::f64::consts::PI.sqrt()) - 1.0).abs() < 0.02, "{bell}");
    }

    #[test]
    fn poles_are_seen() {
        assert!(holds_pole::<f64>([0.0, 1.0, 0.0], 1e-3));
        assert!(!holds_pole::<f64>([0.0, 0.0, 1.0], 0.5));
        assert!(holds_pole::<f64>([0.1, 0.99, 0.1], 0.05) && !holds_pole::<f64>([0.1, 0.99, 0.1], 0.005));
    }
}
