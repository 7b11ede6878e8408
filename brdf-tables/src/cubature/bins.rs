//! Which rule a cap takes: the nodes of a table, resampled so that a look-up needs no transcendental function.
//!
//! A table has nodes on [`Axes`], where a fit is efficient. A look-up divides cosθe, the azimuth and the height of the cap
//! into bins that are found by a multiplication and a shift; a bin holds the largest of all nodes around it.

use super::rule::{NONE, RULES, Rule};
use crate::axis::Axes;
use crate::parts::PartsError;
use crate::real::Real;
use core::f64::consts::{PI, TAU};
use core::fmt;
use fearless_simd::{Select, Simd, f32x16, prelude::*, u32x16};
use glam::Vec3;
use std::sync::Arc;

/// Index of the rule for views beyond the outer angle of a node.
pub const OUTER: u8 = Rule::Disc(4).index();
/// For views beyond the far angle of a node: the BRDF at the cap's axis stands for the mean.
pub const FAR: u8 = Rule::Disc(1).index();

/// What a table says of one cap: which rule integrates it, which depends on how far the view is from its highlight.
///
/// Let β be the angle between `wo` and the mirror direction of the cap's axis. Near the highlight, at β below `outer`, the
/// BRDF varies over the cap, and the cheaper of `disc` and `product` is taken. From `outer` on a disc of 4 nodes is accurate
/// enough, and from `far` on the BRDF at the cap's axis. Both angles are in steps of π/255, rounded up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Node {
    /// Disc rule, an index into [`RULES`], or [`NONE`].
    pub disc: u8,
    /// Product rule, an index into [`RULES`].
    pub product: u8,
    /// The angle β from which [`OUTER`] is accurate enough.
    pub outer: u8,
    /// The angle β from which the BRDF at the axis is accurate enough.
    pub far: u8,
}

impl Node {
    /// Whether the indices are those of such rules.
    pub(crate) fn is_valid(self) -> bool {
        let rule = |index: u8| RULES.get(usize::from(index));
        (self.disc == NONE || matches!(rule(self.disc), Some(Rule::Disc(_))))
            && matches!(rule(self.product), Some(Rule::Product(_)))
    }

    /// What version 1 of the format said of a node: the order of a product rule and the angles beyond which a product of
    /// 2 × 2 nodes and the BRDF at the axis did. A disc of 4 is no better than that product: it begins where the BRDF does.
    pub(crate) fn from_version_1([order, _, far]: [u8; 3]) -> Option<Self> {
        const ORDERS: [usize; 10] = [1, 2, 3, 4, 5, 6, 8, 10, 12, 16];
        let least = *ORDERS.get(usize::from(order))?;
        let product = RULES.iter().position(|rule| matches!(rule, Rule::Product(n) if *n >= least))?;
        Some(Self { disc: NONE, product: product as u8, outer: far, far })
    }

    /// The larger of each number.
    pub fn or(self, other: Self) -> Self {
        Self {
            disc: self.disc.max(other.disc),
            product: self.product.max(other.product),
            outer: self.outer.max(other.outer),
            far: self.far.max(other.far),
        }
    }

    /// The cheaper rule of the two.
    fn rule(self) -> u8 {
        self.disc.min(self.product)
    }

    /// The rule in the low 4 bits, then the squares of the chords of `outer` and `far`, (2 sin ½s)², in 14 bits each.
    fn packed(self) -> u32 {
        let chord2 = |angle: u8| (2.0 * (0.5 * PI * f64::from(angle) / 255.0).sin()).powi(2);
        let bits = |angle: u8| ((chord2(angle) * CHORD_STEPS).ceil() as u32).min(CHORD_MASK);
        u32::from(self.rule()) | bits(self.outer) << 4 | bits(self.far) << 18
    }
}

const CHORD_MASK: u32 = (1 << 14) - 1;
/// Squared chords are at most 4.
pub(crate) const CHORD_STEPS: f64 = CHORD_MASK as f64 / 4.0;

/// Bins in cosθe, and in the azimuth of an anisotropic material.
pub(crate) const COSINES: usize = 64;
const AZIMUTHS: usize = 8;
/// Four bins of heights to an octave: the exponent and two bits of the mantissa.
pub(crate) const SHIFT: u32 = 21;

