//! The lobe table: signed generalized cosine lobes per cell of (θe, φe, Ω), blended as values in the mirror frame.
//!
//! The frame of a query has its z axis along the mirrored cap axis and its x axis in the plane of incidence, so that the
//! lobes of all cells line up whatever their θe: the values of the corners are interpolated there, never their
//! coefficients (whose peak falls by exp(−nΔθ²/8) between two rows, and which need not be in the same order).

use crate::axis::{Axes, Place};
use crate::batch::CapBatch;
use crate::cap::Cap;
use crate::lobe::Lobe;
use crate::mean::MeanBrdf;
use crate::parts::PartsError;
use crate::real::{LANES, Real};
use core::f64::consts::FRAC_PI_2;
use fearless_simd::{Level, Simd, dispatch, f32x16, prelude::*};
use glam::{DVec3, Vec3};

/// Numbers stored per lobe: axis, amplitude, exponent.
pub const LOBE_SIZE: usize = 5;
/// Lobes per node come in groups of this size, which move into vector lanes at once.
const GROUP: usize = 4;

/// A grid of sums of lobes.
#[derive(Clone, Debug, PartialEq)]
pub struct Lobes {
    axes: Axes,
    count: usize,
    /// Per node: `count` values each of axis x, y, z, amplitude, exponent.
    data: Vec<f32>,
}

impl Lobes {
    /// From the numbers of all nodes.
    ///
    /// # Errors
    /// Their count is wrong, or one cannot belong to a lobe.
    pub fn new(axes: Axes, count: usize, data: Vec<f32>) -> Result<Self, PartsError> {
        if count == 0 || count > LANES || !count.is_multiple_of(GROUP) {
            return Err(PartsError::Size { what: "lobes per node" });
        }
        let stride = count * LOBE_SIZE;
        PartsError::count(stride.checked_mul(axes.len()), data.len())?;
        PartsError::first("node", data.chunks(stride), |node| {
            let [x, y, z, amplitude, exponent] = core::array::from_fn(|slot| &node[slot * count..][..count]);
            // The exponent magnifies what the axis is longer than 1.
            let unit = |k: usize| (x[k] * x[k] + y[k] * y[k] + z[k] * z[k] - 1.0).abs() < 1e-6;
            (0..count).all(|k| unit(k) && amplitude[k].abs() <= 1e12 && exponent[k] > 0.0 && exponent[k] <= 1e7)
        })?;
        Ok(Self { axes, count, data })
    }

    /// From one list of lobes per node, each in the mirror frame of its node; short lists are padded with zeros.
    ///
    /// # Errors
    /// As [`Lobes::new`].
    pub fn from_nodes(axes: Axes, nodes: &[Vec<Lobe>]) -> Result<Self, PartsError> {
        PartsError::count(Some(axes.len()), nodes.len())?;
        let count = nodes.iter().map(Vec::len).max().unwrap_or(0).max(1).next_multiple_of(GROUP);
        let mut data = vec![0f32; axes.len() * count * LOBE_SIZE];
        for (node, lobes) in data.chunks_mut(count * LOBE_SIZE).zip(nodes) {
            for k in 0..count {
                let none = Lobe { axis: DVec3::Z, amplitude: 0.0, exponent: 1.0 };
                let lobe = lobes.get(k).copied().unwrap_or(none);
                let numbers = [lobe.axis.x, lobe.axis.y, lobe.axis.z, lobe.amplitude, lobe.exponent];
                for (slot, x) in numbers.iter().enumerate() {
                    node[slot * count + k] = *x as f32;
                }
            }
        }
        Self::new(axes, count, data)
    }

    /// Grid, lobes per node and their numbers, as [`Lobes::new`] takes them.
    pub fn parts(&self) -> (Axes, usize, &[f32]) {
        (self.axes, self.count, &self.data)
    }

