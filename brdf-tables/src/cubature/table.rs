//! The cubature as a table: the order of the rule per cell of (θe, φe, Ω), chosen by the fitter as the least that meets
//! the tolerance there.

use super::{Footprint, Side, holds_pole, numerator};
use crate::axis::Axes;
use crate::batch::{CapBatch, MIN_HEIGHT};
use crate::brdf::{Brdf, Formula, Specular, Visitor};
use crate::cap::{Cap, projected_solid_angle};
use crate::frame::mirror;
use crate::gauss::gauss_legendre;
use crate::mean::MeanBrdf;
use crate::real::{LANES, Real};
use core::f64::consts::{FRAC_PI_2, PI};
use fearless_simd::{Level, Simd, dispatch, f32x16, prelude::*};
use glam::{DVec3, Vec3};
use std::sync::OnceLock;

/// Orders a cell may ask for, in both directions; a table stores indices into this list.
pub const ORDERS: [usize; 10] = [1, 2, 3, 4, 5, 6, 8, 10, 12, 16];
/// Rules up to this index (3 × 3) serve caps smaller than the lobe: they divide by their own estimate of the denominator.
const SELF_NORMALISED: usize = 2;
/// Order index (2 × 2) for views beyond the outer angle of a node.
pub const OUTER: u8 = 1;
/// Instead of an order, for views beyond the far angle of a node: the BRDF at the cap's axis stands for the mean.
const FAR: u8 = u8::MAX;

/// What a table says of one node: the order index within the lobe, and the angles between `wo` and the mirrored cap axis,
/// in steps of π/255 rounded up, beyond which the 2 × 2 rule and the BRDF at the axis do.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Node {
    /// Index into [`ORDERS`].
    pub order: u8,
    /// Where [`OUTER`] begins to do.
    pub outer: u8,
    /// Where the BRDF at the axis begins to do.
    pub far: u8,
}

/// An interval of the grid, as the look-up uses it: the largest of its corners; the angles as (2 sin ½s)².
#[derive(Clone, Copy, Debug, PartialEq)]
struct Interval {
    order: u8,
    outer2: f32,
    far2: f32,
}

impl Interval {
    /// The order index for a squared distance between `wo` and the mirrored axis.
    #[inline(always)]
    fn order(&self, distance2: f32) -> u8 {
        match distance2 {
            d if d > self.far2 => FAR,
            d if d > self.outer2 => self.order.min(OUTER),
            _ => self.order,
        }
    }
}

/// A Gauss–Legendre rule in f64 and in f32.
type Rule = (Vec<(f64, f64)>, Vec<(f32, f32)>);

/// The rule of order `ORDERS[index]`.
fn rule(index: usize) -> &'static Rule {
    static RULES: OnceLock<Vec<Rule>> = OnceLock::new();
    let build = |&n| {
        let rule = gauss_legendre(n);
        let single = rule.iter().map(|&(x, w)| (x as f32, w as f32)).collect();
        (rule, single)
    };
    &RULES.get_or_init(|| ORDERS.iter().map(build).collect())[index]
}

/// Cap cubature of the model itself.
#[derive(Clone, Debug, PartialEq)]
pub struct Cubature {
    specular: Specular,
    isotropic: bool,
    axes: Axes,
    nodes: Vec<Node>,
    intervals: Vec<Interval>,
}

impl Cubature {
    /// From the nodes of `axes`; `None` when an order index or the count is wrong.
    pub fn new(specular: Specular, axes: Axes, nodes: &[Node]) -> Option<Self> {
        if nodes.len() != axes.len() || nodes.iter().any(|n| usize::from(n.order) >= ORDERS.len()) {
            return None;
        }
        let (nt, np, no) = (axes.theta as usize, axes.phi as usize, axes.omega as usize);
        let mut intervals = Vec::with_capacity((nt - 1) * (no - 1));
        for t in 0..nt - 1 {
            for o in 0..no - 1 {
                // The azimuth is left out of the look-up: an interval takes the largest over it.
                let corners = (0..np).flat_map(|p| [(t, p, o), (t + 1, p, o), (t, p, o + 1), (t + 1, p, o + 1)]);
                let largest = corners.fold(Node::default(), |a, (t, p, o)| {
                    let b = nodes[axes.index(t, p, o)];
                    Node { order: a.order.max(b.order), outer: a.outer.max(b.outer), far: a.far.max(b.far) }
                });
                let chord2 = |angle: u8| (2.0 * (0.5 * PI * f64::from(angle) / 255.0).sin()).powi(2) as f32;
                let (outer2, far2) = (chord2(largest.outer), chord2(largest.far));
                intervals.push(Interval { order: largest.order, outer2, far2 });
            }
        }
        let isotropic = specular.is_isotropic();
        Some(Self { specular, isotropic, axes, nodes: nodes.to_vec(), intervals })
    }