/// The bins.
#[derive(Clone, PartialEq)]
pub struct Bins {
    azimuths: usize,
    heights: Heights,
    cells: Arc<[u32]>,
    finest: u8,
}

/// The bins of heights.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Heights {
    /// What heights are multiplied by before: 1, or the sharpness of a lobe of a family.
    scale: f32,
    /// The bits of the lowest and of the highest bin; they take what is lower or higher too.
    first: u32,
    last: u32,
}

impl Heights {
    /// Heights from 2⁻²⁰ to 1.
    const PLAIN: Self = Self { scale: 1.0, first: (127 - 20) << 2, last: 127 << 2 };

    /// Heights times a sharpness, to the hemisphere of the largest. From 2⁻¹⁴ down a cap is a point to any lobe.
    fn sharp(most: f64) -> Self {
        let first = (127 - 14) << 2;
        Self { scale: 1.0, first, last: ((most as f32).to_bits() >> SHIFT).max(first) }
    }

    fn count(self) -> usize {
        (self.last - self.first + 1) as usize
    }

    /// Scaled heights that a bin may hold.
    fn bounds(self, bin: u32) -> [f64; 2] {
        let low = if bin == self.first { 0.0 } else { f32::from_bits(bin << SHIFT) };
        [low, f32::from_bits((bin + 1) << SHIFT)].map(f64::from)
    }
}

/// Without the cells: there are thousands.
impl fmt::Debug for Bins {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Self { azimuths, heights, cells, finest } = self;
        let cells = &cells.len();
        let mut s = f.debug_struct("Bins");
        s.field("azimuths", azimuths).field("heights", heights).field("cells", cells).field("finest", finest).finish()
    }
}

impl Bins {
    /// From the nodes of `axes`.
    ///
    /// # Errors
    /// The index of a rule or the count is wrong.
    pub fn new(axes: Axes, nodes: &[Node]) -> Result<Self, PartsError> {
        let solid_angle = |height: f64| TAU * height.min(1.0);
        let omegas =
            |[low, high]: [f64; 2]| nodes_between(solid_angle(low), solid_angle(high), |x| axes.omega_place(x).index);
        Self::fill(Heights::PLAIN, axes, nodes, omegas)
    }

    /// From nodes that hold for lobes of several widths, in heights times the sharpness of each, up to that of `axes`: for
    /// [`Bins::scaled`].
    ///
    /// # Errors
    /// As [`Bins::new`].
    pub(crate) fn of_family(axes: Axes, nodes: &[Node]) -> Result<Self, PartsError> {
        let place = |scaled: f64| axes.omega_place(TAU * (scaled / axes.sharpness).min(1.0)).index;
        let omegas = |[low, high]: [f64; 2]| [place(low), place(high) + 1];
        Self::fill(Heights::sharp(axes.sharpness), axes, nodes, omegas)
    }

    /// The same rule for all caps.
    pub(crate) fn uniform(node: Node) -> Self {
        let heights = Heights { last: Heights::PLAIN.first, ..Heights::PLAIN };
        Self { azimuths: 1, heights, cells: [node.packed(); COSINES].into(), finest: node.product }
    }

    /// For a lobe of this sharpness.
    pub(crate) fn scaled(&self, sharpness: f64) -> Self {
        Self { heights: Heights { scale: sharpness as f32, ..self.heights }, ..self.clone() }
    }

    /// Nodes on `axes`, those that a bin of heights touches given by `omegas`.
    fn fill(
        heights: Heights,
        axes: Axes,
        nodes: &[Node],
        omegas: impl Fn([f64; 2]) -> [usize; 2],
    ) -> Result<Self, PartsError> {
        PartsError::count(Some(axes.len()), nodes.len())?;
        PartsError::first("node", nodes, |n| n.is_valid())?;
        let azimuths = if axes.phi == 1 { 1 } else { AZIMUTHS };
        let omegas: Vec<[usize; 2]> = (heights.first..=heights.last).map(|bin| omegas(heights.bounds(bin))).collect();
        let mut cells = Vec::with_capacity(COSINES * azimuths * omegas.len());
        let cosine = |i: usize| i as f64 / COSINES as f64;
        // |y|/(|x| + |y|) of a horizontal direction is uniform in the bins.
        let azimuth = |i: usize| {
            let t = i as f64 / azimuths as f64;
            t.atan2(1.0 - t)
        };
        for z in 0..COSINES {
            let theta = nodes_between(cosine(z + 1).acos(), cosine(z).acos(), |x| axes.theta_place(x).index);
            for a in 0..azimuths {
                let phi = if axes.phi == 1 {
                    [0, 0]
                } else {
                    nodes_between(azimuth(a), azimuth(a + 1), |x| axes.phi_place(x).index)
                };
                for omega in &omegas {
                    let mut node = Node::default();
                    for t in theta[0]..=theta[1] {
                        for p in phi[0]..=phi[1] {
                            for o in omega[0]..=omega[1] {
                                node = node.or(nodes[axes.index(t, p, o)]);
                            }
                        }
                    }
                    cells.push(node.packed());
                }
            }
        }
        let finest = nodes.iter().map(|n| n.product).max().unwrap_or(0);
        Ok(Self { azimuths, heights, cells: cells.into(), finest })
    }

