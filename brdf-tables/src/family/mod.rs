//! Families: one file for a model of whatever roughness, from which the table of any member follows without a fit.
//!
//! A cubature table says which rule serves a cap; the model is evaluated as it is. In solid angles times the sharpness of the
//! lobe the choice changes slowly with the roughness: a family has one for each cell of a [`Lattice`] of roughnesses, which
//! does for all members there, whatever their Fresnel term. Of modified Phong the two integrals of a zonal table are
//! interpolated between exponents.
//!
//! ```
//! use brdf_tables::brdf::{Phong, Specular};
//! use brdf_tables::{Material, family};
//!
//! // No file and no fit: microseconds.
//! let material = Material::specular(Specular::Phong(Phong { exponent: 123.4 }));
//! # #[cfg(feature = "families")]
//! let table = family::table(&material).expect("an exponent of 1 to 100 000");
//! ```

mod cell;
mod file;
mod kin;
mod lattice;
mod rules;
#[cfg(feature = "families")]
mod shipped;
mod zonal;

pub use cell::Measured;
pub use file::{MAGIC, VERSION};
pub use kin::{Kin, resized};
pub use lattice::{Cell, Lattice};
pub use rules::RuleCells;
#[cfg(feature = "families")]
pub use shipped::{families, table};
pub use zonal::ZonalSlices;

use crate::axis::Axes;
use crate::brdf::Specular;
use crate::errors::Summary;
use crate::material::Material;
use crate::parts::PartsError;
use crate::table::{CellInfo, Header, Representation, Table};
use serde::{Deserialize, Serialize};

/// Provenance and promise of a family.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FamilyHeader {
    /// Whose members it has tables for.
    pub kin: Kin,
    /// Of which widths.
    pub lattice: Lattice,
    /// Program and version that made it.
    pub creator: String,
    /// Command line that made it.
    pub command: String,
    /// Seed of every random choice.
    pub seed: u64,
    /// Tolerance asked of rmse_lobe.
    pub tolerance: f64,
    /// As [`Header::promise`], for random caps of random members.
    pub promise: [f64; 3],
    /// How it came to be, one line each.
    pub notes: Vec<String>,
    /// Errors at the nodes of the error grids that belong to the main domain, of the members at the corners of the cells.
    pub at_nodes: Summary,
    /// Errors at random caps of the main domain of random members.
    pub off_nodes: Summary,
    /// Errors at random caps that cross the horizon, of random members.
    pub clipped: Summary,
}

/// How the tables of a family follow from it.
#[derive(Clone, Debug, PartialEq)]
pub enum Store {
    /// Rules of cubature per cell.
    Rules(RuleCells),
    /// Zonal integrals per width.
    Zonal(ZonalSlices),
}

/// Tables of all members of a family.
#[derive(Clone, Debug, PartialEq)]
pub struct Family {
    /// Provenance and promise.
    pub header: FamilyHeader,
    axes: Axes,
    measured: Vec<Measured>,
    store: Store,
}

impl Family {
    /// From its parts: the error grid (whose sharpness is not used), what was measured on it per cell of the lattice, and what
    /// tables are made of.
    ///
    /// # Errors
    /// A lattice that is none, a store that is not for such models, wrong counts.
    pub fn new(header: FamilyHeader, axes: Axes, measured: Vec<Measured>, store: Store) -> Result<Self, PartsError> {
        let lattice = &header.lattice;
        let fits = match &store {
            Store::Zonal(_) => header.kin == Kin::Phong,
            Store::Rules(_) => header.kin.has_two_widths() || !lattice.has_two_widths(),
        };
        let ends = [lattice.widths.first(), lattice.widths.last()];
        let member =
            |w: Option<&f64>| w.is_some_and(|&w| Material::specular(header.kin.member([w; 2])).validate().is_ok());
        if !lattice.is_valid() || !ends.into_iter().all(member) {
            return Err(PartsError::Size { what: "the lattice of widths" });
        }
        if !fits || (axes.phi > 1) != lattice.has_two_widths() {
            return Err(PartsError::Material);
        }
        PartsError::count(axes.len().checked_mul(lattice.cells()), measured.len())?;
        match &store {
            Store::Rules(rules) => rules.check(lattice)?,
            Store::Zonal(slices) => slices.check(lattice)?,
        }
        Ok(Self { header, axes, measured, store })
    }

    /// Error grid, what was measured on it, and what tables are made of, as [`Family::new`] takes them.
    pub fn parts(&self) -> (Axes, &[Measured], &Store) {
        (self.axes, &self.measured, &self.store)
    }

    /// Whether a model is a member within range.
    pub fn holds(&self, specular: &Specular) -> bool {
        self.place(specular).is_some()
    }

    /// Its cell and its widths.
    fn place(&self, specular: &Specular) -> Option<(Cell, [f64; 2])> {
        let (kin, widths) = Kin::of(specular)?;
        let cell = self.header.lattice.cell(widths)?;
        (kin == self.header.kin).then_some((cell, widths))
    }

    /// The table of a member, in microseconds; `None` for a material that is no member within range. The first table of a
    /// cell of the lattice takes ten to a hundred times as long.
    pub fn for_model(&self, material: &Material) -> Option<Table> {
        let specular = material.specular?;
        let (cell, widths) = self.place(&specular)?;
        let sharpness = specular.lobe_width().powi(-2);
        let representation = match &self.store {
            Store::Rules(rules) => {
                Representation::Cubature(rules.table(&self.header.lattice, self.header.kin, cell, specular)?)
            }
            Store::Zonal(slices) => Representation::Zonal(slices.table(&self.header.lattice, widths[0], specular)?),
        };
        let FamilyHeader { creator, command, seed, tolerance, promise, notes, at_nodes, off_nodes, clipped, .. } =
            self.header.clone();
        let header = Header {
            material: *material,
            creator,
            command,
            seed,
            tolerance,
            promise,
            notes,
            at_nodes,
            off_nodes,
            clipped,
        };
        let axes = Axes { sharpness, ..self.axes };
        Some(Table { header, representation, axes, cells: self.cells(cell, axes) })
    }

    /// What was measured in a cell.
    fn cells(&self, Cell { index, turned }: Cell, axes: Axes) -> Vec<CellInfo> {
        let of_cell = &self.measured[index * axes.len()..][..axes.len()];
        let node = |i: usize| {
            let (o, rest) = (i % axes.omega as usize, i / axes.omega as usize);
            let (p, t) = (rest % axes.phi as usize, rest / axes.phi as usize);
            let p = if turned { axes.phi as usize - 1 - p } else { p };
            of_cell[axes.index(t, p, o)].info()
        };
        (0..axes.len()).map(node).collect()
    }
}
