//! The cut through the tree that a record keeps (eas-2015, §3.2, eqs. 13–14 and Fig. 6).

use super::reflector::Reflector;
use super::tree::Tree;
use crate::color::luminance;
use crate::scene::Rgb;
use brdf_tables::batch::CapBatch;
use core::cmp::Ordering;
use glam::Vec3A;
use std::collections::BinaryHeap;

/// When to stop refining.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CutSettings {
    /// τ: largest global relative error (eq. 13).
    pub tolerance: f32,
    /// Most nodes in the cut.
    pub max_eas: usize,
}

/// A cut and how good it is.
#[derive(Clone, Debug)]
pub struct Cut {
    /// Indices of its nodes, ascending.
    pub nodes: Vec<usize>,
    /// Global error ε_g against two levels below, luminance.
    pub error: f32,
}

/// A node that could be refined; the order of the heap is by error, then by index, so that ties have one outcome.
#[derive(PartialEq)]
struct Candidate {
    error: f32,
    node: usize,
}

impl Eq for Candidate {}

impl PartialOrd for Candidate {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Candidate {
    fn cmp(&self, other: &Self) -> Ordering {
        self.error.total_cmp(&other.error).then(other.node.cmp(&self.node))
    }
}

/// NodeRadiance radiance of every node in every direction.
struct NodeRadiance {
    /// E·F per direction, node by node.
    values: Vec<Rgb>,
    directions: usize,
}

impl NodeRadiance {
    fn of(&self, node: usize) -> &[Rgb] {
        &self.values[node * self.directions..(node + 1) * self.directions]
    }

    /// Sum over the nodes two levels below; over the level above where the tree ends.
    fn below(&self, tree: &Tree, node: usize) -> Vec<Rgb> {
        let mut sum = vec![Rgb::ZERO; self.directions];
        let mut add = |i: usize| sum.iter_mut().zip(self.of(i)).for_each(|(s, v)| *s += *v);
        let nodes = tree.nodes();
        if nodes[node].is_leaf() {
            add(node);
        }
        for child in nodes[node].children() {
            if nodes[child].is_leaf() {
                add(child);
            }
            nodes[child].children().for_each(&mut add);
        }
        sum
    }

    fn new(tree: &Tree, reflector: &Reflector, directions: &[Vec3A]) -> Self {
        let nodes = tree.nodes();
        let mut caps = CapBatch::with_capacity(nodes.len());
        nodes.iter().for_each(|n| caps.push_nearest(n.direction.into(), n.solid_angle));
        let mut mean = vec![0.0; nodes.len()];
        let mut values = vec![Rgb::ZERO; nodes.len() * directions.len()];
        for (k, wo) in directions.iter().enumerate() {
            reflector.values(&caps, *wo, &mut mean);
            for (i, (node, f)) in nodes.iter().zip(&mean).enumerate() {
                values[i * directions.len() + k] = node.irradiance * reflector.whole(*f);
            }
        }
        Self { values, directions: directions.len() }
    }
}

/// Refines the first level, worst node first, until the reflected radiance in `directions` (#D, unit, local frame) agrees
/// with that of the comparison level two below to the tolerance.
pub fn cut(tree: &Tree, reflector: &Reflector, directions: &[Vec3A], settings: &CutSettings) -> Cut {
    let nodes = tree.nodes();
    let reflected = NodeRadiance::new(tree, reflector, directions);
    let mut in_cut: Vec<usize> = nodes[0].children().collect();
    let (mut current, mut comparison) = (vec![Rgb::ZERO; directions.len()], vec![Rgb::ZERO; directions.len()]);
    let mut heap = BinaryHeap::new();
    let difference = |node: usize, sign: f32, current: &mut [Rgb], comparison: &mut [Rgb]| {
        let below = reflected.below(tree, node);
        let mut local = Rgb::ZERO;
        for (k, (own, below)) in reflected.of(node).iter().zip(&below).enumerate() {
            current[k] += *own * sign;
            comparison[k] += *below * sign;
            local += (*below - *own) * (*below - *own);
        }
        luminance(local)
    };
    let mut open = |node: usize, error: f32| {
        if !nodes[node].is_leaf() {
            heap.push(Candidate { error, node });
        }
    };
    for &node in &in_cut {
        let error = difference(node, 1.0, &mut current, &mut comparison);
        open(node, error);
    }
    let mut removed = vec![false; nodes.len()];
    let mut count = in_cut.len();
    loop {
        let error = global_error(&current, &comparison);
        let done = error <= settings.tolerance;
        let next = if done { None } else { heap.pop() };
        let Some(Candidate { node, .. }) =
            next.filter(|c| count + nodes[c.node].children().len() <= settings.max_eas + 1)
        else {
            in_cut.retain(|&n| !removed[n]);
            in_cut.sort_unstable();
            return Cut { nodes: in_cut, error };
        };
        difference(node, -1.0, &mut current, &mut comparison);
        removed[node] = true;
        count += nodes[node].children().len() - 1;
        for child in nodes[node].children() {
            in_cut.push(child);
            let error = difference(child, 1.0, &mut current, &mut comparison);
            if !nodes[child].is_leaf() {
                heap.push(Candidate { error, node: child });
            }
        }
    }
}

/// ε_g of eq. 13 as luminance: RMSE over the mean of the comparison, reflected radiance in as many directions; 0 where
/// nothing is reflected.
pub fn global_error(current: &[Rgb], comparison: &[Rgb]) -> f32 {
    let n = current.len().max(1) as f32;
    let (mut squares, mut mean) = (Rgb::ZERO, Rgb::ZERO);
    for (cur, comp) in current.iter().zip(comparison) {
        squares += (*comp - *cur) * (*comp - *cur);
        mean += *comp;
    }
    let relative = |c: usize| {
        let mean = mean[c] / n;
        if mean > 0.0 { (squares[c] / n).sqrt() / mean } else { 0.0 }
    };
    luminance(Rgb::new(relative(0), relative(1), relative(2)))
}
