//! A binary tree over the boxes of triangles, cut from the top by the surface area heuristic (Wald 2007, "On fast construction of
//! SAH-based bounding volume hierarchies"), on all cores.

use super::bins::{Cut, cheapest};
use glam::Vec3A;
use obvhs::aabb::Aabb;
use obvhs::bvh2::node::Bvh2Node;
use rayon::prelude::*;

/// Boxes that are worth handing to another thread.
pub(super) const BATCH: usize = 1 << 13;

/// Sets that are not split. Leaves of the wide tree hold up to eight, but where lanes are free smaller ones are met less often: with
/// eight here the box has .8 of its rays per second, with two no scene has more, and building takes a quarter longer.
const SMALLEST: usize = 4;

/// Sets that threads grow at the same time, each alone: enough that none waits long for the last.
const TASKS: usize = 64;

/// Levels below which sets are halved: no list of triangles makes the tree, or the stack of who walks through it, deeper than
/// this and the logarithm of its length.
const MAX_UNEVEN_DEPTH: u32 = 48;

/// The box of a triangle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Primitive {
    pub aabb: Aabb,
    /// Number of the triangle.
    pub id: u32,
}

impl Primitive {
    pub fn new(id: usize, [a, b, c]: &[Vec3A; 3]) -> Self {
        Self { aabb: Aabb::new(a.min(*b).min(*c), a.max(*b).max(*c)), id: id as u32 }
    }

    /// Twice the middle of the box.
    #[inline(always)]
    pub fn middle(&self) -> Vec3A {
        self.aabb.min + self.aabb.max
    }
}

/// Primitives that go under one node.
pub(super) struct Set<'a> {
    pub primitives: &'a mut [Primitive],
    /// Bounds of twice their middles.
    pub middles: Aabb,
    aabb: Aabb,
    /// Where they stand in the whole list.
    start: u32,
    depth: u32,
}

impl<'a> Set<'a> {
    fn new(primitives: &'a mut [Primitive], start: u32, depth: u32) -> Self {
        let none = [Aabb::INVALID; 2];
        let bounds = |list: &[Primitive]| {
            list.iter().fold(none, |[aabb, middles], p| {
                [aabb.union(&p.aabb), Aabb::new(middles.min.min(p.middle()), middles.max.max(p.middle()))]
            })
        };
        let [aabb, middles] = if primitives.len() < 2 * BATCH {
            bounds(primitives)
        } else {
            let join = |a: [Aabb; 2], b: [Aabb; 2]| [a[0].union(&b[0]), a[1].union(&b[1])];
            primitives.par_chunks(BATCH).map(bounds).reduce(|| none, join)
        };
        Self { primitives, middles, aabb, start, depth }
    }

    fn node(&self) -> Bvh2Node {
        Bvh2Node::new(self.aabb, self.primitives.len() as u32, self.start)
    }

    /// In two where that costs least; into halves where no bin tells the middles apart.
    fn split(self) -> [Self; 2] {
        let cut = if self.depth < MAX_UNEVEN_DEPTH { cheapest(&self) } else { None };
        let first = match cut {
            Some(cut) => partition(self.primitives, &cut),
            None => {
                let (axis, half) = (self.middles.largest_axis(), self.primitives.len() / 2);
                let order = |a: &Primitive, b: &Primitive| a.middle()[axis].total_cmp(&b.middle()[axis]);
                self.primitives.select_nth_unstable_by(half, |a, b| order(a, b).then(a.id.cmp(&b.id)));
                half
            }
        };
        let (a, b) = self.primitives.split_at_mut(first);
        [Self::new(a, self.start, self.depth + 1), Self::new(b, self.start + first as u32, self.depth + 1)]
    }
}

/// Moves the primitives of the first side to the front; returns how many they are.
fn partition(primitives: &mut [Primitive], cut: &Cut) -> usize {
    let (mut i, mut j) = (0, primitives.len());
    loop {
        while i < j && cut.is_first(&primitives[i]) {
            i += 1;
        }
        while i < j && !cut.is_first(&primitives[j - 1]) {
            j -= 1;
        }
        if i == j {
            return i;
        }
        primitives.swap(i, j - 1);
    }
}

/// The nodes of the tree, the root first, siblings behind one another. The primitives are put into its order; leaves hold at most
/// [`SMALLEST`] of them.
pub(super) fn grow(primitives: &mut [Primitive]) -> Vec<Bvh2Node> {
    let alone = (primitives.len() / TASKS).max(BATCH / 2);
    let (mut nodes, mut tasks) = (Vec::new(), Vec::new());
    grow_down(&mut nodes, Set::new(primitives, 0, 0), |node, set| {
        if set.primitives.len() > alone {
            return Some(set);
        }
        tasks.push((node, set));
        None
    });
    let grown = tasks.into_par_iter().map(|(node, set)| {
        let mut part = Vec::new();
        grow_down(&mut part, set, |_, set| Some(set));
        (node, part)
    });
    for (node, part) in grown.collect::<Vec<_>>() {
        // The root of a part takes the place that was kept for it.
        let offset = nodes.len() as u32 - 1;
        let mut part = part.into_iter().map(|n| moved(n, offset));
        nodes[node] = part.next().expect("a tree has a root");
        nodes.extend(part);
    }
    nodes
}

/// A node whose children stand `offset` places further back.
fn moved(node: Bvh2Node, offset: u32) -> Bvh2Node {
    if node.is_leaf() { node } else { Bvh2Node::new(*node.aabb(), 0, node.first_index + offset) }
}

/// Adds the tree over a set. `keep` is asked about every set that is to be split, with its node, and may take it away.
fn grow_down<'a>(nodes: &mut Vec<Bvh2Node>, set: Set<'a>, mut keep: impl FnMut(usize, Set<'a>) -> Option<Set<'a>>) {
    nodes.push(set.node());
    let mut open = vec![(nodes.len() - 1, set)];
    while let Some((node, set)) = open.pop() {
        if set.primitives.len() <= SMALLEST {
            continue;
        }
        let Some(set) = keep(node, set) else { continue };
        let first_child = nodes.len() as u32;
        nodes[node] = Bvh2Node::new(set.aabb, 0, first_child);
        for child in set.split() {
            nodes.push(child.node());
            open.push((nodes.len() - 1, child));
        }
    }
}
