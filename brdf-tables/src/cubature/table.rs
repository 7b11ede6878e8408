//! The cubature as a table: the order of the rule per cell of (θe, φe, Ω), chosen by the fitter as the least that meets
//! the tolerance there.

use super::orders::{FAR, ORDERS, Orders};
use super::{Footprint, Node, Side, holds_pole, numerator};
use crate::axis::Axes;
use crate::batch::{CapBatch, MIN_HEIGHT};
use crate::brdf::{Brdf, Formula, FormulaVisitor, GrayPolynomial, Specular, Visitor};
use crate::cap::{Cap, projected_solid_angle};
use crate::gauss::gauss_legendre;
use crate::mean::MeanBrdf;
use crate::real::{LANES, Real};
use fearless_simd::{Level, Simd, dispatch, f32x16, prelude::*};
use glam::{DVec3, Vec3};
use std::sync::OnceLock;

/// Rules up to this index (3 × 3) serve caps smaller than the lobe: they divide by their own estimate of the denominator.
const SELF_NORMALISED: usize = 2;
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
    gray: Option<GrayPolynomial>,
    isotropic: bool,
    axes: Axes,
    nodes: Vec<Node>,
    orders: Orders,
}

impl Cubature {
    /// From the nodes of `axes`; `None` when an order index or the count is wrong.
    pub fn new(specular: Specular, axes: Axes, nodes: &[Node]) -> Option<Self> {
        let orders = Orders::new(axes, nodes)?;
        let isotropic = specular.is_isotropic();
        let gray = specular.gray_polynomial();
        Some(Self { specular, gray, isotropic, axes, nodes: nodes.to_vec(), orders })
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
                let (view, (_, rule)) = (View::new(table, wo), rule(table.orders.largest()));
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
                picked_caps(self.0, model, &view, self.1.orders.largest(), self.2, self.3, &mut self.5);
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
                let (view, (rule, _)) = (View::new(table, wo), rule(table.orders.largest()));
                let (axis, height) = (into_frame(cap.axis().to_array(), view.rotation), cap.height());
                let (part, _) = numerator(model, &view.lobe, view.turn, axis, height, Side::Below, rule);
                if holds_pole(axis, height) { part } else { whole - part }
            }
        }
        self.specular.visit(Run(self, cap, wo, whole))
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
                let order = table.orders.of(cap.axis().as_vec3(), cap.height() as f32, wo.as_vec3());
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
        impl FormulaVisitor for Run<'_> {
            type Output = ();
            fn visit<M: Formula>(self, model: &M) {
                let Run(table, caps, wo, out) = self;
                dispatch!(Level::new(), simd => batch(simd, table, model, caps, wo, out));
            }
        }
        let out = &mut out[..caps.len()];
        if wo.z <= 0.0 {
            return out.fill(0.0);
        }
        self.specular.visit_formula(self.gray.as_ref(), Run(self, caps, wo.as_dvec3(), out));
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
    let towards = wo.as_vec3().to_array().map(|w| f32x16::splat(simd, w));
    let factor = model.factor(towards);
    for start in (0..caps.len()).step_by(CHUNK) {
        let count = CHUNK.min(caps.len() - start);
        // Caps of one order together.
        let mut picked = [[0u32; CHUNK]; ORDERS.len() + 1];
        let mut filled = [0; ORDERS.len() + 1];
        for block in (start..start + count).step_by(LANES) {
            let lanes = caps.lanes(block).map(|lanes| f32x16::load_array_ref(simd, lanes));
            let orders = table.orders.of_lanes(simd, lanes, wo.as_vec3());
            let lanes_used = LANES.min(start + count - block);
            let before = filled[usize::from(FAR)];
            for (i, &order) in orders[..lanes_used].iter().enumerate() {
                let order = (order as usize).min(ORDERS.len());
                picked[order][filled[order]] = (block + i) as u32;
                filled[order] += 1;
            }
            if filled[usize::from(FAR)] > before {
                let [x, y, z, _] = lanes;
                let at_axis = simd.vectorize(
                    #[inline(always)]
                    || model.rest([x, y, z], towards) * factor,
                );
                out[block..block + lanes_used].copy_from_slice(&at_axis.to_array()[..lanes_used]);
            }
        }
        for (order, (picked, filled)) in picked.iter().zip(filled).enumerate().take(ORDERS.len()) {
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
        let values = (Real::max(sum, height.lit(0.0)) * Real::max(area, height.lit(1e-30)).recip()).to_array();
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
