//! The zonal integrals of modified Phong at some exponents, and between them.

use super::Lattice;
use crate::brdf::Specular;
use crate::parts::PartsError;
use crate::zonal::Zonal;

/// Zonal tables of one size and scale, one per exponent of a lattice.
#[derive(Clone, Debug, PartialEq)]
pub struct ZonalSlices {
    rows: usize,
    columns: usize,
    /// One slice after the other, as [`Zonal::new`] takes them.
    cells: Vec<u32>,
    scale: [[f64; 2]; 2],
}

impl ZonalSlices {
    /// From the cells of one slice after the other.
    pub fn new(rows: usize, columns: usize, cells: Vec<u32>, scale: [[f64; 2]; 2]) -> Self {
        Self { rows, columns, cells, scale }
    }

    /// As [`ZonalSlices::new`] takes them.
    pub fn parts(&self) -> (usize, usize, &[u32], [[f64; 2]; 2]) {
        (self.rows, self.columns, &self.cells, self.scale)
    }

    pub(super) fn check(&self, lattice: &Lattice) -> Result<(), PartsError> {
        if lattice.widths.len() < 4 || lattice.has_two_widths() {
            return Err(PartsError::Size { what: "exponents" });
        }
        let size = self.rows.checked_mul(self.columns);
        PartsError::count(size.and_then(|size| size.checked_mul(lattice.widths.len())), self.cells.len())?;
        // The rest is looked at where a table is made.
        Zonal::new(super::Kin::Phong.member([1.0; 2]), self.rows, self.columns, self.slice(0).to_vec(), self.scale)?;
        Ok(())
    }

    fn slice(&self, i: usize) -> &[u32] {
        let size = self.rows * self.columns;
        &self.cells[i * size..][..size]
    }

    /// The table of an exponent: a cubic in 1/√n through the four slices about it. Where lobes are sharp, caps and distances
    /// measured in their widths are all that counts, and what is left changes with the width of the lobe, 1/√n.
    pub(super) fn table(&self, lattice: &Lattice, exponent: f64, specular: Specular) -> Option<Zonal> {
        let first = lattice.interval(exponent)?.saturating_sub(1).min(lattice.widths.len() - 4);
        let at = |i: usize| lattice.widths[first + i].powf(-0.5);
        let x = exponent.powf(-0.5);
        let weights: [f32; 4] = core::array::from_fn(|i| {
            (0..4).filter(|k| *k != i).map(|k| (x - at(k)) / (at(i) - at(k))).product::<f64>() as f32
        });
        let [a, b, c, d] = core::array::from_fn(|i| self.slice(first + i));
        let mix = |low: fn(u32) -> u32, i: usize| {
            let [a, b, c, d] = [a[i], b[i], c[i], d[i]].map(|cell| low(cell) as f32);
            let sum = a * weights[0] + b * weights[1] + c * weights[2] + d * weights[3];
            (sum.clamp(0.0, 65535.0) + 0.5) as u32
        };
        let cells = (0..a.len()).map(|i| mix(|cell| cell & 0xffff, i) | mix(|cell| cell >> 16, i) << 16).collect();
        Zonal::new(specular, self.rows, self.columns, cells, self.scale).ok()
    }
}
