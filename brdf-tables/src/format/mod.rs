//! Bytes ↔ [`Table`]. The layout is public and documented in `tables/README.md`; all numbers are little-endian.
//!
//!   magic "BURNISH\n" · version u32 · header length u32 · header (bincode 2, serde, fixed integers, at most 1 MiB) ·
//!   payload: one f32 sextuple per error cell, then the arrays of the representation · CRC-32 of all before it u32

pub(crate) mod seal;

use crate::axis::Axes;
use crate::cubature::{Cubature, Node};
use crate::errors::Errors;
use crate::lobes::Lobes;
use crate::paper::Paper;
use crate::parts::PartsError;
use crate::table::{CellInfo, Header, Representation, Table};
use crate::zonal::Zonal;
use serde::{Deserialize, Serialize};

/// First eight bytes of a table; the line feed shows a file mangled by text-mode transfers.
pub const MAGIC: [u8; 8] = *b"BURNISH\n";
/// Version written. The one before it is read too: its cubature tables know product rules only, and are slower.
pub const VERSION: u32 = 2;
/// Longest header accepted, bytes: that of a measured material, whose values stand in it; others take less than 4 KiB.
const MAX_HEADER: usize = 1 << 20;
/// Largest file accepted, bytes: eight times the largest table the fitter makes.
#[cfg(feature = "fs")]
pub(crate) const MAX_FILE: u64 = 1 << 24;
/// Most nodes of a grid.
pub(crate) const MAX_NODES: usize = 1 << 16;
/// Bytes per error cell: five errors and the support angle.
const CELL: usize = 24;

