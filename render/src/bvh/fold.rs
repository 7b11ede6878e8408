//! Which nodes of a binary tree become children of a wide one: those of the least expected number of steps, by dynamic programming
//! (Ylitie, Karras and Laine 2017, "Efficient incoherent ray traversal on GPUs through compressed wide BVHs", section 3.1). A node
//! and a leaf are one step each, whatever they hold, and are met in proportion to their surface.

use super::WIDTH;
use obvhs::bvh2::node::Bvh2Node;

/// What becomes of the nodes of a binary tree.
pub(super) struct Fold<'a> {
    nodes: &'a [Bvh2Node],
    /// Triangles of each.
    counts: Vec<u32>,
    /// For every number of lanes from 1 on, how many of them the first child gets, or 0 where one lane less serves as well.
    /// With one lane a node becomes a wide one, whose lanes its children share.
    shares: Vec<[u8; WIDTH]>,
}

impl<'a> Fold<'a> {
    pub fn new(nodes: &'a [Bvh2Node]) -> Self {
        let mut order = vec![0];
        let mut next = 0;
        while let Some(&i) = order.get(next) {
            if !nodes[i].is_leaf() {
                order.extend(children(&nodes[i]));
            }
            next += 1;
        }
        // Expected steps of a subtree that has 1 to 8 lanes.
        let mut costs = vec![[0f32; WIDTH]; nodes.len()];
        let mut this = Self { nodes, counts: vec![0; nodes.len()], shares: vec![[0; WIDTH]; nodes.len()] };
        for &i in order.iter().rev() {
            let area = nodes[i].aabb().half_area();
            if nodes[i].is_leaf() {
                (costs[i], this.counts[i]) = ([area; WIDTH], nodes[i].prim_count);
                continue;
            }
            let [a, b] = children(&nodes[i]);
            this.counts[i] = this.counts[a] + this.counts[b];
            (costs[i], this.shares[i]) = best(area, this.is_leaf(i), &costs[a], &costs[b]);
        }
        this
    }

    /// Whether node `i`, where it has one lane, is a leaf: it holds no more triangles than that.
    pub fn is_leaf(&self, i: usize) -> bool {
        self.counts[i] as usize <= WIDTH
    }

    /// The children of wide node `i`, which is no leaf.
    pub fn children(&self, i: usize) -> Vec<usize> {
        let mut found = Vec::with_capacity(WIDTH);
        let mut open = self.shared(i, WIDTH, self.shares[i][0]).to_vec();
        while let Some((i, mut lanes)) = open.pop() {
            while lanes > 1 && self.shares[i][lanes - 1] == 0 {
                lanes -= 1;
            }
            if lanes == 1 {
                found.push(i);
            } else {
                open.extend(self.shared(i, lanes, self.shares[i][lanes - 1]));
            }
        }
        found
    }

    /// The two children of node `i` with their lanes.
    fn shared(&self, i: usize, lanes: usize, first: u8) -> [(usize, usize); 2] {
        let [a, b] = children(&self.nodes[i]);
        [(b, lanes - usize::from(first)), (a, usize::from(first))]
    }

    /// The leaves of the binary tree below node `i`.
    pub fn leaves(&self, i: usize) -> impl Iterator<Item = &Bvh2Node> {
        let mut open = vec![&self.nodes[i]];
        core::iter::from_fn(move || {
            loop {
                let node = open.pop()?;
                if node.is_leaf() {
                    return Some(node);
                }
                let [a, b] = children(node);
                open.extend([&self.nodes[b], &self.nodes[a]]);
            }
        })
    }
}

fn children(node: &Bvh2Node) -> [usize; 2] {
    [node.first_index as usize, node.first_index as usize + 1]
}

/// Least costs of a node of this surface, and the shares of its first child, from the costs of its children.
fn best(area: f32, is_leaf: bool, a: &[f32; WIDTH], b: &[f32; WIDTH]) -> ([f32; WIDTH], [u8; WIDTH]) {
    let (mut costs, mut shares) = ([f32::INFINITY; WIDTH], [1; WIDTH]);
    for lanes in 2..=WIDTH {
        for first in 1..lanes {
            let cost = a[first - 1] + b[lanes - first - 1];
            if cost < costs[lanes - 1] {
                (costs[lanes - 1], shares[lanes - 1]) = (cost, first as u8);
            }
        }
    }
    shares[0] = shares[WIDTH - 1];
    costs[0] = if is_leaf { area } else { area + costs[WIDTH - 1] };
    for lanes in 2..=WIDTH {
        if costs[lanes - 2] <= costs[lanes - 1] {
            (costs[lanes - 1], shares[lanes - 1]) = (costs[lanes - 2], 0);
        }
    }
    (costs, shares)
}
