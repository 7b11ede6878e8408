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
    let frame = [t, u, axis];
    let (mut sum, mut area) = (zero, zero);
    for ring in rings {
        let h = height * one.load(&ring.height);
        let (along, across) = (one - h, (h * (two - h)).sqrt());
        let (mut row, mut row_area) = (zero, zero);
        let (fours, last) = if F::LONG { ring.azimuths.as_chunks() } else { (&[][..], &ring.azimuths[..]) };
        for [a, b, c, d] in fours {
            let (a, b) = (direction(frame, along, across, a), direction(frame, along, across, b));
            let (c, d) = (direction(frame, along, across, c), direction(frame, along, across, d));
            let [e, f, g, h] = formula.rest_of_four([a, b, c, d], wo);
            row = d[2].mul_add(h, c[2].mul_add(g, b[2].mul_add(f, a[2].mul_add(e, row))));
            row_area = row_area + a[2] + b[2] + c[2] + d[2];
        }
        for node in last {
            let wi = direction(frame, along, across, node);
            row = wi[2].mul_add(formula.rest(wi, wo), row);
            row_area = row_area + wi[2];
        }
        let weight = one.load(&ring.weight);
        (sum, area) = (weight.mul_add(row, sum), weight.mul_add(row_area, area));
    }
    (sum * formula.factor(wo), area)
}

/// The direction to a node of a ring, from the cosine and the sine of its angle from the axis.
#[inline(always)]
fn direction<T: Real>([t, u, axis]: [[T; 3]; 3], along: T, across: T, (c, s): &(T::Lanes, T::Lanes)) -> [T; 3] {
    let (c, s) = (across * across.load(c), across * across.load(s));
    let [x, y, z] = [
        c.mul_add(t[0], s.mul_add(u[0], along * axis[0])),
        c.mul_add(t[1], s.mul_add(u[1], along * axis[1])),
        c.mul_add(t[2], s.mul_add(u[2], along * axis[2])),
    ];
    // Models are made for directions above the horizon.
    [x, y, z.max(z.lit(1e-9))]
}
