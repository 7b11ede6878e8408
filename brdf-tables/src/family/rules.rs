//! The rules of cubature of every cell of a family.

use super::{Cell, Kin, Lattice};
use crate::axis::Axes;
use crate::brdf::Specular;
use crate::cubature::{Bins, Cubature, Node};
use crate::parts::PartsError;
use core::f64::consts::TAU;
use std::sync::{Arc, OnceLock};

/// Rules per cell of a lattice, each on a grid of its own: Ω on it stands for a height times the sharpness of the lobe, up to
/// that of the sharpest member of the cell.
#[derive(Debug)]
pub struct RuleCells {
    axes: Axes,
    nodes: Vec<Node>,
    /// The bins of the cells in use, as they are and turned.
    ready: Vec<[OnceLock<Bins>; 2]>,
}

impl RuleCells {
    /// From the nodes of one cell after the other, on `axes` (whose sharpness is not used).
    pub fn new(axes: Axes, nodes: Vec<Node>) -> Self {
        let cells = nodes.len() / axes.len().max(1);
        Self { axes, nodes, ready: (0..cells).map(|_| Default::default()).collect() }
    }

    /// Grid and nodes.
    pub fn parts(&self) -> (Axes, &[Node]) {
        (self.axes, &self.nodes)
    }

    pub(super) fn check(&self, lattice: &Lattice) -> Result<(), PartsError> {
        if (self.axes.phi > 1) != lattice.has_two_widths() {
            return Err(PartsError::Size { what: "azimuths" });
        }
        PartsError::count(self.axes.len().checked_mul(lattice.cells()), self.nodes.len())?;
        PartsError::first("node", &self.nodes, |n| n.is_valid())
    }

    /// The grid of a cell.
    pub fn axes_of(lattice: &Lattice, kin: Kin, cell: usize, axes: Axes) -> Axes {
        let sharpness = |widths: [f64; 2]| kin.member(widths).lobe_width().powi(-2);
        Axes { sharpness: lattice.corners(cell).into_iter().map(sharpness).fold(0.0, f64::max), ..axes }
    }

    /// The solid angle that a node of the grid of a cell stands for, for a lobe of this sharpness.
    pub fn omega_of(axes: Axes, omega: usize, sharpness: f64) -> f64 {
        (axes.omega_at(omega) * axes.sharpness / sharpness).min(TAU)
    }

    /// The node at a place of the grid, its azimuths reversed where x and y are exchanged.
    fn node(&self, Cell { index, turned }: Cell, [t, p, o]: [usize; 3]) -> Node {
        let p = if turned { self.axes.phi as usize - 1 - p } else { p };
        self.nodes[index * self.axes.len() + self.axes.index(t, p, o)]
    }

    /// The table of a member of a cell.
    pub(super) fn table(&self, lattice: &Lattice, kin: Kin, cell: Cell, specular: Specular) -> Option<Cubature> {
        let sharpness = specular.lobe_width().powi(-2);
        let of_cell = Self::axes_of(lattice, kin, cell.index, self.axes);
        let ready = &self.ready.get(cell.index)?[usize::from(cell.turned)];
        let bins = match ready.get() {
            Some(bins) => bins,
            None => {
                let nodes: Vec<Node> = places(self.axes).map(|place| self.node(cell, place)).collect();
                let bins = Bins::of_family(of_cell, &nodes).ok()?;
                ready.get_or_init(|| bins)
            }
        };
        // On the grid of a table of its own: the larger of the nodes about each.
        let axes = Axes { sharpness, ..self.axes };
        let about: Vec<[usize; 2]> = (0..axes.omega as usize)
            .map(|o| {
                let place = of_cell.omega_place(axes.omega_at(o) * sharpness / of_cell.sharpness);
                [place.index, place.index + usize::from(place.fraction > 1e-6)]
            })
            .collect();
        let node = |[t, p, o]: [usize; 3]| {
            let [below, above] = about[o].map(|o| self.node(cell, [t, p, o]));
            below.or(above)
        };
        let nodes: Arc<[Node]> = places(axes).map(node).collect();
        Some(Cubature::with_bins(specular, axes, nodes, bins.scaled(sharpness)))
    }
}

/// Every node of a grid, in order.
fn places(axes: Axes) -> impl Iterator<Item = [usize; 3]> {
    let [theta, phi, omega] = [axes.theta, axes.phi, axes.omega].map(|n| n as usize);
    (0..theta).flat_map(move |t| (0..phi).flat_map(move |p| (0..omega).map(move |o| [t, p, o])))
}

/// Without the bins, which follow.
impl Clone for RuleCells {
    fn clone(&self) -> Self {
        Self::new(self.axes, self.nodes.clone())
    }
}

/// As [`Clone`].
impl PartialEq for RuleCells {
    fn eq(&self, other: &Self) -> bool {
        self.axes == other.axes && self.nodes == other.nodes
    }
}
