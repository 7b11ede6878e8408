//! Bounds of lights, and the binary hierarchy over them that [`super::wide`] is made of (Conty Estevez and Kulla 2018, "Importance
//! sampling of many lights with adaptive tree splitting").

use glam::Vec3A;

/// Where lights are, where they send light, how much.
#[derive(Clone, Copy, Debug)]
pub(super) struct LightBounds {
    pub min: Vec3A,
    pub max: Vec3A,
    pub power: f32,
    /// Axis of the cone that holds the normals.
    pub axis: Vec3A,
    /// Cosine of the cone's half angle.
    pub cos_o: f32,
    /// Cosine of the largest angle from a normal at which light leaves.
    pub cos_e: f32,
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

    pub fn center(&self) -> Vec3A {
        0.5 * (self.min + self.max)
    }
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

/// Where a node leads.
#[derive(Clone, Copy, Debug)]
pub(super) enum Link {
    /// Index of the first child; the second follows.
    Children(usize),
    Light(u32),
}

/// A light, or two sets of them.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pair {
    pub bounds: LightBounds,
    pub link: Link,
}

/// Buckets along an axis in the search for the best split.
const BUCKETS: usize = 12;

/// The binary hierarchy over lights numbered as in `lights`, the root first; those without power are left out.
pub(super) fn grow(lights: &[LightBounds]) -> Vec<Pair> {
    let mut items: Vec<u32> = (0..lights.len() as u32).filter(|&i| lights[i as usize].power > 0.0).collect();
    let Some(&first) = items.first() else { return Vec::new() };
    let placeholder = Pair { bounds: lights[first as usize], link: Link::Light(first) };
    let mut nodes = vec![placeholder];
    let mut open = vec![(0usize, &mut items[..])];
    while let Some((node, items)) = open.pop() {
        let bounds = |items: &[u32]| items.iter().map(|&i| lights[i as usize]).reduce(|a, b| a.union(&b));
        nodes[node].bounds = bounds(items).unwrap_or(placeholder.bounds);
        if let [light] = *items {
            nodes[node].link = Link::Light(light);
            continue;
        }
        let (left, right) = split(lights, &nodes[node].bounds, items);
        let first = nodes.len();
        nodes[node].link = Link::Children(first);
        nodes.extend([placeholder; 2]);
        open.push((first, left));
        open.push((first + 1, right));
    }
    nodes
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

/// Power × solid angle of the cone × surface of the box: how much there is to tell apart inside.
pub(super) fn cost(b: &LightBounds) -> f32 {
    let (theta_o, theta_e) = (b.cos_o.acos(), b.cos_e.acos());
    let theta_w = (theta_o + theta_e).min(core::f32::consts::PI);
    let sin_o = theta_o.sin();
    let cone = core::f32::consts::TAU * (1.0 - b.cos_o)
        + core::f32::consts::FRAC_PI_2
            * (2.0 * theta_w * sin_o - (theta_o - 2.0 * theta_w).cos() - 2.0 * theta_o * sin_o + b.cos_o);
    let d = b.max - b.min;
    b.power * cone * (d.x * d.y + d.y * d.z + d.z * d.x)
}
