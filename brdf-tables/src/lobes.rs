//! The lobe table: signed generalized cosine lobes per cell of (θe, φe, Ω), blended as values in the mirror frame.
//!
//! The frame of a query has its z axis along the mirrored cap axis and its x axis in the plane of incidence, so that the
//! lobes of all cells line up whatever their θe: the values of the corners are interpolated there, never their
//! coefficients (whose peak falls by exp(−nΔθ²/8) between two rows, and which need not be in the same order).

use crate::axis::{Axes, Place};
use crate::batch::{CapBatch, MIN_HEIGHT};
use crate::cap::Cap;
use crate::lobe::Lobe;
use crate::mean::MeanBrdf;
use crate::real::{LANES, Real};
use core::f64::consts::TAU;
use fearless_simd::{Level, Simd, dispatch, f32x16, prelude::*};
use glam::{DVec3, Vec3};

/// Numbers stored per lobe: axis, amplitude, exponent.
pub const LOBE_SIZE: usize = 5;

/// A grid of sums of lobes.
#[derive(Clone, Debug, PartialEq)]
pub struct Lobes {
    axes: Axes,
    count: usize,
    /// Per node: `count` values each of axis x, y, z, amplitude, exponent.
    data: Vec<f32>,
}

impl Lobes {
    /// From the numbers of all nodes; `None` when their count is wrong or one cannot belong to a lobe.
    pub fn new(axes: Axes, count: usize, data: Vec<f32>) -> Option<Self> {
        let stride = count.checked_mul(LOBE_SIZE)?;
        if count == 0 || count > LANES || stride.checked_mul(axes.len())? != data.len() {
            return None;
        }
        let valid = data.chunks(stride).all(|node| {
            node.iter().all(|x| x.is_finite() && x.abs() <= 1e12) && node[4 * count..].iter().all(|n| *n > 0.0)
        });
        valid.then_some(Self { axes, count, data })
    }

    /// From one list of lobes per node, each in the mirror frame of its node; short lists are padded with zeros.
    pub fn from_nodes(axes: Axes, nodes: &[Vec<Lobe>]) -> Option<Self> {
        let count = nodes.iter().map(Vec::len).max()?.max(1);
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

/// One cap at a time, sixteen lobes of its corners at once.
#[inline(always)]
fn batch<S: Simd>(simd: S, table: &Lobes, caps: &CapBatch, wo: Vec3, out: &mut [f32]) {
    let (count, stride) = (table.count, table.count * LOBE_SIZE);
    for (i, out) in out.iter_mut().enumerate() {
        let (axis, solid_angle) = caps.get(i);
        let axis = axis.as_dvec3();
        let w = into_mirror_frame(axis, wo.as_dvec3()).as_vec3();
        let mut lanes = [[0f32; LANES]; LOBE_SIZE];
        let (mut filled, mut sum) = (0, 0.0);
        let flush = |lanes: &[[f32; LANES]; LOBE_SIZE]| -> f32 {
            let [x, y, z, a, n] = lanes.map(|lane| f32x16::load_array(simd, lane));
            let cos = x * w.x + y * w.y + z * w.z;
            (a * cos.powf(n)).to_array().iter().sum()
        };
        for (node, weight) in table.around(axis, f64::from(solid_angle).clamp(TAU * f64::from(MIN_HEIGHT), TAU)) {
            if filled + count > LANES {
                sum += flush(&lanes);
                lanes = [[0f32; LANES]; LOBE_SIZE];
                filled = 0;
            }
            let node = &table.data[node * stride..][..stride];
            for (slot, lane) in lanes.iter_mut().enumerate() {
                lane[filled..filled + count].copy_from_slice(&node[slot * count..][..count]);
            }
            lanes[3][filled..filled + count].iter_mut().for_each(|a| *a *= weight as f32);
            filled += count;
        }
        *out = (sum + flush(&lanes)).max(0.0);
    }
}
