//! The order of the cubature per cell: the least that meets the tolerance there.

use super::{Fitted, Options, oracle, values};
use crate::error::Directions;
use brdf_tables::axis::Axes;
use brdf_tables::brdf::Specular;
use brdf_tables::cubature::{Cubature, ORDERS};
use brdf_tables::table::Representation;
use core::f64::consts::PI;
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Fits the orders.
pub(super) fn fit(specular: &Specular, options: &Options) -> Fitted {
    let phi = if specular.is_isotropic() { 1 } else { 5 };
    let axes = Axes { theta: 13, phi, omega: 14, sharpness: specular.lobe_width().powi(-2), stretch: 0.5 };
    let oracle = oracle(*specular);
    let candidates: Vec<Cubature> =
        (0..ORDERS.len() as u8).filter_map(|order| Cubature::uniform(*specular, order)).collect();
    let done = AtomicUsize::new(0);
    let nodes: Vec<[u8; 2]> = (0..axes.len())
        .into_par_iter()
        .map(|i| {
            let (omega, rest) = (i % axes.omega as usize, i / axes.omega as usize);
            let cap = axes.cap_at(rest / axes.phi as usize, rest % axes.phi as usize, omega);
            let directions = Directions::new(specular, &cap);
            let exact = values(&oracle, &cap, &directions);
            let meets = |candidate: &Cubature| {
                let errors = directions.errors(&exact, &values(candidate, &cap, &directions));
                let within = |error: f32, bound: f64| f64::from(error) <= bound * options.tolerance;
                // The tail of a lobe weighs little in rmse_lobe, but it holds much of the energy of GGX.
                within(errors.rmse_lobe, 1.0) && within(errors.l1, 3.0) && within(errors.albedo, 1.5)
            };
            let support = (directions.support(&cap, &exact) / PI * 255.0).ceil().min(255.0) as u8;
            let order = candidates.iter().position(meets).unwrap_or(ORDERS.len() - 1) as u8;
            (options.progress)(0.9 * (done.fetch_add(1, Ordering::Relaxed) + 1) as f64 / axes.len() as f64);
            [order, support]
        })
        .collect();
    let mut count = [0usize; ORDERS.len()];
    nodes.iter().for_each(|node| count[usize::from(node[0])] += 1);
    let spread: Vec<String> =
        ORDERS.iter().zip(count).filter(|c| c.1 > 0).map(|(o, c)| format!("{o}×{o}: {c}")).collect();
    let table = Cubature::new(*specular, axes, &nodes).expect("one order per node");
    let notes = vec![format!("rule per cell (evaluations of the model: cells): {}", spread.join(", "))];
    Fitted { representation: Representation::Cubature(table), notes }
}
