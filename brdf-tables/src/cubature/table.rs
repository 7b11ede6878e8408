//! The cubature as a table: the rule per cell of (θe, φe, Ω), chosen by the fitter as the cheapest that meets
//! the tolerance there.

use super::bins::Bins;
use super::disc::disc;
use super::rule::{NONE, Nodes, RULES, Rule, nodes};
use super::{Footprint, Node, Side, holds_pole, numerator};
use crate::axis::Axes;
use crate::batch::{CapBatch, MIN_HEIGHT, blocks};
use crate::brdf::{Brdf, Formula, FormulaVisitor, GrayPolynomial, Specular, Visitor};
use crate::cap::{Cap, projected_solid_angle};
use crate::mean::MeanBrdf;
use crate::real::{LANES, Real, Vector};
use fearless_simd::{Level, Simd, dispatch, f32x8, f32x16, prelude::*};
use glam::{DVec3, Vec3};

/// Cap cubature of the model itself.
#[derive(Clone, Debug, PartialEq)]
pub struct Cubature {
    specular: Specular,
    gray: Option<GrayPolynomial>,
    isotropic: bool,
    axes: Axes,
    nodes: Vec<Node>,
    bins: Bins,
}

impl Cubature {
    /// From the nodes of `axes`; `None` when the index of a rule or the count is wrong.
    pub fn new(specular: Specular, axes: Axes, nodes: &[Node]) -> Option<Self> {
        let bins = Bins::new(axes, nodes)?;
        let isotropic = specular.is_isotropic();
        let gray = specular.gray_polynomial();
        Some(Self { specular, gray, isotropic, axes, nodes: nodes.to_vec(), bins })
    }

    /// Grid and nodes, as [`Cubature::new`] takes them.
    pub fn parts(&self) -> (Axes, &[Node]) {
        (self.axes, &self.nodes)
    }

    /// One rule of [`RULES`] everywhere.
    ///
    /// # Panics
    /// If the rule is not in that list.
    pub fn uniform(specular: Specular, rule: Rule) -> Self {
        let axes = Axes { theta: 2, phi: 1, omega: 2, sharpness: 1.0, stretch: 1.0 };
        let (disc, product) = match rule {
            Rule::Disc(_) => (rule.index(), RULES.len() as u8 - 1),
            Rule::Product(_) => (NONE, rule.index()),
        };
        let node = Node { disc, product, outer: u8::MAX, far: u8::MAX };
        Self::new(specular, axes, &[node; 4]).expect("a rule of the list")
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
                let (view, (_, Nodes::Product(rule))) = (View::new(table, wo), nodes(table.bins.finest())) else {
                    return;
                };
                for ((block, half), whole) in blocks(picked).zip(whole.chunks_mut(LANES)) {
                    let lanes = caps.gather(block);
                    if half {
                        above::<S, f32x8<S>, M>(simd, model, &view, rule, &lanes, whole);
                    } else {
                        above::<S, f32x16<S>, M>(simd, model, &view, rule, &lanes, whole);
                    }
                }
            }
        }
        if !picked.is_empty() {
            self.specular.visit(Run(simd, self, caps, picked, wo.as_dvec3(), whole));
        }
    }

    /// The means over the caps listed in `picked`, by the finest product rule of the table, handed to `store` with their index.
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
                picked_caps(self.0, model, &view, self.1.bins.finest(), self.2, self.3, &mut self.5);
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
                let (view, (Nodes::Product(rule), _)) = (View::new(table, wo), nodes(table.bins.finest())) else {
                    return whole;
                };
                let (axis, height) = (into_frame(cap.axis().to_array(), view.rotation), cap.height());
                let part = numerator(model, &view.lobe, view.turn, axis, height, Side::Below, rule);
                if holds_pole(axis, height) { part } else { whole - part }
            }
        }
        self.specular.visit(Run(self, cap, wo, whole))
    }
}

