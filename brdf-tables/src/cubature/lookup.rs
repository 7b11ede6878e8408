//! The look-up in vectors: caps sorted by their rule, then integrated with a cap, or a node of the rule, per lane.

use super::bins::FAR;
use super::disc::disc;
use super::rule::{Nodes, RULES};
use super::spread::{Numbers, numbers};
use super::{Cubature, Side, holds_pole, numerator};
use crate::batch::{CHUNK, CapBatch, Picked};
use crate::brdf::{Brdf, Footprint, Formula, Visitor};
use crate::cap::projected_solid_angle;
use crate::real::{LANES, Real};
use core::ops::Range;
use fearless_simd::{Simd, f32x16, prelude::*, u8x64, u32x16};
use glam::{DVec3, Vec3};

/// What depends on the direction to the eye, `wo`, alone, so that it is computed once for all caps of a look-up.
///
/// The integrals are taken in the *frame of `wo`*: the surface frame turned about the normal until `wo` lies in the plane
/// y = 0. A rotation about the normal is kept as the cosine and sine of its angle ([`into_frame`]).
pub struct View {
    /// `wo` in the frame in which disc rules are taken, and the rotation from the surface frame into it. An isotropic formula
    /// does not change when everything turns about the normal: it is evaluated in the frame of `wo`. An anisotropic one has
    /// axes of its own on the surface: it is evaluated in the surface frame, and the rotation does nothing.
    pub disc: ([f64; 3], (f64, f64)),
    /// Where the lobe of `wo` lies and how wide it is.
    pub lobe: Footprint,
    /// Rotation from the surface frame into the frame of `wo`: (cos, sin) of the azimuth of `wo`.
    pub rotation: (f64, f64),
    /// By how much the nodes of a product rule are turned back before the formula is evaluated: by `rotation` if it is
    /// anisotropic, not at all if it is isotropic.
    pub turn: (f64, f64),
}

impl View {
    /// The view along `wo`, for the formula of a table.
    pub fn new(table: &Cubature, wo: DVec3) -> Self {
        let (lobe, rotation) = table.specular.footprint(wo);
        let none = (1.0, 0.0);
        let (disc, turn) = if table.isotropic {
            (([lobe.sin_o, 0.0, lobe.cos_o], rotation), none)
        } else {
            ((wo.to_array(), none), rotation)
        };
        Self { disc, lobe, rotation, turn }
    }
}

/// A direction of the surface frame in the frame of `wo`.
#[inline(always)]
pub fn into_frame<T: Real>([x, y, z]: [T; 3], (c, s): (f64, f64)) -> [T; 3] {
    [x * x.lit(c) + y * x.lit(s), y * x.lit(c) - x * x.lit(s), z]
}

/// Numerator and denominator of the mean over one cap or a vector of them, or over their part below the horizon, for which
/// there are product rules only. Where the lanes hold nodes, the sums over them are wanted; a product rule gives the
/// denominator in each.
#[inline(always)]
pub fn integrals<T: Real, M: Formula>(
    model: &M,
    view: &View,
    side: Side,
    axis: [T; 3],
    height: T,
    nodes: &Nodes<T::Lanes>,
) -> (T, T) {
    match nodes {
        Nodes::Disc(rings) => {
            let ([x, y, z], rotation) = view.disc;
            let wo = [height.lit(x), height.lit(y), height.lit(z)];
            disc(model, wo, into_frame(axis, rotation), height, rings)
        }
        Nodes::Product(grid) => {
            let turned = into_frame(axis, view.rotation);
            let sum = numerator(model, &view.lobe, view.turn, turned, height, side, grid);
            (sum, projected_solid_angle(axis[2], height))
        }
    }
}

/// The means over all caps.
#[inline(always)]
pub fn lookup<S: Simd, M: Formula>(simd: S, table: &Cubature, model: &M, caps: &CapBatch, wo: DVec3, out: &mut [f32]) {
    let view = View::new(table, wo);
    let eye = Eye::new(simd, model, wo.as_vec3());
    let (mut picked, mut sums, mut areas) = (Picked::new(), [0.0; CHUNK + LANES], [0.0; CHUNK + LANES]);
    for start in (0..caps.len()).step_by(CHUNK) {
        let count = CHUNK.min(caps.len() - start);
        let at_axes = &mut out[start..start + count];
        let rules = Rules::new(simd, table, model, &eye, caps, start, at_axes);
        // Where it is long, the BRDF at the axis is computed where it is needed, if that is at few caps.
        let lone = M::LONG && rules.far(count) < count / LONE;
        if M::LONG && !lone {
            eye.all(simd, model, caps, start, at_axes);
        }
        let ends = rules.sort(simd, caps, start, lone, &mut picked);
        let kernel = Kernel { simd, model, view: &view, caps: &picked };
        let (far, end) = (ends[usize::from(FAR) + 1], ends[RULES.len()]);
        for (rule, ends) in ends.windows(2).enumerate().skip(usize::from(FAR) + 1) {
            kernel.each(Side::Above, rule, ends[0]..ends[1], |place, sum, area| {
                (sums[place], areas[place]) = (sum, area);
            });
        }
        let mut put = |first: usize, end: usize, values: [f32; LANES]| {
            for (value, i) in values.into_iter().zip(&picked.index[first..end]) {
                out[*i as usize] = value;
            }
        };
        if M::LONG {
            for first in (0..far).step_by(LANES) {
                let mut values = [0.0; LANES];
                eye.one(simd, model, picked.lanes(first), &mut values);
                put(first, far, values);
            }
        }
        for first in (far..end).step_by(LANES) {
            let sum = f32x16::from_slice(simd, &sums[first..first + LANES]);
            let area = f32x16::from_slice(simd, &areas[first..first + LANES]);
            let mean = Real::max(sum, sum.lit(0.0)) / Real::max(area, area.lit(1e-30));
            put(first, end, mean.to_array());
        }
    }
}

