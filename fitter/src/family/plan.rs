//! Which widths a family has tables for, and on which grids.

use brdf_tables::axis::Axes;
use brdf_tables::brdf::Specular;
use brdf_tables::family::{Kin, Lattice};
use rand::{Rng, RngExt};

/// What a family is fitted for.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// The model.
    pub kin: Kin,
    /// Its widths.
    pub lattice: Lattice,
    /// Grid of the rules of a cell; their sharpness is that of the cell.
    pub axes: Axes,
    /// Grid of the measured errors of a cell.
    pub error_axes: Axes,
}

/// Widest ratio of the two widths, in intervals.
const REACH: u32 = 3;

impl Plan {
    /// The plan for a model; `None` of two widths where the model has one.
    pub fn new(kin: Kin, two_widths: bool) -> Option<Self> {
        if two_widths && !kin.has_two_widths() {
            return None;
        }
        let spaced = |first: f64, last: f64, intervals: i32| -> Vec<f64> {
            let at = |i: i32| first * (last / first).powf(f64::from(i) / f64::from(intervals));
            // The ends as they are written.
            (0..=intervals).map(|i| if i == intervals { last } else { at(i) }).collect()
        };
        let widths = match (kin, two_widths) {
            // Uniform in 1/√n, which the cubics are in, but for the sharpest.
            (Kin::Phong, _) => (1..=16).rev().map(|i| (f64::from(i) / 16.0).powi(-2)).chain([2e3, 1e5]).collect(),
            (Kin::Sheen, _) => spaced(0.07, 1.0, 8),
            // Cells take the rules of their hardest corner: those of GGX differ more along a cell, and look-ups were 1.4 times
            // as long as with a table of their own where steps were twice as wide.
            (Kin::Ggx, false) => spaced(1e-3, 1.0, 40),
            (_, false) => spaced(1e-3, 1.0, 20),
            (_, true) => spaced(1e-2, 1.0, 7),
        };
        let grid = |theta, phi, omega| Axes { theta, phi, omega, sharpness: 1.0, stretch: 0.5 };
        let (axes, error_axes) =
            if two_widths { (grid(8, 4, 16), grid(5, 3, 6)) } else { (grid(13, 1, 24), grid(10, 1, 10)) };
        Some(Self { kin, lattice: Lattice { widths, reach: two_widths.then_some(REACH) }, axes, error_axes })
    }
}

/// The members just within the corners of a cell.
pub(super) fn inside(kin: Kin, lattice: &Lattice, cell: usize) -> Vec<Specular> {
    let middle = lattice.intervals_of(cell).map(|i| (lattice.widths[i] * lattice.widths[i + 1]).sqrt());
    // Of a lattice of two widths, x is the wider, also where a corner lies on the diagonal.
    let ordered = |[x, y]: [f64; 2]| [x, if lattice.has_two_widths() { y.min(x * (1.0 - 1e-6)) } else { y }];
    let within = |corner: [f64; 2]| ordered(core::array::from_fn(|k| corner[k] * (middle[k] / corner[k]).powf(1e-4)));
    lattice.corners(cell).into_iter().map(|corner| kin.member(within(corner))).collect()
}

/// A member at random: any cell alike, log-uniform within.
pub fn random_member(kin: Kin, lattice: &Lattice, rng: &mut impl Rng) -> Specular {
    loop {
        let [x, y] = lattice.intervals_of(rng.random_range(0..lattice.cells()));
        let mut within = |i: usize| {
            let [low, high] = [lattice.widths[i], lattice.widths[i + 1]];
            low * (high / low).powf(rng.random())
        };
        let (wide, mut narrow) = (within(x), within(y));
        if !lattice.has_two_widths() {
            narrow = wide;
        }
        let widths = if rng.random() { [wide, narrow] } else { [narrow, wide] };
        if lattice.cell(widths).is_some() {
            return kin.member(widths);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_xoshiro::Xoshiro256PlusPlus;

    #[test]
    fn members_lie_within() {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(1);
        for (kin, two) in Kin::ALL.into_iter().flat_map(|kin| [(kin, false), (kin, true)]) {
            let Some(Plan { lattice, .. }) = Plan::new(kin, two) else {
                assert!(two && !kin.has_two_widths());
                continue;
            };
            assert!(lattice.is_valid(), "{kin:?}: {lattice:?}");
            let cell = |specular: &Specular| lattice.cell(Kin::of(specular).unwrap().1);
            for index in 0..lattice.cells() {
                for member in inside(kin, &lattice, index) {
                    let found = cell(&member).unwrap();
                    assert_eq!((found.index, found.turned), (index, false), "{member:?}");
                }
            }
            let drawn: Vec<_> = (0..200).map(|_| cell(&random_member(kin, &lattice, &mut rng)).unwrap()).collect();
            assert_eq!(drawn.iter().any(|c| c.turned), two);
        }
    }
}
