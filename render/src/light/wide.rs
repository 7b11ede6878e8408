//! Chooses one of the lights with a place, with a probability that follows distance, orientation and power, in logarithmic time:
//! a hierarchy of eight children a node, whose importances are computed at once.

use super::LightSampleContext;
use super::tree::{LightBounds, Link, Pair, cost, grow};
use fearless_simd::prelude::*;
use fearless_simd::{Level, dispatch, f32x8};
use glam::Vec3A;

/// Children of a node.
const WIDTH: usize = 8;

/// Marks a link to a light; the other bits are its number.
const LIGHT: u32 = 1 << 31;

/// Bounds of the children, lane by lane. A lane without child has no power.
#[repr(C, align(64))]
#[derive(Clone, Debug)]
struct Node {
    center: [[f32; WIDTH]; 3],
    half: [[f32; WIDTH]; 3],
    axis: [[f32; WIDTH]; 3],
    /// Squared radius of the sphere about the box.
    radius2: [f32; WIDTH],
    power: [f32; WIDTH],
    cos_o: [f32; WIDTH],
    sin_o: [f32; WIDTH],
    cos_e: [f32; WIDTH],
    links: [u32; WIDTH],
    /// Where this node hangs: node and lane.
    parent: (u32, u32),
}

impl Node {
    const EMPTY: Self = Self {
        center: [[0.0; WIDTH]; 3],
        half: [[0.0; WIDTH]; 3],
        axis: [[0.0; WIDTH]; 3],
        radius2: [0.0; WIDTH],
        power: [0.0; WIDTH],
        cos_o: [1.0; WIDTH],
        sin_o: [0.0; WIDTH],
        cos_e: [0.0; WIDTH],
        links: [0; WIDTH],
        parent: (0, 0),
    };

    fn set(&mut self, lane: usize, bounds: &LightBounds, link: u32) {
        let half = 0.5 * (bounds.max - bounds.min);
        for axis in 0..3 {
            self.center[axis][lane] = bounds.center()[axis];
            self.half[axis][lane] = half[axis];
            self.axis[axis][lane] = bounds.axis[axis];
        }
        self.radius2[lane] = half.length_squared();
        self.power[lane] = bounds.power;
        self.cos_o[lane] = bounds.cos_o;
        self.sin_o[lane] = (1.0 - bounds.cos_o * bounds.cos_o).max(0.0).sqrt();
        self.cos_e[lane] = bounds.cos_e;
        self.links[lane] = link;
    }
}

/// The hierarchy.
#[derive(Clone, Debug)]
pub(super) struct LightTree {
    nodes: Vec<Node>,
    /// Node and lane of every light; `u32::MAX` for one without power.
    places: Vec<(u32, u32)>,
    /// The only light: there is nothing to choose.
    lone: Option<u32>,
    level: Level,
}

impl LightTree {
    /// Builds the tree over lights numbered as in `lights`; those without power are left out.
    pub fn new(lights: &[LightBounds]) -> Self {
        let places = vec![(u32::MAX, 0); lights.len()];
        let mut this = Self { nodes: Vec::new(), places, lone: None, level: Level::new() };
        let pairs = grow(lights);
        match pairs.first() {
            None => return this,
            Some(Pair { link: Link::Light(light), .. }) => {
                this.lone = Some(*light);
                return this;
            }
            Some(_) => this.nodes.push(Node::EMPTY),
        }
        let mut open = vec![(0usize, 0usize)];
        while let Some((node, pair)) = open.pop() {
            for (lane, child) in children(&pairs, pair).into_iter().enumerate() {
                let link = match pairs[child].link {
                    Link::Light(light) => {
                        this.places[light as usize] = (node as u32, lane as u32);
                        LIGHT | light
                    }
                    Link::Children(_) => {
                        let index = this.nodes.len();
                        this.nodes.push(Node { parent: (node as u32, lane as u32), ..Node::EMPTY });
                        open.push((index, child));
                        index as u32
                    }
                };
                this.nodes[node].set(lane, &pairs[child].bounds, link);
            }
        }
        this
    }

    /// Chooses a light; `None` where none can reach the receiver.
    #[inline]
    pub fn sample(&self, receiver: &LightSampleContext, u: f32) -> Option<(u32, f32)> {
        match self.lone {
            Some(light) => Some((light, 1.0)),
            None => dispatch!(self.level, simd => self.descend(simd, receiver, u)),
        }
    }