    /// Grid and nodes, as [`Cubature::new`] takes them.
    pub fn parts(&self) -> (Axes, &[Node]) {
        (self.axes, &self.nodes)
    }

    /// One order (an index into [`ORDERS`]) everywhere.
    pub fn uniform(specular: Specular, order: u8) -> Option<Self> {
        let axes = Axes { theta: 2, phi: 1, omega: 2, sharpness: 1.0, stretch: 1.0 };
        Self::new(specular, axes, &[Node { order, outer: u8::MAX, far: u8::MAX }; 4])
    }

    /// For caps that cross the horizon, the numerator of eq. 9 from the integral over the whole cap (in which cosθi is
    /// negative below the horizon), by subtracting the part below: small, so that few nodes do. Caps listed in `picked`;
    /// `whole` holds their whole integrals and receives the result. The formula must hold below the horizon.
    #[inline(always)]
    pub(crate) fn clip<S: Simd>(&self, simd: S, caps: &CapBatch, picked: &[u32], wo: Vec3, whole: &mut [f32]) {
        struct Run<'a, S>(S, &'a Cubature, &'a CapBatch, &'a [u32], DVec3, &'a mut [f32]);
        impl<S: Simd> Visitor for Run<'_, S> {
            type Output = ();
            #[inline(always)]
            fn visit<M: Brdf + Formula>(self, model: &M) {
                let Run(simd, table, caps, picked, wo, whole) = self;
                let (view, (_, rule)) = (View::new(table, wo), rule(table.largest()));
                for (block, whole) in picked.chunks(LANES).zip(whole.chunks_mut(LANES)) {
                    let (axis, height) = gather(simd, caps, block, &view);
                    let (part, _) = simd.vectorize(
                        #[inline(always)]
                        || numerator(model, &view.lobe, view.turn, axis, height, Side::Below, rule),
                    );
                    let pole = Real::select(holds_pole(axis, height), height.lit(1.0), height.lit(0.0)).to_array();
                    for ((whole, part), pole) in whole.iter_mut().zip(part.to_array()).zip(pole) {
                        *whole = if pole > 0.0 { part } else { *whole - part };
                    }
                }
            }
        }
        if !picked.is_empty() {
            self.specular.visit(Run(simd, self, caps, picked, wo.as_dvec3(), whole));
        }
    }

    /// The means over the caps listed in `picked`, by the largest order of the table, handed to `store` with their index.
    #[inline(always)]
    pub(crate) fn values_at<S: Simd>(
        &self,
        simd: S,
        caps: &CapBatch,
        picked: &[u32],
        wo: Vec3,
        store: impl FnMut(usize, f32),
    ) {
        struct Run<'a, S, F>(S, &'a Cubature, &'a CapBatch, &'a [u32], DVec3, F);
        impl<S: Simd, F: FnMut(usize, f32)> Visitor for Run<'_, S, F> {
            type Output = ();
            #[inline(always)]
            fn visit<M: Brdf + Formula>(mut self, model: &M) {
                let view = View::new(self.1, self.4);
                picked_caps(self.0, model, &view, self.1.largest(), self.2, self.3, &mut self.5);
            }
        }
        if !picked.is_empty() {
            self.specular.visit(Run(simd, self, caps, picked, wo.as_dvec3(), store));
        }
    }

    /// [`Cubature::clip`] for one cap, in f64.
    pub(crate) fn clip_value(&self, cap: &Cap, wo: DVec3, whole: f64) -> f64 {
        struct Run<'a>(&'a Cubature, &'a Cap, DVec3, f64);
        impl Visitor for Run<'_> {
            type Output = f64;
            fn visit<M: Brdf + Formula>(self, model: &M) -> f64 {
                let Run(table, cap, wo, whole) = self;
                let (view, (rule, _)) = (View::new(table, wo), rule(table.largest()));
                let (axis, height) = (into_frame(cap.axis().to_array(), view.rotation), cap.height());
                let (part, _) = numerator(model, &view.lobe, view.turn, axis, height, Side::Below, rule);
                if holds_pole(axis, height) { part } else { whole - part }
            }
        }
        self.specular.visit(Run(self, cap, wo, whole))
    }

    /// The largest order index of the table.
    fn largest(&self) -> usize {
        usize::from(self.intervals.iter().map(|i| i.order).max().unwrap_or(0))
    }

    fn order(&self, cap: &Cap, wo: DVec3) -> u8 {
        let place = (self.axes.theta_place(cap.theta()), self.axes.omega_place(cap.solid_angle()));
        let interval = self.intervals[place.0.index * (self.axes.omega as usize - 1) + place.1.index];
        interval.order((wo - mirror(cap.axis())).length_squared() as f32)
    }

    /// The order index of sixteen caps at once.
    #[inline(always)]
    fn orders<S: Simd>(&self, simd: S, lanes: [&[f32; LANES]; 4], wo: Vec3) -> [u8; LANES] {
        let [cx, cy, cz, height] = lanes.map(|lanes| f32x16::load_array_ref(simd, lanes));
        let (nt, no) = (self.axes.theta - 1, self.axes.omega - 1);
        let theta = (cz.lit(FRAC_PI_2) - Real::asin(Real::min(cz, cz.lit(1.0)))) * cz.lit(f64::from(nt) / FRAC_PI_2);
        // n Ω/4π = n h/2
        let top = (1.0 + 0.5 * self.axes.sharpness).log2();
        let tau = (height * cz.lit(0.5 * self.axes.sharpness) + 1.0).log2() * cz.lit(1.0 / top);
        let tau = tau.powf(cz.lit(self.axes.stretch)) * cz.lit(f64::from(no));
        let t = Real::floor(Real::min(theta, cz.lit(f64::from(nt - 1))));
        let o = Real::floor(Real::min(tau, cz.lit(f64::from(no - 1))));
        let index = Real::max(t * cz.lit(f64::from(no)) + o, cz.lit(0.0)).to_array();
        let distance2 = ((cx + wo.x).sq() + (cy + wo.y).sq() + (cz - wo.z).sq()).to_array();
        core::array::from_fn(|i| self.intervals[(index[i] as usize).min(self.intervals.len() - 1)].order(distance2[i]))
    }
}

