//! Rules of cubature for the cells of a family: those that do for the members at all corners.

use super::{Options, Plan, values};
use crate::fit::cubature::{Chooser, Effort, spread};
use brdf_tables::cap::Cap;
use brdf_tables::cubature::Node;
use brdf_tables::family::{RuleCells, Store};
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

/// The rules of all cells.
pub(super) fn fit(plan: &Plan, options: &Options) -> (Store, Vec<String>) {
    let Plan { kin, lattice, axes, .. } = plan;
    let done = AtomicUsize::new(0);
    let of_cell = |cell: usize| {
        let own = RuleCells::axes_of(lattice, *kin, cell, *axes);
        let corners: Vec<(f64, Chooser)> = lattice
            .corners(cell)
            .into_iter()
            .map(|widths| kin.member(widths))
            .map(|s| (s.lobe_width().powi(-2), Chooser::new(s, options.tolerance, values, Effort::Quick)))
            .collect();
        let nodes: Vec<Node> = (0..axes.len())
            .into_par_iter()
            .map(|i| {
                let (o, rest) = (i % axes.omega as usize, i / axes.omega as usize);
                let (theta, phi) = (rest / axes.phi as usize, rest % axes.phi as usize);
                let of_corner = |(sharpness, chooser): &(f64, Chooser)| {
                    let omega = RuleCells::omega_of(own, o, *sharpness).max(1e-12);
                    chooser.node(&Cap::new(own.theta_at(theta), own.phi_at(phi), omega).expect("within the domain"))
                };
                corners.iter().map(of_corner).fold(Node::default(), Node::or)
            })
            .collect();
        let fraction = (done.fetch_add(1, Ordering::Relaxed) + 1) as f64 / lattice.cells() as f64;
        (options.progress)(0.85 * fraction);
        nodes
    };
    let nodes: Vec<Node> = (0..lattice.cells()).into_par_iter().flat_map_iter(of_cell).collect();
    let note = format!("cubature, rule per cell (nodes: cells): {}", spread(&nodes));
    (Store::Rules(RuleCells::new(*axes, nodes)), vec![note])
}
