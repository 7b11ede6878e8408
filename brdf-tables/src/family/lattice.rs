//! The intervals of the widths of a family.

use serde::{Deserialize, Serialize};

/// Most widths of a lattice.
const MOST: usize = 256;

/// Widths that divide the range of a family into intervals. A family of two widths has a cell for each pair of intervals that
/// lie no further apart than `reach`, the wider along x: a lobe that is wider along y is the same turned about the normal.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Lattice {
    /// Ascending: exponents of Phong, roughnesses of the others.
    pub widths: Vec<f64>,
    /// How many intervals the width along x may be ahead of that along y; `None` where both are the same.
    pub reach: Option<u32>,
}

/// A cell of a lattice, and whether x and y are to be exchanged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cell {
    /// Its number.
    pub index: usize,
    /// Whether the lobe is wider along y.
    pub turned: bool,
}

impl Lattice {
    /// Whether there are two widths.
    pub fn has_two_widths(&self) -> bool {
        self.reach.is_some()
    }

    /// Number of intervals.
    pub fn intervals(&self) -> usize {
        self.widths.len().saturating_sub(1)
    }

    /// How far apart the intervals of a cell are.
    fn reach(&self) -> usize {
        self.reach.map_or(0, |reach| reach as usize)
    }

    /// Number of cells.
    pub fn cells(&self) -> usize {
        (0..=self.reach()).map(|apart| self.intervals().saturating_sub(apart)).sum()
    }

    /// The intervals of a cell along x and y.
    pub fn intervals_of(&self, cell: usize) -> [usize; 2] {
        let (mut apart, mut y) = (0, cell);
        while y + apart >= self.intervals() && apart < self.reach() {
            y -= self.intervals() - apart;
            apart += 1;
        }
        [y + apart, y]
    }

    /// The members at the corners of a cell: two of a lattice of one width, else those of four that are not wider along y.
    pub fn corners(&self, cell: usize) -> Vec<[f64; 2]> {
        let [x, y] = self.intervals_of(cell);
        let at = |i: usize, k: usize| [self.widths[x + i], self.widths[y + k]];
        let mut corners = vec![at(0, 0), at(1, 1)];
        if self.has_two_widths() {
            corners.extend([at(1, 0), at(0, 1)].into_iter().filter(|[x, y]| x >= y));
        }
        corners
    }

    /// The cell of two widths; `None` out of range.
    pub fn cell(&self, [x, y]: [f64; 2]) -> Option<Cell> {
        let turned = y > x;
        let (wide, narrow) = if turned { (y, x) } else { (x, y) };
        if self.has_two_widths() == (wide == narrow) {
            return None;
        }
        let [wide, narrow] = [self.interval(wide)?, self.interval(narrow)?];
        let apart = wide - narrow;
        let before: usize = (0..apart).map(|apart| self.intervals() - apart).sum();
        (apart <= self.reach()).then_some(Cell { index: before + narrow, turned })
    }

    /// The interval of a width.
    pub fn interval(&self, width: f64) -> Option<usize> {
        let (first, last) = (*self.widths.first()?, *self.widths.last()?);
        let above = self.widths.partition_point(|w| *w <= width);
        (first..=last).contains(&width).then(|| above.min(self.intervals()) - 1)
    }

    /// Whether it is a lattice: ascending finite widths, not too many.
    pub fn is_valid(&self) -> bool {
        (2..=MOST).contains(&self.widths.len())
            && self.widths.iter().all(|w| w.is_finite() && *w > 0.0)
            && self.widths.is_sorted_by(|a, b| a < b)
            && self.reach() < self.intervals()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_and_their_intervals_are_inverse() {
        for reach in [None, Some(0), Some(1), Some(3)] {
            let lattice = Lattice { widths: (0..=6).map(|i| f64::from(1 << i)).collect(), reach };
            assert!(lattice.is_valid());
            assert_eq!(
                lattice.cells(),
                [6, 6, 11, 18][[None, Some(0), Some(1), Some(3)].iter().position(|r| *r == reach).unwrap()]
            );
            for index in 0..lattice.cells() {
                let [x, y] = lattice.intervals_of(index);
                assert!(x >= y && x - y <= lattice.reach());
                let middle = |i: usize, t: f64| lattice.widths[i] * 2f64.powf(t);
                let (wide, narrow) = (middle(x, 0.6), middle(y, if reach.is_some() { 0.4 } else { 0.6 }));
                assert_eq!(lattice.cell([wide, narrow]), Some(Cell { index, turned: false }));
                if reach.is_some() {
                    assert_eq!(lattice.cell([narrow, wide]), Some(Cell { index, turned: true }));
                    assert_eq!(lattice.corners(index).len(), if x == y { 3 } else { 4 });
                }
            }
        }
    }

    #[test]
    fn what_is_out_of_range_has_no_cell() {
        let one = Lattice { widths: vec![0.1, 0.2, 0.4], reach: None };
        assert_eq!(one.cell([0.1; 2]).map(|c| c.index), Some(0));
        assert_eq!(one.cell([0.4; 2]).map(|c| c.index), Some(1));
        for width in [0.09, 0.41, f64::NAN] {
            assert_eq!(one.cell([width; 2]), None);
        }
        assert_eq!(one.cell([0.3, 0.2]), None);
        let two = Lattice { reach: Some(0), ..one.clone() };
        assert_eq!((two.cell([0.3, 0.15]), two.cell([0.15; 2])), (None, None));
        for bad in [vec![], vec![0.1], vec![0.2, 0.1], vec![0.1, 0.1], vec![0.0, 0.1], vec![0.1, f64::NAN]] {
            assert!(!Lattice { widths: bad, reach: None }.is_valid());
        }
        assert!(!Lattice { reach: Some(2), ..one }.is_valid());
    }
}