    #[inline(always)]
    fn descend<S: Simd>(&self, simd: S, receiver: &LightSampleContext, u: f32) -> Option<(u32, f32)> {
        let mut node = self.nodes.first()?;
        let (mut u, mut probability) = (u, 1.0);
        loop {
            let weights = importances(simd, node, receiver);
            let total: f32 = weights.iter().sum();
            let target = u * total;
            // The last child that begins at or before the target; the first of any weight at least.
            let (mut sum, mut begin, mut chosen) = (0.0, 0.0, None);
            for (lane, &weight) in weights.iter().enumerate() {
                if weight > 0.0 && (chosen.is_none() || sum <= target) {
                    (begin, chosen) = (sum, Some(lane));
                }
                sum += weight;
            }
            let lane = chosen?;
            u = ((target - begin) / weights[lane]).clamp(0.0, 1.0 - f32::EPSILON);
            probability *= weights[lane] / total;
            let link = node.links[lane];
            if link & LIGHT != 0 {
                return Some((link & !LIGHT, probability));
            }
            node = &self.nodes[link as usize];
        }
    }

    /// Probability with which [`LightTree::sample`] chooses `light`.
    #[inline]
    pub fn probability(&self, receiver: &LightSampleContext, light: u32) -> f32 {
        match self.lone {
            Some(lone) => f32::from(u8::from(lone == light)),
            None => dispatch!(self.level, simd => self.ascend(simd, receiver, light)),
        }
    }

    #[inline(always)]
    fn ascend<S: Simd>(&self, simd: S, receiver: &LightSampleContext, light: u32) -> f32 {
        let (mut node, mut lane) = self.places[light as usize];
        if node == u32::MAX {
            return 0.0;
        }
        let mut probability = 1.0;
        loop {
            let weights = importances(simd, &self.nodes[node as usize], receiver);
            let weight = weights[lane as usize];
            if weight == 0.0 {
                return 0.0;
            }
            probability *= weight / weights.iter().sum::<f32>();
            if node == 0 {
                return probability;
            }
            (node, lane) = self.nodes[node as usize].parent;
        }
    }
}

/// Up to eight nodes of the binary tree that together hold what one holds: those in which there is most to tell apart are opened.
fn children(pairs: &[Pair], of: usize) -> Vec<usize> {
    let mut children = vec![of];
    while children.len() < WIDTH {
        let inner = |&&child: &&usize| matches!(pairs[child].link, Link::Children(_));
        let by_cost = |&&a: &&usize, &&b: &&usize| cost(&pairs[a].bounds).total_cmp(&cost(&pairs[b].bounds));
        let Some(&most) = children.iter().filter(inner).max_by(by_cost) else { break };
        let Link::Children(first) = pairs[most].link else { break };
        children.retain(|&child| child != most);
        children.extend([first, first + 1]);
    }
    children
}

