//! A hierarchy over the lights with a place: chooses one with a probability that follows distance, orientation and
//! power, in logarithmic time (Conty Estevez and Kulla 2018, "Importance sampling of many lights with adaptive tree
//! splitting").

use super::LightSampleContext;
use glam::Vec3A;

/// Where lights are, where they send light, how much.
#[derive(Clone, Copy, Debug)]
pub(super) struct LightBounds {
    min: Vec3A,
    max: Vec3A,
    power: f32,
    /// Axis of the cone that holds the normals.
    axis: Vec3A,
    /// Cosine of the cone's half angle.
    cos_o: f32,
    /// Cosine of the largest angle from a normal at which light leaves.
    cos_e: f32,
}

impl LightBounds {
    /// Bounds from all parts.
    pub fn new(min: Vec3A, max: Vec3A, power: f32, axis: Vec3A, cos_o: f32, cos_e: f32) -> Self {
        Self { min, max, power, axis, cos_o, cos_e }
    }

    /// Bounds of a light without extent.
    pub fn at_point(p: Vec3A, power: f32, axis: Vec3A, cos_o: f32, cos_e: f32) -> Self {
        Self::new(p, p, power, axis, cos_o, cos_e)
    }

    fn union(&self, other: &Self) -> Self {
        if self.power == 0.0 {
            return *other;
        }
        if other.power == 0.0 {
            return *self;
        }
        let (axis, cos_o) = union_cone((self.axis, self.cos_o), (other.axis, other.cos_o));
        Self {
            min: self.min.min(other.min),
            max: self.max.max(other.max),
            power: self.power + other.power,
            axis,
            cos_o,
            cos_e: self.cos_e.min(other.cos_e),
        }
    }

    fn center(&self) -> Vec3A {
        0.5 * (self.min + self.max)
    }

    /// Upper estimate, up to a factor, of the light that reaches `receiver`; 0 only where none does.
    #[inline]
    fn importance(&self, receiver: &LightSampleContext) -> f32 {
        let from_light = receiver.p - self.center();
        // The sphere below reaches over the horizon of a wall that a window is a part of; the box does not.
        let half = 0.5 * (self.max - self.min);
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
        let cos_w = self.axis.dot(direction).clamp(-1.0, 1.0);
        let (sin_w, sin_o) = (sin(cos_w), sin(self.cos_o));
        let (cos_x, sin_x) = subtract(sin_w, cos_w, sin_o, self.cos_o);
        let cos_leave = subtract(sin_x, cos_x, sin_b, cos_b).0;
        if cos_leave <= self.cos_e {
            return 0.0;
        }
        // Largest cosine at the receiver.
        let cos_i = -receiver.normal.dot(direction);
        let cos_i = if receiver.one_sided { cos_i.clamp(-1.0, 1.0) } else { cos_i.abs().min(1.0) };
        let cos_arrive = subtract(sin(cos_i), cos_i, sin_b, cos_b).0;
        // At a light without extent this has no bound; a quarter of the largest number leaves room for the sum of two.
        let importance = self.power * cos_leave * cos_arrive / distance2.max(radius2).max(f32::MIN_POSITIVE);
        importance.clamp(0.0, 0.25 * f32::MAX)
    }
}

fn sin(cos: f32) -> f32 {
    (1.0 - cos * cos).max(0.0).sqrt()
}

/// (cos, sin) of max(0, a − b).
#[inline]
fn subtract(sin_a: f32, cos_a: f32, sin_b: f32, cos_b: f32) -> (f32, f32) {
    if cos_a > cos_b { (1.0, 0.0) } else { (cos_a * cos_b + sin_a * sin_b, sin_a * cos_b - cos_a * sin_b) }
}

/// Smallest cone around two cones (axis, cosine of the half angle).
fn union_cone(a: (Vec3A, f32), b: (Vec3A, f32)) -> (Vec3A, f32) {
    let (theta_a, theta_b) = (a.1.acos(), b.1.acos());
    let between = a.0.angle_between(b.0);
    let pi = core::f32::consts::PI;
    if (between + theta_b).min(pi) <= theta_a {
        return a;
    }
    if (between + theta_a).min(pi) <= theta_b {
        return b;
    }
    let theta = 0.5 * (theta_a + between + theta_b);
    let normal = a.0.cross(b.0);
    if theta >= pi || normal.length_squared() == 0.0 {
        return (Vec3A::Z, -1.0);
    }
    let turn = glam::Quat::from_axis_angle(normal.normalize().into(), theta - theta_a);
    (turn * a.0, theta.cos())
}

#[derive(Clone, Copy, Debug)]
enum Link {
    /// Index of the first child; the second follows.
    Children(u32),
    Light(u32),
}

#[derive(Clone, Copy, Debug)]
struct Node {
    bounds: LightBounds,
    link: Link,
    parent: u32,
}

/// The hierarchy.
#[derive(Clone, Debug, Default)]
pub(super) struct LightTree {
    nodes: Vec<Node>,
    /// Node of every light; `u32::MAX` for one without power.
    leaf: Vec<u32>,
}

/// Buckets along an axis in the search for the best split.
const BUCKETS: usize = 12;

