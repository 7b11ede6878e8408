//! Caches on disk: a rendering that goes on from one gives the same picture, a moved camera adds what it needs.
//!
//! Little-endian: magic (8 bytes), version and header length (u32), header (bincode, at most 64 KiB), records, CRC-32 of all
//! before it. Irradiance records are 28 f32; an EAS record is 12 numbers of 4 bytes and its sources of 40 bytes; a harmonic
//! record is position, axes of its frame and radius (13 f32), material, order and count (u32), and its coefficients (f32).

use super::Settings;
use super::caches::Caches;
use super::policy::Policy;
use crate::cache::Spacing;
use crate::frame::Frame;
use crate::record::Record;
use crate::record::eas::{Eas, EasRecord, Estimator};
use crate::record::harmonics::HarmonicsRecord;
use crate::record::irradiance::IrradianceRecord;
use crate::scene::checksum::{Checksums, Hash};
use crate::world::World;
use glam::Vec3A;
use kit::output::{self, OutputError};
use serde::{Deserialize, Serialize};
use std::io::Read;
use std::path::Path;

const MAGIC: &[u8; 8] = b"BURNREC\n";
const VERSION: u32 = 5;
const MAX_HEADER: usize = 1 << 16;
/// Larger files are not read.
const MAX_BYTES: u64 = 4 << 30;