    /// The lobes of a node, in its mirror frame.
    pub fn node(&self, index: usize) -> Vec<Lobe> {
        let stride = self.count * LOBE_SIZE;
        let node = &self.data[index * stride..][..stride];
        let number = |slot: usize, k: usize| f64::from(node[slot * self.count + k]);
        (0..self.count)
            .map(|k| Lobe {
                axis: DVec3::new(number(0, k), number(1, k), number(2, k)),
                amplitude: number(3, k),
                exponent: number(4, k),
            })
            .collect()
    }

    /// The two to eight nodes around a query, with their weights.
    fn corners(&self, theta: Place, phi: Place, omega: Place) -> impl Iterator<Item = (usize, f64)> + use<> {
        let axes = self.axes;
        (0..8).filter_map(move |corner| {
            let side = |place: Place, bit: usize, nodes: u32| {
                let up = corner >> bit & 1 == 1;
                let weight = if up { place.fraction } else { 1.0 - place.fraction };
                let index = place.index + usize::from(up);
                (weight > 0.0 && index < nodes as usize).then_some((index, weight))
            };
            let (t, wt) = side(theta, 2, axes.theta)?;
            let (p, wp) = side(phi, 1, axes.phi)?;
            let (o, wo) = side(omega, 0, axes.omega)?;
            Some((axes.index(t, p, o), wt * wp * wo))
        })
    }

    /// Corners of the query for a cap.
    fn around(&self, axis: DVec3, solid_angle: f64) -> impl Iterator<Item = (usize, f64)> + use<> {
        let theta = axis.truncate().length().atan2(axis.z);
        let phi = if self.axes.phi == 1 { 0.0 } else { axis.y.atan2(axis.x) };
        let omega = self.axes.omega_place(solid_angle);
        self.corners(self.axes.theta_place(theta), self.axes.phi_place(phi), omega)
    }
}

/// `wo` in the mirror frame of a cap around `axis`. The y axis is turned so that the azimuth of the cap counts from the
/// nearest x axis within its quadrant, as the cells of an anisotropic table do.
pub fn into_mirror_frame(axis: DVec3, wo: DVec3) -> DVec3 {
    let sin = axis.truncate().length();
    let (cp, sp) = if sin > 1e-9 { (axis.x / sin, axis.y / sin) } else { (1.0, 0.0) };
    let (x, y) = (cp * wo.x + sp * wo.y, cp * wo.y - sp * wo.x);
    // An odd number of reflections maps the quadrant of the axis to the first one.
    let y = if axis.x * axis.y < 0.0 { -y } else { y };
    DVec3::new(x * axis.z + wo.z * sin, y, wo.z * axis.z - x * sin)
}

impl MeanBrdf for Lobes {
    fn name(&self) -> &'static str {
        "lobes"
    }

    fn value(&self, cap: &Cap, wo: DVec3) -> f64 {
        if wo.z <= 0.0 {
            return 0.0;
        }
        let w = into_mirror_frame(cap.axis(), wo);
        let sum = |index: usize| self.node(index).iter().map(|lobe| lobe.value(w)).sum::<f64>();
        self.around(cap.axis(), cap.solid_angle()).map(|(index, weight)| weight * sum(index)).sum::<f64>().max(0.0)
    }

    fn values(&self, caps: &CapBatch, wo: Vec3, out: &mut [f32]) {
        let out = &mut out[..caps.len()];
        if wo.z <= 0.0 {
            return out.fill(0.0);
        }
        dispatch!(Level::new(), simd => batch(simd, self, caps, wo, out));
    }
}

/// Everything that a cap's look-up needs, for sixteen caps: computed across lanes, used cap by cap.
struct Prepared {
    /// `wo` in the mirror frame.
    w: [[f32; LANES]; 3],
    /// Lower node in θe, φe, Ω.
    index: [[f32; LANES]; 3],
    /// Way to the upper node.
    fraction: [[f32; LANES]; 3],
}