    /// What a shader takes: bins in azimuth, what heights are multiplied by, the bits of their first and last bin, and the cells.
    #[cfg(feature = "wgsl")]
    pub(crate) fn parts(&self) -> (usize, f32, [u32; 2], &[u32]) {
        (self.azimuths, self.heights.scale, [self.heights.first, self.heights.last], &self.cells)
    }

    /// The finest product rule.
    pub fn finest(&self) -> usize {
        usize::from(self.finest)
    }

    /// The index of the rule of a cap.
    pub fn of(&self, axis: Vec3, height: f32, wo: Vec3) -> u8 {
        let z = ((axis.z * COSINES as f32) as usize).min(COSINES - 1);
        let (x, y) = (axis.x.abs(), axis.y.abs());
        let a = ((y / (x + y).max(1e-30) * self.azimuths as f32) as usize).min(self.azimuths - 1);
        let Heights { scale, first, last } = self.heights;
        let h = (((height * scale).to_bits() >> SHIFT).clamp(first, last) - first) as usize;
        let bin = self.cells[(z * self.azimuths + a) * self.heights.count() + h];
        let distance2 = (wo - Vec3::new(-axis.x, -axis.y, axis.z)).length_squared() * CHORD_STEPS as f32;
        let rule = (bin & 15) as u8;
        match distance2 {
            d if d > (bin >> 18) as f32 => FAR,
            d if d > (bin >> 4 & CHORD_MASK) as f32 => rule.min(OUTER),
            _ => rule,
        }
    }

    /// [`Bins::of`] for a vector of caps.
    #[inline(always)]
    pub fn of_lanes<S: Simd>(&self, simd: S, [x, y, z, height]: [f32x16<S>; 4], wo: Vec3) -> u32x16<S> {
        let count = self.azimuths as f64;
        let cosine: u32x16<S> = (z * z.lit(COSINES as f64)).to_int();
        let Heights { scale, first, last } = self.heights;
        let bits: u32x16<S> = (height * z.lit(scale.into())).bitcast();
        let height = (bits >> SHIFT).max(first).min(last) - first;
        let mut row = cosine.min(COSINES as u32 - 1);
        if self.azimuths > 1 {
            let (ax, ay) = (Real::abs(x), Real::abs(y));
            let azimuth: u32x16<S> = (ay / Real::max(ax + ay, x.lit(1e-30)) * x.lit(count)).to_int();
            row = row * self.azimuths as u32 + azimuth.min(self.azimuths as u32 - 1);
        }
        let mut bins = (row * self.heights.count() as u32 + height).min(self.cells.len() as u32 - 1).to_array();
        // A plain loop of loads: the compiler keeps it branch-free.
        for bin in &mut bins {
            *bin = self.cells[*bin as usize];
        }
        let bins = u32x16::load_array(simd, bins);
        let distance2 = ((x + wo.x).sq() + (y + wo.y).sq() + (z - wo.z).sq()) * x.lit(CHORD_STEPS);
        let rule = bins & 15;
        let (outer, far): (f32x16<S>, f32x16<S>) = ((bins >> 4 & CHORD_MASK).to_float(), (bins >> 18).to_float());
        let rule = distance2.simd_gt(outer).select(rule.min(u32::from(OUTER)), rule);
        let far_away = u32x16::splat(simd, u32::from(FAR));
        distance2.simd_gt(far).select(far_away, rule)
    }
}