/// Why a cache file is of no use.
#[derive(Debug, thiserror::Error)]
pub enum CacheFileError {
    /// It cannot be read.
    #[error("{0}")]
    Io(#[from] std::io::Error),
    /// It cannot be written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// It is not a cache file, or damaged.
    #[error("not a cache file, or a damaged one: {0}; remove it to fill a new one")]
    Format(&'static str),
    /// It belongs to something else.
    #[error("the cache was filled for another {0}; remove it, or name another file")]
    Stale(&'static str),
}

/// What a file was made for. Numbers are checksums.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Header {
    scene: u64,
    materials: u64,
    tables: u64,
    method: u64,
    camera: u64,
    estimator: Estimator,
    tolerance: f32,
    spacing: Spacing,
    sources: Option<u64>,
    indirect_only: bool,
    coarse: u64,
    irradiance: u64,
    eas: u64,
    harmonics: u64,
}

/// Caches that were read, and whether they are all that the camera needs.
pub struct Loaded {
    /// The records.
    pub caches: Caches,
    /// Whether camera, τ and spacing are those the file was made for.
    pub complete: bool,
}

/// What a rendering would write into the header, counts aside.
fn header(world: &World, policy: &Policy, settings: &Settings, tolerance: f32) -> Header {
    let Checksums { geometry, materials, camera } = Checksums::new(&world.scene);
    let mut tables = Hash::default();
    for lobe in &policy.lobes {
        // A table that was too large for its file would have none to be told from.
        tables.bytes(&lobe.table.to_bytes().unwrap_or_default());
    }
    let mut method = Hash::default();
    method.encoded(&(policy.treatments(), policy.projection));
    Header {
        scene: geometry,
        materials,
        tables: tables.finish(),
        method: method.finish(),
        camera,
        estimator: settings.estimator,
        tolerance,
        spacing: settings.spacing,
        sources: settings.sources.map(|n| n as u64),
        indirect_only: settings.indirect_only,
        coarse: 0,
        irradiance: 0,
        eas: 0,
        harmonics: 0,
    }
}

fn config() -> impl bincode::config::Config {
    bincode::config::legacy().with_limit::<MAX_HEADER>()
}

/// Writes caches: the file appears whole or not at all.
///
/// # Errors
/// A place that cannot be written.
pub fn save(
    path: &Path,
    world: &World,
    policy: &Policy,
    settings: &Settings,
    tolerance: f32,
    caches: &Caches,
) -> Result<(), CacheFileError> {
    let count = |n: usize| n as u64;
    let header = Header {
        coarse: count(caches.coarse.records().len()),
        irradiance: count(caches.irradiance.records().len()),
        eas: count(caches.eas.records().len()),
        harmonics: count(caches.harmonics.records().len()),
        ..header(world, policy, settings, tolerance)
    };
    let encoded = bincode::serde::encode_to_vec(header, config()).map_err(|_| CacheFileError::Format("header"))?;
    let mut bytes = MAGIC.to_vec();
    bytes.extend(VERSION.to_le_bytes());
    bytes.extend((encoded.len() as u32).to_le_bytes());
    bytes.extend(encoded);
    let mut number = |x: f32| bytes.extend(x.to_le_bytes());
    for record in caches.coarse.records().iter().chain(caches.irradiance.records()) {
        record.to_numbers().into_iter().for_each(&mut number);
    }
    for record in caches.eas.records() {
        let (p, n, b) = (record.position(), record.normal(), record.background);
        let words = [p.x, p.y, p.z, n.x, n.y, n.z, record.radius(), b.x, b.y, b.z];
        words.into_iter().for_each(|x| bytes.extend(x.to_le_bytes()));
        bytes.extend(record.material.to_le_bytes());
        bytes.extend((record.sources.len() as u32).to_le_bytes());
        record.sources.iter().for_each(|s| bytes.extend(s.to_bytes()));
    }
    for record in caches.harmonics.records() {
        let vectors = core::iter::once(record.position()).chain(record.frame().axes());
        vectors.flat_map(|v| v.to_array()).for_each(|x| bytes.extend(x.to_le_bytes()));
        bytes.extend(record.radius().to_le_bytes());
        let counts = [record.material, record.order() as u32, record.numbers().len() as u32];
        counts.into_iter().for_each(|x| bytes.extend(x.to_le_bytes()));
        record.numbers().iter().for_each(|x| bytes.extend(x.to_le_bytes()));
    }
    bytes.extend(crc32fast::hash(&bytes).to_le_bytes());
    Ok(output::write(path, &bytes)?)
}

/// Reads caches that fit the scene, its materials and tables. Allocates no more than a small multiple of the file.
///
/// # Errors
/// A file that is damaged, or that was made for something else.
pub fn load(
    path: &Path,
    world: &World,
    policy: &Policy,
    settings: &Settings,
    tolerance: f32,
) -> Result<Loaded, CacheFileError> {
    let mut bytes = Vec::new();
    std::fs::File::open(path)?.take(MAX_BYTES).read_to_end(&mut bytes)?;
    from_bytes(&bytes, world, policy, settings, tolerance)
}

/// [`load`] from memory.
///
/// # Errors
/// As [`load`].
pub fn from_bytes(
    bytes: &[u8],
    world: &World,
    policy: &Policy,
    settings: &Settings,
    tolerance: f32,
) -> Result<Loaded, CacheFileError> {
    let mut reader = Reader { bytes };
    if reader.take(8)? != MAGIC {
        return Err(CacheFileError::Format("wrong magic"));
    }
    if reader.word()? != VERSION {
        return Err(CacheFileError::Format("another version"));
    }
    let body = bytes.len().saturating_sub(4);
    if crc32fast::hash(&bytes[..body]).to_le_bytes() != bytes[body..] {
        return Err(CacheFileError::Format("wrong checksum"));
    }
    let length = reader.word()? as usize;
    let encoded = reader.take(length.min(MAX_HEADER))?;
    let (found, used): (Header, usize) =
        bincode::serde::decode_from_slice(encoded, config()).map_err(|_| CacheFileError::Format("header"))?;
    if used != length {
        return Err(CacheFileError::Format("header"));
    }
    let wanted = header(world, policy, settings, tolerance);
    let same = [
        (found.scene == wanted.scene, "scene"),
        (found.materials == wanted.materials, "set of materials"),
        (found.method == wanted.method, "method"),
        (found.tables == wanted.tables, "set of tables"),
        (found.estimator == wanted.estimator, "estimator"),
        (found.indirect_only == wanted.indirect_only, "part of the light"),
        (found.sources == wanted.sources, "number of sources"),
    ];
    if let Some((_, what)) = same.into_iter().find(|(same, _)| !same) {
        return Err(CacheFileError::Stale(what));
    }
    let (min, max) = world.bounds();
    let mut caches = Caches::new(min, max);
    for _ in 0..found.coarse {
        caches.coarse.insert(reader.irradiance()?);
    }
    for _ in 0..found.irradiance {
        caches.irradiance.insert(reader.irradiance()?);
    }
    let materials = world.scene.materials.len() as u32;
    for _ in 0..found.eas {
        caches.eas.insert(reader.eas(materials)?);
    }
    for _ in 0..found.harmonics {
        caches.harmonics.insert(reader.harmonics(materials)?);
    }
    if reader.bytes.len() != 4 {
        return Err(CacheFileError::Format("bytes left over"));
    }
    let complete =
        found.camera == wanted.camera && found.tolerance == wanted.tolerance && found.spacing == wanted.spacing;
    Ok(Loaded { caches, complete })
}

struct Reader<'a> {
    bytes: &'a [u8],
}

impl<'a> Reader<'a> {
    fn take(&mut self, n: usize) -> Result<&'a [u8], CacheFileError> {
        let (head, rest) = self.bytes.split_at_checked(n).ok_or(CacheFileError::Format("it is truncated"))?;
        self.bytes = rest;
        Ok(head)
    }