impl LightTree {
    /// Builds the tree over lights numbered as in `lights`; those without power are left out.
    pub fn new(lights: &[LightBounds]) -> Self {
        let mut this = Self { nodes: Vec::new(), leaf: vec![u32::MAX; lights.len()] };
        let mut items: Vec<u32> = (0..lights.len() as u32).filter(|&i| lights[i as usize].power > 0.0).collect();
        if items.is_empty() {
            return this;
        }
        let placeholder = Node { bounds: lights[items[0] as usize], link: Link::Light(0), parent: u32::MAX };
        this.nodes.push(placeholder);
        let mut open = vec![(0usize, &mut items[..])];
        while let Some((node, items)) = open.pop() {
            let bounds = |items: &[u32]| items.iter().map(|&i| lights[i as usize]).reduce(|a, b| a.union(&b));
            this.nodes[node].bounds = bounds(items).unwrap_or(placeholder.bounds);
            if let [light] = *items {
                this.nodes[node].link = Link::Light(light);
                this.leaf[light as usize] = node as u32;
                continue;
            }
            let (left, right) = split(lights, &this.nodes[node].bounds, items);
            let first = this.nodes.len();
            this.nodes[node].link = Link::Children(first as u32);
            this.nodes.extend([Node { parent: node as u32, ..placeholder }; 2]);
            open.push((first, left));
            open.push((first + 1, right));
        }
        this
    }

    /// Chooses a light; `None` where none can reach the receiver.
    #[inline]
    pub fn sample(&self, receiver: &LightSampleContext, u: f32) -> Option<(u32, f32)> {
        let mut node = self.nodes.first()?;
        let (mut u, mut probability) = (u, 1.0);
        loop {
            match node.link {
                Link::Light(light) => return Some((light, probability)),
                Link::Children(first) => {
                    let left = self.left_probability(first, receiver)?;
                    let second = u >= left;
                    let p = if second { 1.0 - left } else { left };
                    u = if second { (u - left) / p } else { u / p }.min(1.0 - f32::EPSILON);
                    probability *= p;
                    node = &self.nodes[first as usize + usize::from(second)];
                }
            }
        }
    }

    /// Probability of the first of two siblings; `None` where neither can reach the receiver.
    #[inline]
    fn left_probability(&self, first: u32, receiver: &LightSampleContext) -> Option<f32> {
        let [a, b] = [0, 1].map(|k| self.nodes[first as usize + k].bounds.importance(receiver));
        (a + b > 0.0).then(|| a / (a + b))
    }

    /// Probability with which [`LightTree::sample`] chooses `light`.
    #[inline]
    pub fn probability(&self, receiver: &LightSampleContext, light: u32) -> f32 {
        let mut node = self.leaf[light as usize];
        if node == u32::MAX {
            return 0.0;
        }
        let mut probability = 1.0;
        while node != 0 {
            let Link::Children(first) = self.nodes[self.nodes[node as usize].parent as usize].link else { return 0.0 };
            let Some(left) = self.left_probability(first, receiver) else { return 0.0 };
            probability *= if node == first { left } else { 1.0 - left };
            node = self.nodes[node as usize].parent;
        }
        probability
    }
}

/// Divides lights where the sum of power × solid angle of the cone × surface of the box is least.
fn split<'a>(lights: &[LightBounds], whole: &LightBounds, items: &'a mut [u32]) -> (&'a mut [u32], &'a mut [u32]) {
    let centers = |i: &u32| lights[*i as usize].center();
    let low = items.iter().map(centers).fold(Vec3A::INFINITY, Vec3A::min);
    let extent = items.iter().map(centers).fold(Vec3A::NEG_INFINITY, Vec3A::max) - low;
    let bucket = |i: u32, axis: usize| {
        let x = (lights[i as usize].center()[axis] - low[axis]) / extent[axis];
        ((x * BUCKETS as f32) as usize).min(BUCKETS - 1)
    };
    let size = whole.max - whole.min;
    let mut best: Option<(f32, usize, usize)> = None;
    for axis in (0..3).filter(|&a| extent[a] > 0.0) {
        let mut buckets: [Option<LightBounds>; BUCKETS] = [None; BUCKETS];
        for &i in items.iter() {
            let slot = &mut buckets[bucket(i, axis)];
            *slot = Some(slot.map_or(lights[i as usize], |b| b.union(&lights[i as usize])));
        }
        for cut in 1..BUCKETS {
            let side = |range: &[Option<LightBounds>]| range.iter().flatten().copied().reduce(|a, b| a.union(&b));
            if let (Some(a), Some(b)) = (side(&buckets[..cut]), side(&buckets[cut..])) {
                // Long thin boxes are cut across (the regularisation of the paper).
                let cost = (cost(&a) + cost(&b)) * size.max_element() / size[axis].max(f32::MIN_POSITIVE);
                if best.is_none_or(|(least, ..)| cost < least) {
                    best = Some((cost, axis, cut));
                }
            }
        }
    }
    let middle = match best {
        Some((_, axis, cut)) => {
            items.sort_unstable_by_key(|&i| (bucket(i, axis) >= cut, i));
            items.partition_point(|&i| bucket(i, axis) < cut)
        }
        None => items.len() / 2,
    };
    items.split_at_mut(middle)
}

fn cost(b: &LightBounds) -> f32 {
    let (theta_o, theta_e) = (b.cos_o.acos(), b.cos_e.acos());
    let theta_w = (theta_o + theta_e).min(core::f32::consts::PI);
    let sin_o = theta_o.sin();
    let cone = core::f32::consts::TAU * (1.0 - b.cos_o)
        + core::f32::consts::FRAC_PI_2
            * (2.0 * theta_w * sin_o - (theta_o - 2.0 * theta_w).cos() - 2.0 * theta_o * sin_o + b.cos_o);
    let d = b.max - b.min;
    b.power * cone * (d.x * d.y + d.y * d.z + d.z * d.x)
}

#[cfg(test)]
mod tests {
    use super::*;
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
}
