//! An octree over balls: which of them hold a point. It knows no light.

use glam::Vec3A;

/// Items are numbered by the caller.
#[derive(Clone, Debug)]
pub struct Octree {
    center: Vec3A,
    half: f32,
    nodes: Vec<Node>,
}

#[derive(Clone, Debug, Default)]
struct Node {
    /// Index of each octant, 0 for none (the root is nobody's child).
    children: [u32; 8],
    items: Vec<u32>,
}

/// Levels below the root: balls of 2⁻²⁰ of the scene need no finer ones.
const MAX_LEVEL: u32 = 20;

impl Octree {
    /// An empty tree over the box with these corners; points outside belong to the octants at its border.
    pub fn new(min: Vec3A, max: Vec3A) -> Self {
        let valid = min.cmple(max).all() && (max - min).is_finite();
        let (center, size) = if valid { (0.5 * (min + max), (max - min).max_element()) } else { (Vec3A::ZERO, 1.0) };
        Self { center, half: (0.5 * size).max(f32::MIN_POSITIVE), nodes: vec![Node::default()] }
    }

    /// Forgets all balls.
    pub fn clear(&mut self) {
        self.nodes.clear();
        self.nodes.push(Node::default());
    }

    /// Files ball `item` in the nodes about half as large as the ball that it overlaps.
    pub fn insert(&mut self, item: u32, center: Vec3A, radius: f32) {
        self.insert_below(0, self.center, self.half, 0, (item, center, radius));
    }

    /// Level of the nodes in which balls of this radius are filed, 0 for the root: [`Octree::visit`] meets those of lower levels
    /// first.
    pub fn level(&self, radius: f32) -> u32 {
        let mut half = self.half;
        (0..MAX_LEVEL)
            .take_while(|_| {
                let larger = half > 0.5 * radius;
                half *= 0.5;
                larger
            })
            .count() as u32
    }

    fn insert_below(&mut self, node: usize, middle: Vec3A, half: f32, level: u32, ball: (u32, Vec3A, f32)) {
        let (item, center, radius) = ball;
        if half <= 0.5 * radius || level == MAX_LEVEL {
            self.nodes[node].items.push(item);
            return;
        }
        for octant in 0..8 {
            let sign = sign_of(octant);
            // The ball reaches the octant if it passes the middle plane of every axis, towards it.
            let reach = (center - middle) * sign + radius;
            if reach.cmpge(Vec3A::ZERO).all() {
                let child = match self.nodes[node].children[octant] {
                    0 => {
                        self.nodes.push(Node::default());
                        let child = self.nodes.len() as u32 - 1;
                        self.nodes[node].children[octant] = child;
                        child
                    }
                    child => child,
                };
                self.insert_below(child as usize, middle + sign * (0.5 * half), 0.5 * half, level + 1, ball);
            }
        }
    }

    /// Calls `found` with every ball that may hold `p`, in an order that depends on the insertions only.
    #[inline]
    pub fn visit(&self, p: Vec3A, mut found: impl FnMut(u32)) {
        let (mut node, mut middle, mut half) = (0, self.center, self.half);
        loop {
            let Node { children, items } = &self.nodes[node];
            items.iter().for_each(|&i| found(i));
            let octant = p.cmpge(middle).bitmask() as usize;
            match children[octant] {
                0 => return,
                child => node = child as usize,
            }
            half *= 0.5;
            middle += sign_of(octant) * half;
        }
    }
}

#[inline]
fn sign_of(octant: usize) -> Vec3A {
    let sign = |bit: usize| if octant >> bit & 1 == 1 { 1.0 } else { -1.0 };
    Vec3A::new(sign(0), sign(1), sign(2))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_every_ball_that_holds_the_point() {
        let point = |i: u32| {
            let x =
                |k: u32| (i.wrapping_mul(2_654_435_761).wrapping_add(k * 0x9e37_79b9) >> 8) as f32 / (1 << 24) as f32;
            Vec3A::new(x(0), x(1) * 2.0, x(2) * 0.1)
        };
        let mut tree = Octree::new(Vec3A::ZERO, Vec3A::new(1.0, 2.0, 0.1));
        let radius = |i: u32| 0.002 * (1 + i % 50) as f32;
        (0..500).for_each(|i| tree.insert(i, point(i), radius(i)));
        for k in 0..500 {
            let p = point(k * 7 + 3);
            let mut found = Vec::new();
            tree.visit(p, |i| found.push(i));
            for i in 0..500 {
                let inside = p.distance(point(i)) <= radius(i);
                assert!(!inside || found.contains(&i), "{k} {i}");
            }
            assert!(found.len() < 200, "{}", found.len());
        }
    }

    /// No bounds, no size, points outside: nothing is lost, nothing hangs.
    #[test]
    fn degenerate_trees_work() {
        for (min, max) in [(Vec3A::MAX, Vec3A::MIN), (Vec3A::ONE, Vec3A::ONE), (Vec3A::ZERO, Vec3A::splat(f32::MAX))] {
            let mut tree = Octree::new(min, max);
            let far = Vec3A::new(50.0, -3.0, 1e6);
            tree.insert(7, far, 0.0);
            let mut found = Vec::new();
            tree.visit(far, |i| found.push(i));
            assert_eq!(found, [7]);
        }
    }
}
