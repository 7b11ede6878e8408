//! Caches on disk: a rendering that goes on from one gives the same picture, a moved camera adds what it needs.
//!
//! Little-endian: magic (8 bytes), version and header length (u32), header (bincode, at most 64 KiB), records, CRC-32 of all
//! before it. Irradiance records are 28 f32, the coarse ones first; then come the records of each kind, as its `file.rs`
//! says.

mod error;
mod header;
mod reader;

use super::Settings;
use super::caches::Caches;
pub use super::caches::Loaded;
use super::kinds::{self, EachKind, GlossyCaches, Listed};
use super::policy::Policy;
use crate::record::irradiance::IrradianceRecord;
use crate::world::World;
use core::convert::Infallible;
pub use error::CacheFileError;
use header::{Header, MAX_HEADER};
use kit::output;
pub use reader::{Reader, write_numbers, write_words};
use std::io::Read;
use std::path::Path;

const MAGIC: &[u8; 8] = b"BURNREC\n";
const VERSION: u32 = 5;
/// Larger files are not read.
const MAX_BYTES: u64 = 4 << 30;

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
    let mut header = Header::new(world, policy, settings, tolerance);
    header.coarse = caches.coarse.records().len() as u64;
    header.irradiance = caches.irradiance.records().len() as u64;
    for (count, kind) in header.glossy.iter_mut().zip(caches.glossy.figures().iter()) {
        *count = kind.records as u64;
    }
    let encoded = header.encoded()?;
    let mut bytes = MAGIC.to_vec();
    write_words(&mut bytes, [VERSION, encoded.len() as u32]);
    bytes.extend(encoded);
    for record in caches.coarse.records().iter().chain(caches.irradiance.records()) {
        write_numbers(&mut bytes, record.to_numbers());
    }
    let Ok(()) = kinds::each(&mut WriteEach { caches: &caches.glossy, bytes: &mut bytes });
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
    let mut reader = Reader { bytes, materials: world.scene.materials.len() as u32 };
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
    if length > MAX_HEADER {
        return Err(CacheFileError::Format("header"));
    }
    let found = Header::decoded(reader.take(length)?)?;
    let wanted = Header::new(world, policy, settings, tolerance);
    found.check(&wanted)?;
    let (min, max) = world.bounds();
    let mut caches = Caches::new(min, max);
    for (cache, count) in [(&mut caches.coarse, found.coarse), (&mut caches.irradiance, found.irradiance)] {
        for _ in 0..count {
            cache.insert(IrradianceRecord::from_numbers(reader.numbers()?));
        }
    }
    let counts = found.glossy.iter();
    kinds::each(&mut ReadEach { caches: &mut caches.glossy, counts, reader: &mut reader })?;
    if reader.bytes.len() != 4 {
        return Err(CacheFileError::Format("bytes left over"));
    }
    Ok(Loaded { caches, complete: found.is_complete(&wanted) })
}

struct WriteEach<'a> {
    caches: &'a GlossyCaches,
    bytes: &'a mut Vec<u8>,
}

impl EachKind for WriteEach<'_> {
    type Error = Infallible;

    fn run<K: Listed>(&mut self) -> Result<(), Infallible> {
        K::cache(self.caches).records().iter().for_each(|record| K::write(record, self.bytes));
        Ok(())
    }
}

struct ReadEach<'a, 'b> {
    caches: &'a mut GlossyCaches,
    /// Records of the kinds that are left.
    counts: core::slice::Iter<'a, u64>,
    reader: &'a mut Reader<'b>,
}

impl EachKind for ReadEach<'_, '_> {
    type Error = CacheFileError;

    fn run<K: Listed>(&mut self) -> Result<(), CacheFileError> {
        for _ in 0..self.counts.next().copied().unwrap_or(0) {
            K::cache_mut(self.caches).insert(K::read(self.reader)?);
        }
        Ok(())
    }
}