/// Caps sorted by order at a time; fixed, so that sorting needs no allocation.
const CHUNK: usize = 256;

impl MeanBrdf for Cubature {
    fn name(&self) -> &'static str {
        "cubature"
    }

    fn value(&self, cap: &Cap, wo: DVec3) -> f64 {
        struct Run<'a>(&'a Cubature, &'a Cap, DVec3);
        impl Visitor for Run<'_> {
            type Output = f64;
            fn visit<M: Brdf + Formula>(self, model: &M) -> f64 {
                let Run(table, cap, wo) = self;
                let view = View::new(table, wo);
                let order = table.order(cap, wo);
                if order == FAR {
                    return model.f(cap.axis().to_array(), wo.to_array());
                }
                let order = usize::from(order);
                let (rule, _) = rule(order);
                let axis = into_frame(cap.axis().to_array(), view.rotation);
                let height = cap.height().max(f64::from(MIN_HEIGHT));
                let (sum, area) = numerator(model, &view.lobe, view.turn, axis, height, Side::Above, rule);
                let area = if order <= SELF_NORMALISED { area } else { projected_solid_angle(axis[2], height) };
                // The smallest caps on the horizon can vanish in rounding.
                sum.max(0.0) / area.max(1e-30)
            }
        }
        if wo.z <= 0.0 {
            return 0.0;
        }
        self.specular.visit(Run(self, cap, wo))
    }

    fn values(&self, caps: &CapBatch, wo: Vec3, out: &mut [f32]) {
        struct Run<'a>(&'a Cubature, &'a CapBatch, DVec3, &'a mut [f32]);
        impl Visitor for Run<'_> {
            type Output = ();
            fn visit<M: Brdf + Formula>(self, model: &M) {
                let Run(table, caps, wo, out) = self;
                dispatch!(Level::new(), simd => batch(simd, table, model, caps, wo, out));
            }
        }
        let out = &mut out[..caps.len()];
        if wo.z <= 0.0 {
            return out.fill(0.0);
        }
        self.specular.visit(Run(self, caps, wo.as_dvec3(), out));
    }
}