/// Upper estimates, up to a factor, of the light that reaches `receiver` from each child; 0 only where none does.
#[inline(always)]
fn importances<S: Simd>(simd: S, node: &Node, receiver: &LightSampleContext) -> [f32; WIDTH] {
    let lit = |x: f32| f32x8::splat(simd, x);
    let load = |column: &[f32; WIDTH]| f32x8::load_array_ref(simd, column);
    let dot = |v: Vec3A, column: &[[f32; WIDTH]; 3]| {
        lit(v.x) * load(&column[0]) + lit(v.y) * load(&column[1]) + lit(v.z) * load(&column[2])
    };
    let (zero, one) = (lit(0.0), lit(1.0));
    let sin = |cos: f32x8<S>| (one - cos * cos).max(zero).sqrt();
    let (p, n) = (receiver.p, receiver.normal);
    let from = [lit(p.x) - load(&node.center[0]), lit(p.y) - load(&node.center[1]), lit(p.z) - load(&node.center[2])];
    let along = lit(n.x) * from[0] + lit(n.y) * from[1] + lit(n.z) * from[2];
    let distance2 = from[0] * from[0] + from[1] * from[1] + from[2] * from[2];
    let radius2 = load(&node.radius2);
    let inverse = one / distance2.sqrt().max(lit(f32::MIN_POSITIVE));
    // Half angle of the bounding sphere as the receiver sees it.
    let inside = distance2.simd_le(radius2);
    let sin2 = inside.select(zero, radius2 / distance2);
    let (sin_b, cos_b) = (sin2.sqrt(), inside.select(-one, (one - sin2).sqrt()));
    // Smallest angle between a normal and the direction to the receiver.
    let axis = [load(&node.axis[0]), load(&node.axis[1]), load(&node.axis[2])];
    let cos_w = (axis[0] * from[0] + axis[1] * from[1] + axis[2] * from[2]) * inverse;
    let cos_w = cos_w.max(-one).min(one);
    let (cos_o, sin_o, sin_w) = (load(&node.cos_o), load(&node.sin_o), sin(cos_w));
    let within = cos_w.simd_gt(cos_o);
    let cos_x = within.select(one, cos_w * cos_o + sin_w * sin_o);
    let sin_x = within.select(zero, sin_w * cos_o - cos_w * sin_o);
    let cos_leave = cos_x.simd_gt(cos_b).select(one, cos_x * cos_b + sin_x * sin_b);
    // Largest cosine at the receiver.
    let cos_i = -along * inverse;
    let cos_i = if receiver.one_sided { cos_i.max(-one).min(one) } else { cos_i.abs().min(one) };
    let cos_arrive = cos_i.simd_gt(cos_b).select(one, cos_i * cos_b + sin(cos_i) * sin_b);
    // At a light without extent this has no bound; a sixteenth of the largest number leaves room for the sum of eight.
    let area = distance2.max(radius2).max(lit(f32::MIN_POSITIVE));
    let importance = (load(&node.power) * cos_leave * cos_arrive / area).max(zero).min(lit(f32::MAX / 16.0));
    let mut dark = cos_leave.simd_le(load(&node.cos_e));
    if receiver.one_sided {
        // The sphere reaches over the horizon of a wall that a window is a part of; the box does not.
        dark |= dot(n.abs(), &node.half).simd_le(along);
    }
    dark.select(zero, importance).to_array()
}