#[inline(always)]
fn prepare<S: Simd>(simd: S, axes: &Axes, lanes: [&[f32; LANES]; 4], wo: Vec3) -> Prepared {
    let [x, y, z, height] = lanes.map(|lanes| f32x16::load_array_ref(simd, lanes));
    let (zero, one) = (z.lit(0.0), z.lit(1.0));
    // The mirror frame, as in `into_mirror_frame`.
    let sin = Real::sqrt(x.sq() + y.sq());
    let flat = sin.lt(z.lit(1e-9));
    let over = one / Real::select(flat, one, sin);
    let (cp, sp) = (Real::select(flat, one, x * over), Real::select(flat, zero, y * over));
    let (u, v) = (cp * wo.x + sp * wo.y, cp * wo.y - sp * wo.x);
    let v = Real::select((x * y).lt(zero), -v, v);
    let w = [u * z + sin * wo.z, v, z * wo.z - u * sin];
    // Places on the axes.
    let theta = (z.lit(FRAC_PI_2) - Real::asin(Real::min(z, one))) * z.lit(1.0 / FRAC_PI_2);
    let phi = if axes.phi == 1 { zero } else { Real::asin(Real::min(Real::abs(sp), one)) * z.lit(1.0 / FRAC_PI_2) };
    let tau = (height * z.lit(0.5 * axes.sharpness) + 1.0).log2() * z.lit(1.0 / (1.0 + 0.5 * axes.sharpness).log2());
    let omega = if axes.stretch == 1.0 { tau } else { tau.powf(z.lit(axes.stretch)) };
    let mut prepared = Prepared { w: w.map(|w| w.to_array()), index: [[0.0; LANES]; 3], fraction: [[0.0; LANES]; 3] };
    for (k, (x, nodes)) in [(theta, axes.theta), (phi, axes.phi), (omega, axes.omega)].into_iter().enumerate() {
        let x = Real::clamp(x, zero, one) * z.lit(f64::from(nodes - 1));
        let index = Real::floor(Real::min(x, z.lit(f64::from(nodes.saturating_sub(2)))));
        (prepared.index[k], prepared.fraction[k]) = (index.to_array(), (x - index).to_array());
    }
    prepared
}

/// Adds sixteen lobes towards `w`, lane by lane.
#[inline(always)]
fn lobe_sum<S: Simd>(simd: S, lanes: &[[f32; LANES]; LOBE_SIZE], w: [f32; 3], sum: f32x16<S>) -> f32x16<S> {
    let [x, y, z, a, n] = lanes.map(|lane| f32x16::load_array(simd, lane));
    let cos = x * w[0] + y * w[1] + z * w[2];
    Real::mul_add(a, cos.powf(n), sum)
}