/// First and last node of the intervals that two coordinates, in ascending order, span.
fn nodes_between(low: f64, high: f64, interval: impl Fn(f64) -> usize) -> [usize; 2] {
    [interval(low), interval(high) + 1]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cap::Cap;
    use crate::real::LANES;
    use core::f64::consts::FRAC_PI_2;
    use fearless_simd::{Level, dispatch};

    /// A bin is never below the nodes around a cap, for an isotropic and an anisotropic grid.
    #[test]
    fn bins_cover_the_nodes_around() {
        for phi in [1, 5] {
            let axes = Axes { theta: 9, phi, omega: 11, sharpness: 60.0, stretch: 0.5 };
            let nodes: Vec<Node> = (0..axes.len())
                .map(|i| Node {
                    disc: [0, 1, 4, NONE][i * 7 % 4],
                    product: [7, 9, 14][i % 3],
                    outer: (i * 31 % 200) as u8,
                    far: (i * 57 % 256) as u8,
                })
                .collect();
            let bins = Bins::new(axes, &nodes).unwrap();
            for i in 0..2000 {
                let u = |k: f64| (f64::from(i) * k).fract();
                let cap = Cap::new(FRAC_PI_2 * u(0.618), TAU * u(0.414), TAU * u(0.733).powi(6).max(1e-12)).unwrap();
                let (t, p, o) = (
                    axes.theta_place(cap.theta()).index,
                    axes.phi_place(cap.axis().y.atan2(cap.axis().x)).index,
                    axes.omega_place(cap.solid_angle()).index,
                );
                let p_end = if phi == 1 { p } else { p + 1 };
                let at_least = [t, t + 1]
                    .into_iter()
                    .flat_map(|t| [p, p_end].into_iter().flat_map(move |p| [(t, p, o), (t, p, o + 1)]))
                    .fold(0, |a, (t, p, o)| a.max(nodes[axes.index(t, p, o)].rule()));
                // Seen from the mirror direction the rule within the lobe holds.
                let (axis, height) = (cap.axis().as_vec3(), cap.height() as f32);
                let wo = Vec3::new(-axis.x, -axis.y, axis.z);
                assert!(bins.of(axis, height, wo) >= at_least, "{cap:?}");
            }
        }
    }

    #[test]
    fn lanes_and_scalar_agree() {
        #[inline(always)]
        fn check<S: Simd>(simd: S, bins: &Bins) {
            for i in 0..2000 {
                let u = |k: f64| (f64::from(i) * k).fract();
                let cap = Cap::new(FRAC_PI_2 * u(0.618), TAU * u(0.414), TAU * u(0.733).powi(6).max(1e-12)).unwrap();
                let wo = crate::frame::spherical(1.5 * u(0.271), TAU * u(0.161)).as_vec3();
                let (axis, height) = (cap.axis().as_vec3(), cap.height() as f32);
                let lanes = [axis.x, axis.y, axis.z, height].map(|x| f32x16::splat(simd, x));
                let found = bins.of_lanes(simd, lanes, wo).to_array();
                assert_eq!(found, [u32::from(bins.of(axis, height, wo)); LANES], "{cap:?}");
            }
        }
        let axes = Axes { theta: 5, phi: 3, omega: 7, sharpness: 20.0, stretch: 1.0 };
        let nodes: Vec<Node> = (0..axes.len())
            .map(|i| Node { disc: [0, 3, 6, NONE][i % 4], product: [7, 10][i % 2], outer: 40, far: 120 })
            .collect();
        let bins = Bins::new(axes, &nodes).unwrap();
        dispatch!(Level::new(), simd => check(simd, &bins));
    }

    #[test]
    fn wrong_nodes_are_refused() {
        let axes = Axes { theta: 2, phi: 1, omega: 2, sharpness: 1.0, stretch: 1.0 };
        let node = |disc, product| Node { disc, product, outer: 0, far: 0 };
        let accepted = |node, count| Bins::new(axes, &vec![node; count]).is_ok();
        assert!(accepted(node(3, 7), 4) && accepted(node(NONE, 14), 4));
        assert!(!accepted(node(3, 7), 3));
        for (disc, product) in [(7, 7), (3, 3), (3, NONE), (NONE + 1, 7), (255, 255)] {
            assert!(!accepted(node(disc, product), 4), "{disc} {product}");
        }
    }
}
