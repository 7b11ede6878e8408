//! From a list of triangles to the eight-wide tree.

use super::binary::{Primitive, grow};
use super::fold::Fold;
use super::{LEAF, Leaf, Node, WIDTH};
use fearless_simd::Level;
use glam::Vec3A;
use obvhs::bvh2::{Bvh2, node::Bvh2Node, reinsertion::ReinsertionOptimizer};
use rayon::prelude::*;

/// Share of the nodes that are tried at better places in the first round (Meister and Bittner 2018, "Parallel reinsertion for
/// bounding volume hierarchy optimization"). Without it rooms lose up to a fifth of their rays per second (bench `rays`); twice of
/// it costs a tenth of the build and gains nothing.
const REINSERTED: f32 = 0.05;

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
        let mut primitives: Vec<_> = triangles.par_iter().enumerate().map(|(i, t)| Primitive::new(i, t)).collect();
        let mut binary = Bvh2 { nodes: grow(&mut primitives), ..Bvh2::default() };
        ReinsertionOptimizer::default().run(&mut binary, REINSERTED, None);
        let root = binary.nodes[0].aabb();
        this.bounds = (root.min, root.max);
        let fold = Fold::new(&binary.nodes);
        let (nodes, leaves) = widen(&binary.nodes, &fold);
        this.root = Some(if nodes.is_empty() { LEAF } else { 0 });
        this.nodes = nodes;
        this.leaves = leaves
            .par_iter()
            .map(|&i| {
                let below = |n: &Bvh2Node| &primitives[n.first_index as usize..][..n.prim_count as usize];
                Leaf::new(triangles, fold.leaves(i).flat_map(below))
            })
            .collect();
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

/// Wide nodes, the root first, and the nodes of the binary tree that are leaves. No node where the root is a leaf.
fn widen(binary: &[Bvh2Node], fold: &Fold) -> (Vec<Node>, Vec<usize>) {
    if fold.is_leaf(0) {
        return (Vec::new(), vec![0]);
    }
    let (mut nodes, mut leaves) = (vec![Node::EMPTY], Vec::new());
    let mut open = vec![(0, 0)];
    while let Some((wide, i)) = open.pop() {
        let mut children = fold.children(i);
        // Who asks for any hit looks into the last lane first: at what most likely stops a ray soonest.
        let area = |i: usize| binary[i].aabb().half_area();
        children.sort_by(|&a, &b| fold.is_leaf(a).cmp(&fold.is_leaf(b)).then(area(a).total_cmp(&area(b))));
        for (lane, child) in children.into_iter().enumerate() {
            let aabb = binary[child].aabb();
            for axis in 0..3 {
                nodes[wide].bounds[axis][lane] = aabb.min[axis];
                nodes[wide].bounds[3 + axis][lane] = aabb.max[axis];
            }
            nodes[wide].children[lane] = if fold.is_leaf(child) {
                leaves.push(child);
                LEAF | (leaves.len() - 1) as u32
            } else {
                nodes.push(Node::EMPTY);
                open.push((nodes.len() - 1, child));
                (nodes.len() - 1) as u32
            };
        }
    }
    (nodes, leaves)
}

impl Node {
    /// No lane has a child.
    const EMPTY: Self = {
        let [low, high] = [[f32::INFINITY; WIDTH], [f32::NEG_INFINITY; WIDTH]];
        Self { bounds: [low, low, low, high, high, high], children: [0; WIDTH] }
    };
}

impl Leaf {
    /// Of at most eight triangles.
    fn new<'a>(triangles: &[[Vec3A; 3]], primitives: impl Iterator<Item = &'a Primitive>) -> Self {
        let mut leaf = Self { vertices: [[[0.0; WIDTH]; 3]; 3], ids: [u32::MAX; WIDTH] };
        for (lane, p) in primitives.enumerate() {
            for (v, vertex) in triangles[p.id as usize].iter().enumerate() {
                (0..3).for_each(|axis| leaf.vertices[v][axis][lane] = vertex[axis]);
            }
            leaf.ids[lane] = p.id;
        }
        leaf
    }
}