/// Caps sorted by their rule at a time; fixed, so that sorting needs no allocation.
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
                let rule = table.bins.of(cap.axis().as_vec3(), cap.height() as f32, wo.as_vec3());
                let axis = into_frame(cap.axis().to_array(), view.rotation);
                mean(model, &view, axis, cap.height().max(f64::from(MIN_HEIGHT)), &nodes(usize::from(rule)).0)
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
    for start in (0..caps.len()).step_by(CHUNK) {
        // Caps of one rule together, by counting.
        let count = CHUNK.min(caps.len() - start);
        let (mut rules, mut counts) = ([0u8; CHUNK], [0; RULES.len()]);
        for block in (0..count).step_by(LANES) {
            let lanes = caps.lanes(start + block).map(|lanes| f32x16::load_array_ref(simd, lanes));
            let found = table.bins.of_lanes(simd, lanes, wo.as_vec3());
            for (rule, found) in rules[block..count].iter_mut().zip(found) {
                *rule = (found as u8).min(RULES.len() as u8 - 1);
                counts[usize::from(*rule)] += 1;
            }
        }
        let (mut picked, mut ends) = ([0u32; CHUNK], [0; RULES.len()]);
        for i in 1..RULES.len() {
            ends[i] = ends[i - 1] + counts[i - 1];
        }
        for (i, &rule) in (start as u32..).zip(&rules[..count]) {
            let end = &mut ends[usize::from(rule)];
            picked[*end] = i;
            *end += 1;
        }
        for (rule, (&count, &end)) in counts.iter().zip(&ends).enumerate() {
            picked_caps(simd, model, &view, rule, caps, &picked[end - count..end], &mut |i, value| out[i] = value);
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

/// The mean over one cap, or a vector of them, in the frame of `wo`.
#[inline(always)]
fn mean<T: Real, M: Formula>(model: &M, view: &View, axis: [T; 3], height: T, nodes: &Nodes<T::Scalar>) -> T {
    let zero = height.lit(0.0);
    let (sum, area) = match nodes {
        Nodes::Disc(rings) => {
            let wo = [zero.lit(view.lobe.sin_o), zero, zero.lit(view.lobe.cos_o)];
            disc(model, wo, view.turn, axis, height, rings)
        }
        Nodes::Product(rule) => {
            let sum = numerator(model, &view.lobe, view.turn, axis, height, Side::Above, rule);
            (sum, projected_solid_angle(axis[2], height))
        }
    };
    // The smallest caps on the horizon can vanish in rounding.
    sum.max(zero) * area.max(zero.lit(1e-30)).recip()
}

/// The means over the caps listed in `picked`, by one rule, handed to `store` with their index.
#[inline(always)]
fn picked_caps<S: Simd, M: Formula>(
    simd: S,
    model: &M,
    view: &View,
    rule: usize,
    caps: &CapBatch,
    picked: &[u32],
    store: &mut impl FnMut(usize, f32),
) {
    let (_, nodes) = nodes(rule);
    for (block, half) in blocks(picked) {
        let lanes = caps.gather(block);
        let values = if half {
            means::<S, f32x8<S>, M>(simd, model, view, nodes, &lanes)
        } else {
            means::<S, f32x16<S>, M>(simd, model, view, nodes, &lanes)
        };
        for (&i, value) in block.iter().zip(values) {
            store(i as usize, value);
        }
    }
}

/// [`mean`] of a vector of caps.
#[inline(always)]
fn means<S: Simd, V: Vector<S>, M: Formula>(
    simd: S,
    model: &M,
    view: &View,
    nodes: &Nodes<f32>,
    lanes: &[[f32; LANES]; 4],
) -> [f32; LANES] {
    let mut values = [0.0; LANES];
    simd.vectorize(
        #[inline(always)]
        || {
            let [x, y, z, height] = lanes.each_ref().map(|lanes| V::load(simd, lanes));
            mean(model, view, into_frame([x, y, z], view.rotation), height, nodes).store(&mut values);
        },
    );
    values
}

/// Takes the part below the horizon away from the `whole` integrals of a vector of caps.
#[inline(always)]
fn above<S: Simd, V: Vector<S>, M: Formula>(
    simd: S,
    model: &M,
    view: &View,
    rule: &[(f32, f32)],
    lanes: &[[f32; LANES]; 4],
    whole: &mut [f32],
) {
    let (mut parts, mut poles) = ([0.0; LANES], [0.0; LANES]);
    simd.vectorize(
        #[inline(always)]
        || {
            let [x, y, z, height] = lanes.each_ref().map(|lanes| V::load(simd, lanes));
            let axis = into_frame([x, y, z], view.rotation);
            numerator(model, &view.lobe, view.turn, axis, height, Side::Below, rule).store(&mut parts);
            V::select(holds_pole(axis, height), height.lit(1.0), height.lit(0.0)).store(&mut poles);
        },
    );
    for ((whole, part), pole) in whole.iter_mut().zip(parts).zip(poles) {
        *whole = if pole > 0.0 { part } else { *whole - part };
    }
}
