//! The tree over the samples of a record (eas-2015, §3.2, Fig. 5 and eq. 12).

use crate::color::luminance;
use crate::hemisphere::{Cell, GatherSample, MAX_CHILDREN};
use crate::scene::Rgb;
use core::f32::consts::TAU;
use core::ops::Range;
use glam::Vec3A;

/// A potential EAS: the light of one cell.
#[derive(Clone, Copy, Debug)]
pub struct Node {
    /// Where on the hemisphere.
    pub cell: Cell,
    /// Irradiance E_N, W·m⁻².
    pub irradiance: Rgb,
    /// Solid angle Ω_N, sr.
    pub solid_angle: f32,
    /// Projected solid angle ∫ cosθ dω of its samples, sr: exact, where that of a cap is not that of the cell.
    pub projected: f32,
    /// Unit direction of the centroid, local frame: the mean direction weighted by irradiance.
    pub direction: Vec3A,
    /// 1/distance of the centroid; 0 at infinity.
    pub inv_distance: f32,
    /// Mean unit normal N_N, world space; zero where the normals cancel.
    pub normal: Vec3A,
    /// Children in [`Tree::nodes`]; empty for a leaf.
    first_child: u32,
    child_count: u32,
}

impl Node {
    /// Indices of the children.
    pub fn children(&self) -> Range<usize> {
        self.first_child as usize..(self.first_child + self.child_count) as usize
    }

    /// Whether the node has no children.
    pub fn is_leaf(&self) -> bool {
        self.child_count == 0
    }
}

/// How the centroid of a node follows from its samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Centroid {
    /// Mean position, weighted by irradiance (eq. 12). A far sample outweighs a near one.
    Position,
    /// Mean direction and mean 1/distance: the axis of the light, and the parallax that is right to first order; light at
    /// infinity needs no special case.
    Direction,
}

/// All nodes, children behind their parents; the root is the first.
#[derive(Clone, Debug)]
pub struct Tree {
    nodes: Vec<Node>,
}

/// Deepest level: more than any number of samples asks for.
const MAX_LEVEL: u32 = 12;

impl Tree {
    /// Builds the tree until no leaf holds more than `leaf_samples` samples.
    pub fn new(samples: &mut [GatherSample], leaf_samples: usize, centroid: Centroid) -> Self {
        let mut tree = Self { nodes: Vec::with_capacity(2 * samples.len() / leaf_samples.max(1) + 8) };
        tree.nodes.push(leaf(Cell::HEMISPHERE, samples, centroid));
        tree.split(0, samples, leaf_samples.max(1), 0, centroid);
        tree
    }

    /// The tree over samples of cells: its leaves are these, or hold no more samples than one of them.
    pub fn of_cells(samples: &mut [GatherSample], cells: &[(Cell, u32)]) -> Self {
        let most = cells.iter().map(|c| c.1).max().unwrap_or(1);
        Self::new(samples, most as usize, Centroid::Direction)
    }

    /// Every node, the root first.
    pub fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    /// Subdivides a node and everything below it.
    fn split(
        &mut self,
        node: usize,
        samples: &mut [GatherSample],
        leaf_samples: usize,
        level: u32,
        centroid: Centroid,
    ) {
        // The root is always divided: one source for the whole hemisphere is too coarse.
        if (level > 0 && samples.len() <= leaf_samples) || samples.is_empty() || level == MAX_LEVEL {
            return;
        }
        let cell = self.nodes[node].cell;
        let child_of = |s: &GatherSample| {
            let azimuth = s.direction.y.atan2(s.direction.x);
            cell.child_of(s.direction.z, if azimuth < 0.0 { azimuth + TAU } else { azimuth })
        };
        samples.sort_by_cached_key(child_of);
        let mut ends = [0; MAX_CHILDREN];
        samples.iter().for_each(|s| ends[child_of(s)] += 1);
        let first_child = self.nodes.len();
        let mut start = 0;
        for (child, count) in cell.children().zip(ends) {
            if count > 0 {
                self.nodes.push(leaf(child, &samples[start..start + count], centroid));
            }
            start += count;
        }
        let children = first_child..self.nodes.len();
        self.nodes[node].first_child = first_child as u32;
        self.nodes[node].child_count = children.len() as u32;
        let mut rest = samples;
        let counts: Vec<usize> = ends.into_iter().filter(|&n| n > 0).collect();
        for (child, count) in children.zip(counts) {
            let (own, others) = rest.split_at_mut(count);
            self.split(child, own, leaf_samples, level + 1, centroid);
            rest = others;
        }
    }
}

/// Weight of a sample in the means: luminance, one number for all channels, so that the mean is a point.
fn weight(sample: &GatherSample) -> f32 {
    luminance(sample.irradiance())
}

/// The means of eq. 12 over the samples of a cell; black samples count by their solid angle where there is no light.
fn leaf(cell: Cell, samples: &[GatherSample], centroid: Centroid) -> Node {
    let total: f32 = samples.iter().map(weight).sum();
    let lit = total > 0.0;
    let of = |s: &GatherSample| if lit { weight(s) / total } else { 1.0 / samples.len() as f32 };
    let mut node = Node {
        cell,
        irradiance: samples.iter().map(GatherSample::irradiance).sum(),
        solid_angle: samples.iter().map(|s| s.solid_angle).sum(),
        projected: samples.iter().map(|s| s.projected).sum(),
        direction: Vec3A::ZERO,
        inv_distance: 0.0,
        normal: samples.iter().map(|s| s.normal * of(s)).sum::<Vec3A>().normalize_or_zero(),
        first_child: 0,
        child_count: 0,
    };
    let directions = || samples.iter().map(|s| s.direction * of(s)).sum::<Vec3A>().try_normalize();
    match centroid {
        Centroid::Direction => {
            node.direction = directions().unwrap_or_else(|| cell.center());
            node.inv_distance = samples.iter().map(|s| s.inv_distance * of(s)).sum();
        }
        Centroid::Position => {
            let near: f32 = samples.iter().filter(|s| s.inv_distance > 0.0).map(of).sum();
            if near < 0.5 {
                node.direction = directions().unwrap_or_else(|| cell.center());
            } else {
                let finite = samples.iter().filter(|s| s.inv_distance > 0.0);
                let position = finite.map(|s| s.direction * (of(s) / (near * s.inv_distance))).sum::<Vec3A>();
                node.direction = position.try_normalize().unwrap_or_else(|| cell.center());
                node.inv_distance = position.length_recip();
            }
        }
    }
    // Directions of a record point above its horizon; rounding must not put one below.
    node.direction.z = node.direction.z.max(0.0);
    node.direction = node.direction.normalize_or(Vec3A::Z);
    node
}
