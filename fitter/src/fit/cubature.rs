//! The rule of the cubature per cell: the cheapest that meets the tolerance there.

use super::{FitError, Fitted, Options, oracle, values};
use crate::error::Directions;
use brdf_tables::axis::Axes;
use brdf_tables::brdf::{Brdf, Specular};
use brdf_tables::cap::Cap;
use brdf_tables::cubature::{Cubature, NONE, Node, OUTER, RULES, Rule};
use brdf_tables::frame::mirror;
use brdf_tables::mean::MeanBrdf;
use brdf_tables::table::Representation;
use core::f64::consts::PI;
use glam::DVec3;
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Fits the rules.
pub(super) fn fit(specular: &Specular, options: &Options) -> Result<Fitted, FitError> {
    let phi = if specular.is_isotropic() { 1 } else { 5 };
    let axes = Axes { theta: 13, phi, omega: 24, sharpness: specular.lobe_width().powi(-2), stretch: 0.5 };
    let chooser = Chooser::new(*specular, options.tolerance, values, Effort::Full);
    let done = AtomicUsize::new(0);
    let nodes: Vec<Node> = (0..axes.len())
        .into_par_iter()
        .map(|i| {
            let (omega, rest) = (i % axes.omega as usize, i / axes.omega as usize);
            let cap = axes.cap_at(rest / axes.phi as usize, rest % axes.phi as usize, omega);
            let node = chooser.node(&cap);
            options.tell(0.9 * (done.fetch_add(1, Ordering::Relaxed) + 1) as f64 / axes.len() as f64)?;
            Ok(node)
        })
        .collect::<Result<_, FitError>>()?;
    let table = Cubature::new(*specular, axes, &nodes).expect("one rule per node");
    let notes = vec![format!("rule per cell (nodes: cells): {}", spread(&nodes))];
    Ok(Fitted { representation: Representation::Cubature(table), notes })
}

/// How often each rule is the cheaper of its node.
pub(crate) fn spread(nodes: &[Node]) -> String {
    let mut count = [0usize; RULES.len()];
    nodes.iter().for_each(|node| count[usize::from(node.disc.min(node.product))] += 1);
    let spread: Vec<String> =
        RULES.iter().zip(count).filter(|c| c.1 > 0).map(|(rule, c)| format!("{rule}: {c}")).collect();
    spread.join(", ")
}

/// How F is evaluated over directions.
pub(crate) type Values = fn(&dyn MeanBrdf, &Cap, &Directions) -> Vec<f64>;

/// Finds the cheapest rules that meet a tolerance.
pub(crate) struct Chooser {
    specular: Specular,
    oracle: Cubature,
    candidates: [Cubature; RULES.len()],
    tolerance: f64,
    values: Values,
    effort: Effort,
}

/// How the cheapest rule of a kind is sought.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Effort {
    /// One after the other.
    Full,
    /// By halves, as if every rule were better than those before, and over half as many directions: what is found meets the
    /// tolerance, though a cheaper one might. A fifth of the time.
    Quick,
}

impl Chooser {
    /// For the caps of a model.
    pub fn new(specular: Specular, tolerance: f64, values: Values, effort: Effort) -> Self {
        let candidates = RULES.map(|rule| Cubature::uniform(specular, rule));
        Self { specular, oracle: oracle(specular), candidates, tolerance, values, effort }
    }

    /// The rules for a cap.
    pub fn node(&self, cap: &Cap) -> Node {
        let Self { specular, candidates, tolerance, values, .. } = self;
        let directions = match self.effort {
            Effort::Full => Directions::new(specular, cap),
            Effort::Quick => Directions::with(specular, cap, 18, 14),
        };
        let exact = values(&self.oracle, cap, &directions);
        let meets = |candidate: &Cubature| {
            let errors = directions.errors(&exact, &values(candidate, cap, &directions));
            let within = |error: f32, bound: f64| f64::from(error) <= bound * tolerance;
            // The tail of a lobe weighs little in rmse_lobe, but it holds much of the energy of GGX.
            within(errors.rmse_lobe, 1.0) && within(errors.l1, 3.0) && within(errors.albedo, 1.5)
        };
        let cheapest = |discs: bool| {
            let of_a_kind: Vec<usize> =
                (0..RULES.len()).filter(|&i| matches!(RULES[i], Rule::Disc(_)) == discs).collect();
            let misses = |i: &usize| !meets(&candidates[*i]);
            let found = match self.effort {
                Effort::Full => of_a_kind.iter().position(|i| !misses(i)),
                Effort::Quick => Some(of_a_kind.partition_point(misses)),
            };
            found.and_then(|found| of_a_kind.get(found)).map(|i| *i as u8)
        };
        let (disc, product) = (cheapest(true).unwrap_or(NONE), cheapest(false).unwrap_or(RULES.len() as u8 - 1));
        let at_axis: Vec<f64> = directions.wo.iter().map(|&wo| specular.eval(lit(cap.axis()), wo)).collect();
        let outer = values(&candidates[usize::from(OUTER)], cap, &directions);
        let beyond = |cheap: &[f64]| steps(begins(&directions, cap, &exact, cheap, *tolerance));
        Node { disc, product, outer: beyond(&outer), far: beyond(&at_axis) }
    }
}

/// A direction on the horizon moved just above it, where a model has its limit and not the zero of below.
fn lit(axis: DVec3) -> DVec3 {
    DVec3::new(axis.x, axis.y, axis.z.max(1e-9))
}

/// An angle in steps of π/255, rounded up.
fn steps(angle: f64) -> u8 {
    (angle / PI * 255.0).ceil().min(255.0) as u8
}

/// The angle from the mirrored cap axis beyond which a cheap approximation does: at each direction to a fifth of the
/// tolerance (over the peak of F), and all of them together to half of it (over the integral of F).
fn begins(directions: &Directions, cap: &Cap, exact: &[f64], cheap: &[f64], tolerance: f64) -> f64 {
    let peak = exact.iter().fold(0f64, |m, &f| m.max(f));
    let total: f64 = exact.iter().zip(&directions.weight).map(|(f, w)| f * w).sum();
    let centre = mirror(cap.axis());
    let angle = |wo: &DVec3| 2.0 * (0.5 * (*wo - centre).length()).min(1.0).asin();
    let angles: Vec<f64> = directions.wo.iter().map(angle).collect();
    // From the farthest direction inwards, until the budget is spent.
    let mut order: Vec<usize> = (0..exact.len()).collect();
    order.sort_by(|&a, &b| angles[b].total_cmp(&angles[a]));
    let mut spent = 0.0;
    for i in order {
        let error = (cheap[i] - exact[i]).abs();
        spent += error * directions.weight[i];
        if error > 0.2 * tolerance * peak || spent > 0.5 * tolerance * total {
            // Directions are rings apart: up to here, with room for what lies between.
            return angles[i] * 1.1 + 0.01;
        }
    }
    0.0
}