/// A direction of the surface frame in the frame of `wo`.
#[inline(always)]
fn into_frame<T: Real>([x, y, z]: [T; 3], (c, s): (f64, f64)) -> [T; 3] {
    [x * x.lit(c) + y * x.lit(s), y * x.lit(c) - x * x.lit(s), z]
}

#[inline(always)]
fn batch<S: Simd, M: Formula>(simd: S, table: &Cubature, model: &M, caps: &CapBatch, wo: DVec3, out: &mut [f32]) {
    let view = View::new(table, wo);
    for start in (0..caps.len()).step_by(CHUNK) {
        let count = CHUNK.min(caps.len() - start);
        let mut orders = [0u8; CHUNK];
        let mut present = 0u32;
        for block in (0..count).step_by(LANES) {
            let found = table.orders(simd, caps.lanes(start + block), wo.as_vec3());
            orders[block..block + LANES].copy_from_slice(&found);
        }
        for (block, orders) in orders[..count].chunks(LANES).enumerate() {
            let first = start + block * LANES;
            if orders.contains(&FAR) {
                let [x, y, z, _] = caps.lanes(first).map(|lanes| f32x16::load_array_ref(simd, lanes));
                let at_axis = simd.vectorize(
                    #[inline(always)]
                    || model.f([x, y, z], wo.as_vec3().to_array().map(|w| f32x16::splat(simd, w))),
                );
                out[first..first + orders.len()].copy_from_slice(&at_axis.to_array()[..orders.len()]);
            }
            for &order in orders.iter().filter(|order| **order != FAR) {
                present |= 1 << order;
            }
        }
        // Caps of one order together, sixteen at a time.
        let mut picked = [0u32; CHUNK];
        for order in (0..ORDERS.len()).filter(|o| present >> o & 1 == 1) {
            let mut filled = 0;
            for (i, _) in orders[..count].iter().enumerate().filter(|(_, o)| usize::from(**o) == order) {
                picked[filled] = (start + i) as u32;
                filled += 1;
            }
            picked_caps(simd, model, &view, order, caps, &picked[..filled], &mut |i, value| out[i] = value);
        }
    }
}

/// What depends on `wo` alone: the lobe's footprint, the rotation into the frame of `wo`, and the one back.
struct View {
    lobe: Footprint,
    rotation: (f64, f64),
    turn: (f64, f64),
}

impl View {
    fn new(table: &Cubature, wo: DVec3) -> Self {
        let (lobe, rotation) = Footprint::new(&table.specular, wo);
        let turn = if table.isotropic { (1.0, 0.0) } else { rotation };
        Self { lobe, rotation, turn }
    }
}

/// The means over the caps listed in `picked`, by the rule of one order, handed to `store` with their index.
#[inline(always)]
fn picked_caps<S: Simd, M: Formula>(
    simd: S,
    model: &M,
    view: &View,
    order: usize,
    caps: &CapBatch,
    picked: &[u32],
    store: &mut impl FnMut(usize, f32),
) {
    let (_, rule) = rule(order);
    for block in picked.chunks(LANES) {
        let (axis, height) = gather(simd, caps, block, view);
        let (sum, area) = simd.vectorize(
            #[inline(always)]
            || numerator(model, &view.lobe, view.turn, axis, height, Side::Above, rule),
        );
        let area = if order <= SELF_NORMALISED { area } else { projected_solid_angle(axis[2], height) };
        let values = (Real::max(sum, height.lit(0.0)) / Real::max(area, height.lit(1e-30))).to_array();
        for (&i, value) in block.iter().zip(values) {
            store(i as usize, value);
        }
    }
}

/// Axes in the frame of `wo`, and heights, of up to sixteen listed caps; lanes to spare repeat the last.
#[inline(always)]
fn gather<S: Simd>(simd: S, caps: &CapBatch, block: &[u32], view: &View) -> ([f32x16<S>; 3], f32x16<S>) {
    let mut lanes = [[0f32; LANES]; 4];
    for k in 0..LANES {
        let i = block[k.min(block.len() - 1)] as usize;
        lanes[0][k] = caps.axis[0][i];
        lanes[1][k] = caps.axis[1][i];
        lanes[2][k] = caps.axis[2][i];
        lanes[3][k] = caps.height[i];
    }
    let [x, y, z, height] = lanes.map(|lane| f32x16::load_array(simd, lane));
    (into_frame([x, y, z], view.rotation), height)
}