/// Why bytes are not a table.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FormatError {
    /// The file could not be read or written.
    #[cfg(feature = "fs")]
    #[error("{0}")]
    Io(#[from] std::io::Error),
    /// The magic number is wrong.
    #[error("not a table (the first bytes are not BURNISH)")]
    Magic,
    /// The magic number of a family is wrong.
    #[error("not a family of tables (the first bytes are not BURNFAM)")]
    FamilyMagic,
    /// The version is none that this library reads.
    #[error("table version {0}, this program reads versions {older} and {VERSION}: fit it again", older = VERSION - 1)]
    Version(u32),
    /// The version of a family is none that this library reads.
    #[error("version {0} of a family of tables, which this program does not read: fit it again")]
    FamilyVersion(u32),
    /// The file ends early, or goes on after its end.
    #[error("{what} needs {expected} bytes, the file has {found}")]
    Length {
        /// Which part.
        what: &'static str,
        /// Bytes it needs.
        expected: u64,
        /// Bytes there are.
        found: u64,
    },
    /// The file is larger than any table.
    #[cfg(feature = "fs")]
    #[error("larger than {MAX_FILE} bytes, no table is")]
    TooLarge,
    /// The checksum does not match.
    #[error("damaged: checksum {found:08x} instead of {expected:08x}; copy or fit it again")]
    Checksum {
        /// In the file.
        expected: u32,
        /// That of the bytes as they are.
        found: u32,
    },
    /// A value in the header cannot be.
    #[error("header: {0}")]
    Header(String),
    /// A number of the payload is cut or not finite.
    #[error("payload: {0}")]
    Payload(&'static str),
    /// The numbers of the payload do not make the representation.
    #[error("payload: {0}")]
    Parts(#[from] PartsError),
}

/// Sizes of the representation, as the header stores them.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
enum Shape {
    Diffuse,
    Zonal { rows: u32, columns: u32, scale: [[f64; 2]; 2] },
    Cubature { axes: Axes },
    Lobes { axes: Axes, count: u32 },
    Paper { elevations: u32, solid_angles: u32, count: u32 },
}

#[derive(Serialize, Deserialize)]
struct Stored {
    header: Header,
    axes: Axes,
    shape: Shape,
}

impl Table {
    /// The bytes of the file.
    ///
    /// # Errors
    /// If the header is longer than 1 MiB.
    pub fn to_bytes(&self) -> Result<Vec<u8>, FormatError> {
        let (shape, payload): (Shape, Vec<u8>) = match &self.representation {
            Representation::Diffuse => (Shape::Diffuse, Vec::new()),
            Representation::Zonal(t) => {
                let (rows, columns, cells, scale) = t.parts();
                let shape = Shape::Zonal { rows: rows as u32, columns: columns as u32, scale };
                (shape, cells.iter().flat_map(|x| x.to_le_bytes()).collect())
            }
            Representation::Cubature(t) => {
                let (axes, nodes) = t.parts();
                (Shape::Cubature { axes }, nodes.iter().flat_map(|n| [n.disc, n.product, n.outer, n.far]).collect())
            }
            Representation::Lobes(t) => {
                let (axes, count, data) = t.parts();
                (Shape::Lobes { axes, count: count as u32 }, floats(data))
            }
            Representation::Paper(t) => {
                let (elevations, solid_angles, count, data) = t.parts();
                let shape = Shape::Paper {
                    elevations: elevations as u32,
                    solid_angles: solid_angles as u32,
                    count: count as u32,
                };
                (shape, floats(data))
            }
        };
        let stored = Stored { header: self.header.clone(), axes: self.axes, shape };
        let mut content = Vec::with_capacity(self.cells.len() * CELL + payload.len());
        for cell in &self.cells {
            content.extend(floats(&cell.errors.to_array()));
            content.extend(cell.support.to_le_bytes());
        }
        content.extend(payload);
        seal::seal(MAGIC, VERSION, &stored, &content)
    }

    /// Reads the bytes of a file. Nothing is allocated beyond a small multiple of their number.
    ///
    /// # Errors
    /// Whatever is wrong with them; never a panic.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, FormatError> {
        let known = |version| (VERSION - 1..=VERSION).contains(&version);
        let opened = seal::open::<Stored>(bytes, MAGIC, known)?.ok_or(FormatError::Magic)?;
        opened.header.build(opened.payload, opened.version)
    }
}

impl Stored {
    /// Checks the header and reads the payload.
    fn build(self, payload: &[u8], version: u32) -> Result<Table, FormatError> {
        let Self { header, axes, shape } = self;
        let bad = |what: String| FormatError::Header(what);
        header.material.validate().map_err(|e| bad(format!("material: {e}")))?;
        let numbers = header.promise.iter().chain([&header.tolerance]);
        if numbers.into_iter().any(|x| !(x.is_finite() && *x >= 0.0)) {
            return Err(bad("tolerance or promise is not a positive number".into()));
        }
        if matches!(shape, Shape::Diffuse) != header.material.specular.is_none() {
            return Err(bad("the representation does not fit the material".into()));
        }
        if !axes.is_valid(MAX_NODES) {
            return Err(bad("error grid out of range".into()));
        }
        let cells = if matches!(shape, Shape::Diffuse) { 0 } else { axes.len() };
        let (first, rest) = payload.split_at_checked(cells * CELL).ok_or(FormatError::Payload("too short"))?;
        let first = read_floats(first)?;
        let cells: Vec<CellInfo> = first
            .chunks_exact(6)
            .map(|c| CellInfo { errors: Errors::from_array([c[0], c[1], c[2], c[3], c[4]]), support: c[5] })
            .collect();
        let representation = shape.read(&header, rest, version)?;
        Ok(Table { header, representation, axes, cells })
    }
}

impl Shape {
    fn read(self, header: &Header, bytes: &[u8], version: u32) -> Result<Representation, FormatError> {
        let Some(specular) = header.material.specular else {
            PartsError::count(Some(0), bytes.len())?;
            return Ok(Representation::Diffuse);
        };
        let grid = |axes: Axes| {
            let valid = axes.is_valid(MAX_NODES).then_some(axes);
            valid.ok_or_else(|| FormatError::Header("grid out of range".into()))
        };
        Ok(match self {
            Shape::Diffuse => return Err(PartsError::Material.into()),
            Shape::Zonal { rows, columns, scale } => {
                let (cells, rest) = bytes.as_chunks::<4>();
                PartsError::count(Some(0), rest.len())?;
                let cells = cells.iter().map(|b| u32::from_le_bytes(*b)).collect();
                Representation::Zonal(Zonal::new(specular, rows as usize, columns as usize, cells, scale)?)
            }
            Shape::Cubature { axes } => {
                let (axes, nodes) = (grid(axes)?, read_nodes(bytes, version)?);
                Representation::Cubature(Cubature::new(specular, axes, &nodes)?)
            }
            Shape::Lobes { axes, count } => {
                Representation::Lobes(Lobes::new(grid(axes)?, count as usize, read_floats(bytes)?)?)
            }
            Shape::Paper { elevations, solid_angles, count } => {
                let sizes = [elevations, solid_angles, count].map(|x| x as usize);
                Representation::Paper(Paper::new(sizes[0], sizes[1], sizes[2], read_floats(bytes)?)?)
            }
        })
    }
}

/// The nodes of a cubature table, in the form of a version.
fn read_nodes(bytes: &[u8], version: u32) -> Result<Vec<Node>, FormatError> {
    if version == VERSION {
        let (nodes, rest) = bytes.as_chunks::<4>();
        PartsError::count(Some(0), rest.len())?;
        return Ok(nodes.iter().map(|&[disc, product, outer, far]| Node { disc, product, outer, far }).collect());
    }
    let (nodes, rest) = bytes.as_chunks::<3>();
    PartsError::count(Some(0), rest.len())?;
    let node = |(at, node): (usize, &[u8; 3])| {
        Node::from_version_1(*node).ok_or(FormatError::Parts(PartsError::Number { what: "node", at }))
    };
    nodes.iter().enumerate().map(node).collect()
}

fn floats(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|x| x.to_le_bytes()).collect()
}

fn read_floats(bytes: &[u8]) -> Result<Vec<f32>, FormatError> {
    let values: Vec<f32> = bytes.chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect();
    if !bytes.len().is_multiple_of(4) || values.iter().any(|x| !x.is_finite()) {
        return Err(FormatError::Payload("a number is cut or not finite"));
    }
    Ok(values)
}
