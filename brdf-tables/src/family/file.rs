//! Bytes ↔ [`Family`]. The layout is documented in `tables/README.md`.

use super::{Family, FamilyHeader, Kin, Measured, RuleCells, Store, ZonalSlices};
use crate::axis::Axes;
use crate::cubature::Node;
use crate::format::{FormatError, MAX_NODES, seal};
use crate::parts::PartsError;
use serde::{Deserialize, Serialize};

/// First eight bytes of a family.
pub const MAGIC: [u8; 8] = *b"BURNFAM\n";
/// Version written, and the only one there has been.
pub const VERSION: u32 = 1;

/// Bytes of a node: the two rules, four bits each, and the two angles.
const NODE: usize = 3;
/// Bytes per node of the error grid.
const CELL: usize = 6;

/// Sizes of the store, as the header has them.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
enum Shape {
    Rules { axes: Axes },
    Zonal { rows: u32, columns: u32, scale: [[f64; 2]; 2] },
}

#[derive(Serialize, Deserialize)]
struct Stored {
    header: FamilyHeader,
    axes: Axes,
    shape: Shape,
}

impl Family {
    /// The bytes of the file.
    ///
    /// # Errors
    /// If the header is longer than 1 MiB.
    pub fn to_bytes(&self) -> Result<Vec<u8>, FormatError> {
        let (axes, measured, store) = self.parts();
        let mut payload: Vec<u8> = measured.iter().flat_map(|m| m.0).collect();
        let shape = match store {
            Store::Rules(rules) => {
                let (axes, nodes) = rules.parts();
                payload.extend(nodes.iter().flat_map(|n| [n.disc | n.product << 4, n.outer, n.far]));
                Shape::Rules { axes }
            }
            Store::Zonal(slices) => {
                let (rows, columns, cells, scale) = slices.parts();
                payload.extend(cells.iter().flat_map(|cell| cell.to_le_bytes()));
                Shape::Zonal { rows: rows as u32, columns: columns as u32, scale }
            }
        };
        seal::seal(MAGIC, VERSION, &Stored { header: self.header.clone(), axes, shape }, &payload)
    }

    /// Reads the bytes of a file. Nothing is allocated beyond a small multiple of their number.
    ///
    /// # Errors
    /// Whatever is wrong with them; never a panic.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, FormatError> {
        let opened = seal::open::<Stored>(bytes, MAGIC, |version| version == VERSION).map_err(|error| match error {
            FormatError::Version(version) => FormatError::FamilyVersion(version),
            error => error,
        })?;
        let seal::Opened { header, payload, .. } = opened.ok_or(FormatError::FamilyMagic)?;
        let Stored { header, axes, shape } = header;
        let bad = |what: &str| FormatError::Header(what.into());
        if header.promise.iter().chain([&header.tolerance]).any(|x| !(x.is_finite() && *x >= 0.0)) {
            return Err(bad("tolerance or promise is not a positive number"));
        }
        if !axes.is_valid(MAX_NODES) || !header.lattice.is_valid() {
            return Err(bad("error grid or widths out of range"));
        }
        let count = axes.len() * header.lattice.cells() * CELL;
        let (measured, rest) = payload.split_at_checked(count).ok_or(FormatError::Payload("too short"))?;
        let measured = measured.as_chunks::<CELL>().0.iter().map(|bytes| Measured(*bytes)).collect();
        let store = match shape {
            Shape::Rules { axes } => {
                if !axes.is_valid(MAX_NODES) {
                    return Err(bad("grid out of range"));
                }
                let (nodes, spare) = rest.as_chunks::<NODE>();
                PartsError::count(Some(0), spare.len())?;
                let node =
                    |&[rules, outer, far]: &[u8; NODE]| Node { disc: rules & 15, product: rules >> 4, outer, far };
                Store::Rules(RuleCells::new(axes, nodes.iter().map(node).collect()))
            }
            Shape::Zonal { rows, columns, scale } => {
                let (cells, spare) = rest.as_chunks::<4>();
                PartsError::count(Some(0), spare.len())?;
                let cells = cells.iter().map(|b| u32::from_le_bytes(*b)).collect();
                Store::Zonal(ZonalSlices::new(rows as usize, columns as usize, cells, scale))
            }
        };
        Ok(Self::new(header, axes, measured, store)?)
    }

    /// The extension of its file.
    pub const EXTENSION: &'static str = "fam";

    /// What a file of it is called: the model, and whether it is of two widths.
    pub fn file_stem(kin: Kin, two_widths: bool) -> String {
        format!("{}{}", kin.name(), if two_widths { "-anisotropic" } else { "" })
    }
}