    fn word(&mut self) -> Result<u32, CacheFileError> {
        Ok(u32::from_le_bytes(self.take(4)?.try_into().expect("four bytes")))
    }

    /// N finite numbers.
    fn numbers<const N: usize>(&mut self) -> Result<[f32; N], CacheFileError> {
        let mut numbers = [0.0; N];
        for x in &mut numbers {
            *x = f32::from_bits(self.word()?);
            if !x.is_finite() {
                return Err(CacheFileError::Format("a number is not finite"));
            }
        }
        Ok(numbers)
    }

    fn irradiance(&mut self) -> Result<IrradianceRecord, CacheFileError> {
        Ok(IrradianceRecord::from_numbers(self.numbers()?))
    }

    fn eas(&mut self, materials: u32) -> Result<EasRecord, CacheFileError> {
        let [px, py, pz, nx, ny, nz, radius, r, g, b] = self.numbers()?;
        let (material, count) = (self.word()?, self.word()?);
        if material >= materials {
            return Err(CacheFileError::Format("a record of no material"));
        }
        let bytes = self.take(count as usize * size_of::<Eas>())?;
        let sources = bytes.chunks_exact(size_of::<Eas>()).map(|b| Eas::from_bytes(b.try_into().expect("40 bytes")));
        let sources: Option<Box<[Eas]>> = sources.collect();
        let sources = sources.ok_or(CacheFileError::Format("a number is not finite"))?;
        Ok(EasRecord::restored([px, py, pz], [nx, ny, nz], radius, material, [r, g, b], sources))
    }

    fn harmonics(&mut self, materials: u32) -> Result<HarmonicsRecord, CacheFileError> {
        let vectors: [f32; 12] = self.numbers()?;
        let [radius] = self.numbers()?;
        let (material, order, count) = (self.word()?, self.word()?, self.word()?);
        if material >= materials {
            return Err(CacheFileError::Format("a record of no material"));
        }
        let bytes = self.take(count as usize * size_of::<f32>())?;
        let numbers: Box<[f32]> =
            bytes.chunks_exact(4).map(|b| f32::from_le_bytes(b.try_into().expect("four bytes"))).collect();
        if numbers.iter().any(|x| !x.is_finite()) {
            return Err(CacheFileError::Format("a number is not finite"));
        }
        let vector = |i: usize| Vec3A::from_slice(&vectors[3 * i..]);
        let frame = Frame::from_axes(vector(1), vector(2), vector(3));
        HarmonicsRecord::restored(vector(0), frame, radius, material, order, numbers)
            .ok_or(CacheFileError::Format("a record of no order"))
    }
}