/// One cap in so many is few.
const LONE: usize = 4;

/// The direction to the eye in lanes, and the factor that it gives.
struct Eye<T> {
    vector: Vec3,
    wo: [T; 3],
    factor: T,
}

impl<S: Simd> Eye<f32x16<S>> {
    #[inline(always)]
    fn new<M: Formula>(simd: S, model: &M, vector: Vec3) -> Self {
        let Vec3 { x, y, z } = vector;
        let wo = [f32x16::splat(simd, x), f32x16::splat(simd, y), f32x16::splat(simd, z)];
        Self { vector, wo, factor: model.factor(wo) }
    }

    /// The BRDF at the axes of a vector of caps, as many as `out` has room for.
    #[inline(always)]
    fn one<M: Formula>(&self, simd: S, model: &M, lanes: [&[f32; LANES]; 4], out: &mut [f32]) {
        self.store(model.rest(axis(simd, lanes), self.wo), out);
    }

    /// The same at the axes of all caps from `start` on that `out` has room for.
    #[inline(always)]
    fn all<M: Formula>(&self, simd: S, model: &M, caps: &CapBatch, start: usize, out: &mut [f32]) {
        let (fours, last) = out.as_chunks_mut::<{ 4 * LANES }>();
        let mut block = start;
        for out in fours {
            let (a, b) = (axis(simd, caps.lanes(block)), axis(simd, caps.lanes(block + LANES)));
            let (c, d) = (axis(simd, caps.lanes(block + 2 * LANES)), axis(simd, caps.lanes(block + 3 * LANES)));
            for (rest, out) in model.rest_of_four([a, b, c, d], self.wo).into_iter().zip(out.chunks_mut(LANES)) {
                self.store(rest, out);
            }
            block += 4 * LANES;
        }
        for out in last.chunks_mut(LANES) {
            self.one(simd, model, caps.lanes(block), out);
            block += LANES;
        }
    }

    #[inline(always)]
    fn store(&self, rest: f32x16<S>, out: &mut [f32]) {
        let value = rest * self.factor;
        let values = Real::max(value, value.lit(0.0)).to_array();
        match out.first_chunk_mut() {
            Some(out) => *out = values,
            None => out.copy_from_slice(&values[..out.len()]),
        }
    }
}

/// The axes of a vector of caps, above the horizon, for which models are made.
#[inline(always)]
fn axis<S: Simd>(simd: S, [x, y, z, _]: [&[f32; LANES]; 4]) -> [f32x16<S>; 3] {
    let z = f32x16::load_array_ref(simd, z);
    [f32x16::load_array_ref(simd, x), f32x16::load_array_ref(simd, y), Real::max(z, z.lit(1e-9))]
}

/// What every vector of a look-up needs.
struct Kernel<'a, S, M> {
    simd: S,
    model: &'a M,
    view: &'a View,
    caps: &'a Picked,
}

impl<S: Simd, M: Formula> Kernel<'_, S, M> {
    /// [`integrals`] of the listed caps by one rule, handed to `store` with their place in the list.
    #[inline(always)]
    fn each(&self, side: Side, rule: usize, places: Range<usize>, mut store: impl FnMut(usize, f32, f32)) {
        let Numbers { lanes: nodes, spread, .. } = numbers(rule);
        for start in places.clone().step_by(LANES) {
            let end = places.end.min(start + LANES);
            if spread.pays(end - start) {
                for group in (start..end).step_by(spread.caps) {
                    let lanes = self.caps.spread(group, spread.caps);
                    let found = self.vector(side, lanes.each_ref(), &spread.nodes);
                    let [sums, areas] = spread.collect(&found);
                    for k in 0..spread.caps.min(end - group) {
                        store(group + k, sums[k], areas[k]);
                    }
                }
            } else {
                let [sums, areas] = self.vector(side, self.caps.lanes(start), nodes);
                for k in 0..end - start {
                    store(start + k, sums[k], areas[k]);
                }
            }
        }
    }

    /// [`integrals`] of a vector.
    #[inline(always)]
    fn vector(&self, side: Side, lanes: [&[f32; LANES]; 4], nodes: &Nodes<[f32; LANES]>) -> [[f32; LANES]; 2] {
        self.simd.vectorize(
            #[inline(always)]
            || {
                let [x, y, z, height] = lanes.map(|lanes| f32x16::load_array_ref(self.simd, lanes));
                let (sum, area) = integrals(self.model, self.view, side, [x, y, z], height, nodes);
                [sum.to_array(), area.to_array()]
            },
        )
    }
}