/// Sixteen lobes at a time, of the corners of one cap.
#[inline(always)]
fn batch<S: Simd>(simd: S, table: &Lobes, caps: &CapBatch, wo: Vec3, out: &mut [f32]) {
    let (count, axes) = (table.count, &table.axes);
    let stride = count * LOBE_SIZE;
    for (block, out) in out.chunks_mut(LANES).enumerate() {
        let p = prepare(simd, axes, caps.lanes(block * LANES), wo);
        for (i, out) in out.iter_mut().enumerate() {
            let [t, phi, o] = core::array::from_fn(|k| p.index[k][i] as usize);
            let [ft, fp, fo] = core::array::from_fn(|k| p.fraction[k][i]);
            let w = core::array::from_fn(|k| p.w[k][i]);
            let mut lanes = [[0f32; LANES]; LOBE_SIZE];
            let (mut filled, mut sum) = (0, f32x16::splat(simd, 0.0));
            for (p, wp) in [(phi, 1.0 - fp), (phi + 1, fp)] {
                for (t, wt) in [(t, wp * (1.0 - ft)), (t + 1, wp * ft)] {
                    for (o, weight) in [(o, wt * (1.0 - fo)), (o + 1, wt * fo)] {
                        // A weight of zero is that of a node beyond the last, too.
                        if weight == 0.0 {
                            continue;
                        }
                        if filled + count > LANES {
                            sum = lobe_sum(simd, &lanes, w, sum);
                            lanes[3] = [0.0; LANES];
                            filled = 0;
                        }
                        let node = &table.data[axes.index(t, p, o) * stride..][..stride];
                        for k in (0..count).step_by(GROUP) {
                            for (slot, lane) in lanes.iter_mut().enumerate() {
                                let scale = if slot == 3 { weight } else { 1.0 };
                                for i in 0..GROUP {
                                    lane[filled + i] = scale * node[slot * count + k + i];
                                }
                            }
                            filled += GROUP;
                        }
                    }
                }
            }
            *out = lobe_sum(simd, &lanes, w, sum).to_array().iter().sum::<f32>().max(0.0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::{mirror, spherical};

    /// The mirror direction is the pole, angles are kept, and the y axis follows the quadrant of the cap.
    #[test]
    fn mirror_frame() {
        for (theta, phi) in [(0.01, 0.1), (0.4, 0.5), (1.2, 2.0), (0.9, 4.0), (1.5, -0.5)] {
            let axis = spherical(theta, phi);
            assert!((into_mirror_frame(axis, mirror(axis)) - DVec3::Z).length() < 1e-12);
            let (a, b) = (spherical(0.8, 1.0), spherical(0.3, 5.0));
            let (fa, fb) = (into_mirror_frame(axis, a), into_mirror_frame(axis, b));
            assert!((fa.dot(fb) - a.dot(b)).abs() < 1e-12 && (fa.length() - 1.0).abs() < 1e-12);
            let flip = |w: DVec3| DVec3::new(-w.x, w.y, w.z);
            let there = into_mirror_frame(flip(axis), flip(a));
            assert!((there - fa).length() < 1e-12, "{theta} {phi}: {there} {fa}");
        }
    }

    #[test]
    fn corner_weights_add_up() {
        let axes = Axes { theta: 4, phi: 3, omega: 5, sharpness: 30.0, stretch: 1.0 };
        let lobe = Lobe { axis: DVec3::Z, amplitude: 1.0, exponent: 9.0 };
        let table = Lobes::from_nodes(axes, &vec![vec![lobe]; axes.len()]).unwrap();
        for i in 0..200 {
            let x = f64::from(i) / 199.0;
            let cap = Cap::new(1.57 * x, 7.0 * x, 1e-6 + 6.0 * x * x).unwrap();
            let w = spherical(0.3, 1.0 + x);
            let wo = mirror(cap.axis());
            assert!((table.value(&cap, wo) - if wo.z > 0.0 { 1.0 } else { 0.0 }).abs() < 1e-6, "{x} {w}");
        }
        for node in 0..axes.len() {
            assert_eq!(table.node(node)[0], lobe);
        }
    }

    #[test]
    fn numbers_that_make_no_lobe_are_refused() {
        let axes = Axes { theta: 2, phi: 1, omega: 2, sharpness: 1.0, stretch: 1.0 };
        let with = |axis: DVec3, amplitude: f64, exponent: f64| {
            Lobes::from_nodes(axes, &vec![vec![Lobe { axis, amplitude, exponent }]; 4]).is_ok()
        };
        assert!(with(DVec3::Z, -3.0, 1e5));
        assert!(!with(2.0 * DVec3::Z, 1.0, 1.0) && !with(DVec3::ZERO, 1.0, 1.0) && !with(DVec3::NAN, 1.0, 1.0));
        assert!(!with(DVec3::Z, f64::NAN, 1.0) && !with(DVec3::Z, 1e13, 1.0));
        assert!(!with(DVec3::Z, 1.0, 0.0) && !with(DVec3::Z, 1.0, 1e9) && !with(DVec3::Z, 1.0, f64::NAN));
    }
}
