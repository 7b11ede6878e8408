//! Disc rules: nodes on rings about the axis of a cap that is small beside the lobe.

use super::rule::{Ring, tangents};
use crate::brdf::Formula;
use crate::real::Real;

/// ∫ f_r cosθi and ∫ cosθi over the cap by a rule of rings, both over its solid angle; arguments as of
/// [`super::numerator`], but in a frame where the formula holds. Nodes below the horizon count for nothing: caps that cross it
/// deeply need a product rule.
#[inline(always)]
pub fn disc<T: Real, F: Formula>(formula: &F, wo: [T; 3], axis: [T; 3], height: T, rings: &[Ring<T::Lanes>]) -> (T, T) {
    let (zero, one, two) = (height.lit(0.0), height.lit(1.0), height.lit(2.0));
    let [t, u] = tangents(axis);
    let (mut sum, mut area) = (zero, zero);
    for ring in rings {
        let h = height * one.load(&ring.height);
        let (along, across) = (one - h, (h * (two - h)).sqrt());
        let (mut row, mut row_area) = (zero, zero);
        for (c, s) in &ring.azimuths {
            let (c, s) = (across * one.load(c), across * one.load(s));
            let place = |i: usize| c.mul_add(t[i], s.mul_add(u[i], along * axis[i]));
            // Models are made for directions above the horizon.
            let wi = [place(0), place(1), place(2).max(one.lit(1e-9))];
            row = wi[2].mul_add(formula.rest(wi, wo), row);
            row_area = row_area + wi[2];
        }
        let weight = one.load(&ring.weight);
        (sum, area) = (weight.mul_add(row, sum), weight.mul_add(row_area, area));
    }
    (sum * formula.factor(wo), area)
}