#[cfg(test)]
mod tests {
    use super::*;
    use fearless_simd::dispatch;
    use rand::{RngExt, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    #[test]
    fn choice_has_the_probability_it_states() {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(3);
        let mut v = |s: f32| Vec3A::from_array(core::array::from_fn(|_| rng.random_range(-s..s)));
        let lights: Vec<_> = (0..50)
            .map(|i| {
                let p = v(5.0);
                let power = [0.0, 1.0, 10.0][i % 3];
                LightBounds::new(p, p + v(0.2).abs(), power, v(1.0).normalize(), 1.0, 0.0)
            })
            .collect();
        let tree = LightTree::new(&lights);
        for one_sided in [true, false] {
            let receiver = LightSampleContext { p: v(3.0), normal: v(1.0).normalize(), one_sided };
            let sum: f32 = (0..50).map(|i| tree.probability(&receiver, i)).sum();
            assert!(sum > 0.3 && sum < 1.0 + 1e-5, "{sum}"); // the rest: branches whose lights all face away
            let n = 20_000;
            let mut counts = [0; 50];
            for i in 0..n {
                let Some((light, p)) = tree.sample(&receiver, (i as f32 + 0.5) / n as f32) else { continue };
                assert!((p - tree.probability(&receiver, light)).abs() < 1e-5);
                counts[light as usize] += 1;
            }
            for (i, &count) in counts.iter().enumerate() {
                let expected = tree.probability(&receiver, i as u32) * n as f32;
                assert!((count as f32 - expected).abs() <= 2.0 + 1e-3 * expected, "{i}: {count} {expected}");
            }
        }
    }

    /// A window in the wall that is lit, beside a lamp in front of it: what lies in the plane of a surface is never chosen.
    #[test]
    fn lights_below_the_horizon_are_not_chosen() {
        let window = LightBounds::new(Vec3A::new(-1.0, -1.0, 0.0), Vec3A::new(1.0, 1.0, 0.0), 1e3, Vec3A::Z, 1.0, 0.0);
        let lamp = LightBounds::at_point(Vec3A::new(0.0, 0.0, 3.0), 1.0, Vec3A::Z, -1.0, 0.0);
        let tree = LightTree::new(&[window, lamp]);
        let at = |one_sided| LightSampleContext { p: Vec3A::new(1.5, 0.0, 0.0), normal: Vec3A::Z, one_sided };
        assert_eq!(tree.probability(&at(true), 1), 1.0);
        assert!(tree.probability(&at(false), 1) < 0.1);
    }

    #[test]
    fn many_coincident_lights_do_not_recurse_forever() {
        let light = LightBounds::at_point(Vec3A::ONE, 1.0, Vec3A::Z, -1.0, 0.0);
        let tree = LightTree::new(&vec![light; 10_000]);
        let receiver = LightSampleContext { p: Vec3A::ZERO, normal: Vec3A::Z, one_sided: true };
        assert!((tree.probability(&receiver, 77) - 1e-4).abs() < 1e-6);
    }

    /// The readable twin of [`importances`].
    fn importance(light: &LightBounds, receiver: &LightSampleContext) -> f32 {
        let from_light = receiver.p - light.center();
        // The sphere below reaches over the horizon of a wall that a window is a part of; the box does not.
        let half = 0.5 * (light.max - light.min);
        if receiver.one_sided && receiver.normal.abs().dot(half) <= receiver.normal.dot(from_light) {
            return 0.0;
        }
        let distance2 = from_light.length_squared();
        let radius2 = half.length_squared();
        let direction = from_light / distance2.sqrt().max(f32::MIN_POSITIVE);
        // Half angle of the bounding sphere as the receiver sees it.
        let (sin_b, cos_b) = if distance2 <= radius2 {
            (0.0, -1.0)
        } else {
            let sin2 = radius2 / distance2;
            (sin2.sqrt(), (1.0 - sin2).sqrt())
        };
        // Smallest angle between a normal and the direction to the receiver.
        let cos_w = light.axis.dot(direction).clamp(-1.0, 1.0);
        let (sin_w, sin_o) = (sin(cos_w), sin(light.cos_o));
        let (cos_x, sin_x) = subtract(sin_w, cos_w, sin_o, light.cos_o);
        let cos_leave = subtract(sin_x, cos_x, sin_b, cos_b).0;
        if cos_leave <= light.cos_e {
            return 0.0;
        }
        // Largest cosine at the receiver.
        let cos_i = -receiver.normal.dot(direction);
        let cos_i = if receiver.one_sided { cos_i.clamp(-1.0, 1.0) } else { cos_i.abs().min(1.0) };
        let cos_arrive = subtract(sin(cos_i), cos_i, sin_b, cos_b).0;
        // At a light without extent this has no bound; a quarter of the largest number leaves room for the sum of two.
        let importance = light.power * cos_leave * cos_arrive / distance2.max(radius2).max(f32::MIN_POSITIVE);
        importance.clamp(0.0, 0.25 * f32::MAX)
    }

    fn sin(cos: f32) -> f32 {
        (1.0 - cos * cos).max(0.0).sqrt()
    }

    /// (cos, sin) of max(0, a − b).
    fn subtract(sin_a: f32, cos_a: f32, sin_b: f32, cos_b: f32) -> (f32, f32) {
        if cos_a > cos_b { (1.0, 0.0) } else { (cos_a * cos_b + sin_a * sin_b, sin_a * cos_b - cos_a * sin_b) }
    }

    #[test]
    fn eight_lights_at_once_have_the_importance_of_each() {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(4);
        let mut v = |s: f32| Vec3A::from_array(core::array::from_fn(|_| rng.random_range(-s..s)));
        for i in 0..200 {
            let lights: [LightBounds; WIDTH] = core::array::from_fn(|k| {
                let (p, axis) = (v(3.0), v(1.0).normalize());
                LightBounds::new(p, p + v(1.0).abs(), 1.0 + k as f32, axis, v(1.0).x, [-1.0, 0.0][k % 2])
            });
            let mut node = Node::EMPTY;
            lights.iter().enumerate().for_each(|(lane, light)| node.set(lane, light, 0));
            let receiver = LightSampleContext { p: v(3.0), normal: v(1.0).normalize(), one_sided: i % 2 == 0 };
            let found = dispatch!(Level::new(), simd => importances(simd, &node, &receiver));
            for (light, found) in lights.iter().zip(found) {
                let expected = importance(light, &receiver);
                assert!((found - expected).abs() <= 1e-3 * (1.0 + expected), "{found} {expected}");
            }
        }
    }
}
