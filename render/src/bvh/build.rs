//! From a list of triangles to the eight-wide tree.

use super::{LEAF, Leaf, Node, WIDTH};
use fearless_simd::Level;
use glam::Vec3A;
use obvhs::bvh2::{Bvh2, builder::build_bvh2_from_tris, node::Bvh2Node};
use obvhs::{BvhBuildParams, triangle::Triangle};
use rayon::prelude::*;
use std::time::Duration;

/// A set of triangles ready for ray queries; triangles keep the numbers of the list they came in.
#[derive(Clone, Debug)]
pub struct TriangleBvh {
    pub(super) nodes: Vec<Node>,
    pub(super) leaves: Vec<Leaf>,
    /// Where traversal starts; `None` without triangles.
    pub(super) root: Option<u32>,
    pub(super) level: Level,
    bounds: (Vec3A, Vec3A),
}

impl TriangleBvh {
    /// Builds the tree.
    pub fn new(triangles: &[[Vec3A; 3]]) -> Self {
        let mut this = Self {
            nodes: Vec::new(),
            leaves: Vec::new(),
            root: None,
            level: Level::new(),
            bounds: (Vec3A::INFINITY, Vec3A::NEG_INFINITY),
        };
        if triangles.is_empty() {
            return this;
        }
        let list: Vec<_> = triangles.par_iter().map(|&[v0, v1, v2]| Triangle { v0, v1, v2 }).collect();
        let params = BvhBuildParams { max_prims_per_leaf: 1, ..BvhBuildParams::medium_build() };
        let binary = build_bvh2_from_tris(&list, params, &mut Duration::default());
        let root = binary.nodes[0].aabb();
        this.bounds = (root.min, root.max);
        let fold = Fold { counts: subtree_sizes(&binary), binary: &binary, triangles };
        this.root = Some(fold.run(&mut this));
        this
    }

    /// Smallest and largest corner; min > max without triangles.
    pub fn bounds(&self) -> (Vec3A, Vec3A) {
        self.bounds
    }

    /// Bytes of the tree and its copy of the triangles.
    pub fn bytes(&self) -> usize {
        self.nodes.len() * size_of::<Node>() + self.leaves.len() * size_of::<Leaf>()
    }
}

/// Number of primitives under every node.
fn subtree_sizes(binary: &Bvh2) -> Vec<u32> {
    let mut order = vec![0usize];
    let mut next = 0;
    while let Some(&i) = order.get(next) {
        let node = &binary.nodes[i];
        if !node.is_leaf() {
            order.extend([node.first_index as usize, node.first_index as usize + 1]);
        }
        next += 1;
    }
    let mut sizes = vec![0; binary.nodes.len()];
    for &i in order.iter().rev() {
        let node = &binary.nodes[i];
        let first = node.first_index as usize;
        sizes[i] = if node.is_leaf() { node.prim_count } else { sizes[first] + sizes[first + 1] };
    }
    sizes
}

/// The folding of a binary tree.
struct Fold<'a> {
    binary: &'a Bvh2,
    counts: Vec<u32>,
    triangles: &'a [[Vec3A; 3]],
}

impl Fold<'_> {
    /// Folds the whole tree, top down; returns the reference to its root.
    fn run(&self, out: &mut TriangleBvh) -> u32 {
        if self.fits(0) {
            return self.leaf(0, out);
        }
        out.nodes.push(EMPTY);
        let mut open = vec![(0usize, 0usize)];
        while let Some((wide, binary)) = open.pop() {
            for (lane, child) in self.children(binary).into_iter().enumerate() {
                let aabb = self.node(child).aabb();
                for axis in 0..3 {
                    out.nodes[wide].bounds[axis][lane] = aabb.min[axis];
                    out.nodes[wide].bounds[3 + axis][lane] = aabb.max[axis];
                }
                out.nodes[wide].children[lane] = if self.fits(child) {
                    self.leaf(child, out)
                } else {
                    out.nodes.push(EMPTY);
                    open.push((out.nodes.len() - 1, child));
                    out.nodes.len() as u32 - 1
                };
            }
        }
        0
    }

    fn node(&self, i: usize) -> &Bvh2Node {
        &self.binary.nodes[i]
    }

    /// Whether the subtree becomes one leaf.
    fn fits(&self, i: usize) -> bool {
        self.counts[i] as usize <= WIDTH
    }

    /// Up to eight descendants that cover the subtree: the one of largest surface is opened until the lanes are full.
    fn children(&self, i: usize) -> Vec<usize> {
        let open = |i: usize| [self.node(i).first_index as usize, self.node(i).first_index as usize + 1];
        let mut children = open(i).to_vec();
        while children.len() < WIDTH {
            let area = |i: usize| self.node(i).aabb().half_area();
            let candidates = (0..children.len()).filter(|&c| !self.fits(children[c]));
            let Some(largest) = candidates.max_by(|&a, &b| area(children[a]).total_cmp(&area(children[b]))) else {
                break;
            };
            let [first, second] = open(children[largest]);
            children[largest] = first;
            children.push(second);
        }
        children
    }

    fn leaf(&self, i: usize, out: &mut TriangleBvh) -> u32 {
        let mut leaf = Leaf { vertices: [[[0.0; WIDTH]; 3]; 3], ids: [u32::MAX; WIDTH] };
        let mut lane = 0;
        let mut open = vec![i];
        while let Some(i) = open.pop() {
            let node = self.node(i);
            if !node.is_leaf() {
                open.extend([node.first_index as usize, node.first_index as usize + 1]);
                continue;
            }
            let range = node.first_index as usize..(node.first_index + node.prim_count) as usize;
            for &id in &self.binary.primitive_indices[range] {
                for (v, vertex) in self.triangles[id as usize].iter().enumerate() {
                    (0..3).for_each(|axis| leaf.vertices[v][axis][lane] = vertex[axis]);
                }
                leaf.ids[lane] = id;
                lane += 1;
            }
        }
        out.leaves.push(leaf);
        LEAF | (out.leaves.len() as u32 - 1)
    }
}

const EMPTY: Node = Node {
    bounds: [
        [f32::INFINITY; WIDTH],
        [f32::INFINITY; WIDTH],
        [f32::INFINITY; WIDTH],
        [f32::NEG_INFINITY; WIDTH],
        [f32::NEG_INFINITY; WIDTH],
        [f32::NEG_INFINITY; WIDTH],
    ],
    children: [0; WIDTH],
};