/// In place of a rule, where there is no cap.
const NO_CAP: u8 = u8::MAX;

/// The rules of the caps of a chunk.
struct Rules {
    /// Index of each.
    of: [u8; CHUNK],
    /// A bit for each rule that some cap takes.
    present: u32,
}

impl Rules {
    /// Those of the caps from `start` on, as many as `out` has room for; it receives the BRDF at the axes, which some caps keep,
    /// if it is not long.
    #[inline(always)]
    fn new<S: Simd, M: Formula>(
        simd: S,
        table: &Cubature,
        model: &M,
        eye: &Eye<f32x16<S>>,
        caps: &CapBatch,
        start: usize,
        out: &mut [f32],
    ) -> Self {
        let (mut of, mut present) = ([NO_CAP; CHUNK], u32x16::splat(simd, 0));
        let count = out.len();
        for ((block, out), of) in (start..).step_by(LANES).zip(out.chunks_mut(LANES)).zip(of.chunks_exact_mut(LANES)) {
            let lanes = caps.lanes(block);
            if !M::LONG {
                eye.one(simd, model, lanes, out);
            }
            let lanes = lanes.map(|lanes| f32x16::load_array_ref(simd, lanes));
            let rules = table.bins.of_lanes(simd, lanes, eye.vector);
            present |= u32x16::splat(simd, 1) << rules;
            of.copy_from_slice(&rules.to_array().map(|rule| rule as u8));
        }
        of[count..].fill(NO_CAP);
        Self { of, present: present.to_array().into_iter().fold(0, |all, bits| all | bits) }
    }

    /// How many of the first `count` caps keep the BRDF at the axis.
    #[inline(always)]
    fn far(&self, count: usize) -> usize {
        self.of[..count].iter().map(|rule| usize::from(*rule == FAR)).sum()
    }

    /// Puts the caps in a list by rule, and says where each rule begins; those that keep the BRDF at the axis are left out if
    /// not `lone`.
    #[inline(always)]
    fn sort<S: Simd>(
        &self,
        simd: S,
        caps: &CapBatch,
        start: usize,
        lone: bool,
        picked: &mut Picked,
    ) -> [usize; RULES.len() + 1] {
        let columns = caps.columns();
        let (mut ends, mut end) = ([0; RULES.len() + 1], 0);
        for rule in 0..RULES.len() as u8 {
            if (lone || rule != FAR) && self.present >> rule & 1 == 1 {
                for (first, rules) in (start as u32..).step_by(64).zip(self.of.chunks_exact(64)) {
                    let mut bits = u8x64::from_slice(simd, rules).simd_eq(rule).to_bitmask();
                    while bits != 0 {
                        picked.put(end, columns, first + bits.trailing_zeros());
                        bits &= bits - 1;
                        end += 1;
                    }
                }
            }
            ends[usize::from(rule) + 1] = end;
        }
        ends
    }
}

impl Cubature {
    /// [`Cubature::clip_value`] of the first caps of a list, as many as `whole` holds; it receives the result.
    #[inline(always)]
    pub(crate) fn clip<S: Simd>(&self, simd: S, picked: &Picked, wo: Vec3, whole: &mut [f32]) {
        let view = View::new(self, wo.as_dvec3());
        self.finest(simd, &view, Side::Below, picked, whole.len(), |place, part, _| {
            let [x, y, z, height] = picked.get(place);
            let pole = holds_pole(into_frame([x, y, z], view.rotation), height);
            whole[place] = if pole { part } else { whole[place] - part };
        });
    }

    /// The means over the first caps of a list by the finest product rule of the table, handed to `store` with their place.
    #[inline(always)]
    pub(crate) fn means<S: Simd>(
        &self,
        simd: S,
        picked: &Picked,
        count: usize,
        wo: Vec3,
        mut store: impl FnMut(usize, f32),
    ) {
        self.finest(simd, &View::new(self, wo.as_dvec3()), Side::Above, picked, count, |place, sum, area| {
            store(place, sum.max(0.0) / area.max(1e-30));
        });
    }

    /// [`Kernel::each`] by the finest product rule of the table.
    #[inline(always)]
    fn finest<S: Simd>(
        &self,
        simd: S,
        view: &View,
        side: Side,
        caps: &Picked,
        count: usize,
        store: impl FnMut(usize, f32, f32),
    ) {
        struct Run<'a, S, F>(S, &'a View, Side, usize, &'a Picked, usize, F);
        impl<S: Simd, F: FnMut(usize, f32, f32)> Visitor for Run<'_, S, F> {
            type Output = ();
            #[inline(always)]
            fn visit<M: Brdf + Formula>(self, model: &M) {
                let Run(simd, view, side, rule, caps, count, store) = self;
                Kernel { simd, model, view, caps }.each(side, rule, 0..count, store);
            }
        }
        if count > 0 {
            self.specular.visit(Run(simd, view, side, self.bins.finest(), caps, count, store));
        }
    }
}
