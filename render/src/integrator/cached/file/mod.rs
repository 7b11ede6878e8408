//! Caches on disk: a rendering that goes on from one gives the same picture, a moved camera adds what it needs.
//!
//! Little-endian: magic (8 bytes), version and header length (u32), header (bincode, at most 64 KiB), records, CRC-32 of all
//! before it. Irradiance records are 28 f32, the coarse ones first; then come the records of each kind, as its `file.rs`
//! says.

mod error;
mod header;
mod info;
mod lock;
mod mark;
mod merge;
mod reader;

use super::Settings;
use super::caches::Caches;
pub use super::caches::Loaded;
use super::kinds::{self, EachKind, GlossyCaches, Listed};
use super::policy::Policy;
use crate::record::irradiance::IrradianceRecord;
use crate::scene::checksum::Hash;
use crate::world::World;
use core::convert::Infallible;
pub use error::CacheFileError;
use header::{Header, MAX_HEADER};
pub use info::{Info, info};
use kit::output;
pub use lock::Lock;
pub use mark::{Chosen, WalkMark};
pub use merge::{MergeError, merge};
pub use reader::{Reader, write_numbers, write_words};
use std::io::Read;
use std::path::Path;

const MAGIC: &[u8; 8] = b"BURNREC\n";
const VERSION: u32 = 7;
/// Larger files are not read.
const MAX_BYTES: u64 = 4 << 30;

/// What a cache file is made for. It takes time to find out: the checksums go over the whole scene.
#[derive(Clone, Debug)]
pub struct Key {
    header: Header,
    /// Classes of records that there may be.
    classes: u32,
}

impl Key {
    /// Of a rendering.
    pub fn new(world: &World, policy: &Policy, settings: &Settings, tolerance: f32) -> Self {
        Self { header: Header::new(world, policy, settings, tolerance), classes: policy.classes() }
    }

    /// The same for another τ.
    pub fn at(&self, tolerance: f32) -> Self {
        Self { header: self.header.at(tolerance), ..*self }
    }

    /// The same for no camera: whoever reads the file looks whether it holds what is needed.
    pub fn anywhere(&self) -> Self {
        Self { header: self.header.without_camera(), ..*self }
    }

    /// Tells whether anything but the camera is the same.
    pub fn checksum(&self) -> Result<u64, CacheFileError> {
        let mut hash = Hash::default();
        hash.bytes(&self.header.without_camera().encoded()?);
        Ok(hash.finish())
    }

    /// Writes caches: the file appears whole or not at all.
    ///
    /// # Errors
    /// A place that cannot be written.
    pub fn save(&self, path: &Path, caches: &Caches) -> Result<(), CacheFileError> {
        Ok(output::write(path, &to_bytes(&self.header, caches)?)?)
    }

    /// [`Key::save`] of caches that are being filled and will be saved again: whoever is killed leaves a whole file, a machine that
    /// loses its power may not.
    ///
    /// # Errors
    /// A place that cannot be written.
    pub fn save_draft(&self, path: &Path, caches: &Caches) -> Result<(), CacheFileError> {
        Ok(output::write_draft(path, &to_bytes(&self.header, caches)?)?)
    }

    /// Reads caches that fit the scene, its materials and tables. Allocates no more than a small multiple of the file.
    ///
    /// # Errors
    /// A file that is damaged, or that was made for something else.
    pub fn load(&self, path: &Path, world: &World) -> Result<Loaded, CacheFileError> {
        self.read(&read(path)?, world)
    }

    fn read(&self, bytes: &[u8], world: &World) -> Result<Loaded, CacheFileError> {
        let (found, mut reader) = open(bytes)?;
        found.check(&self.header)?;
        reader.materials = self.classes;
        let (min, max) = world.bounds();
        let caches = records(&found, reader, Caches::new(min, max))?;
        Ok(Loaded { caches, complete: found.is_complete(&self.header), alike: found.is_alike(&self.header) })
    }
}

/// Checksum of all records.
pub fn checksum(caches: &Caches) -> u64 {
    let (mut bytes, mut hash) = (Vec::new(), Hash::default());
    write_records(caches, &mut bytes);
    hash.bytes(&bytes);
    hash.finish()
}

/// [`Key::save`] of a rendering.
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
    Key::new(world, policy, settings, tolerance).save(path, caches)
}

/// [`Key::load`] of a rendering.
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
    Key::new(world, policy, settings, tolerance).load(path, world)
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
    Key::new(world, policy, settings, tolerance).read(bytes, world)
}

fn to_bytes(header: &Header, caches: &Caches) -> Result<Vec<u8>, CacheFileError> {
    let mut header = header.clone();
    header.count(caches);
    let encoded = header.encoded()?;
    let mut bytes = MAGIC.to_vec();
    write_words(&mut bytes, [VERSION, encoded.len() as u32]);
    bytes.extend(encoded);
    write_records(caches, &mut bytes);
    bytes.extend(crc32fast::hash(&bytes).to_le_bytes());
    Ok(bytes)
}

fn write_records(caches: &Caches, bytes: &mut Vec<u8>) {
    for record in caches.coarse.records().iter().chain(caches.irradiance.records()) {
        write_numbers(bytes, record.to_numbers());
    }
    let Ok(()) = kinds::each(&mut WriteEach { caches: &caches.glossy, bytes });
}

fn read(path: &Path) -> Result<Vec<u8>, CacheFileError> {
    let mut bytes = Vec::new();
    std::fs::File::open(path)?.take(MAX_BYTES).read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// The header of a file that is whole, and a reader of its records, who takes any material.
fn open(bytes: &[u8]) -> Result<(Header, Reader<'_>), CacheFileError> {
    let mut reader = Reader { bytes, materials: u32::MAX };
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
    Ok((Header::decoded(reader.take(length)?)?, reader))
}

/// Adds the records of a file to empty caches.
fn records(header: &Header, mut reader: Reader, mut caches: Caches) -> Result<Caches, CacheFileError> {
    for (cache, count) in [(&mut caches.coarse, header.coarse), (&mut caches.irradiance, header.irradiance)] {
        for _ in 0..count {
            cache.insert(IrradianceRecord::from_numbers(reader.numbers()?));
        }
    }
    let counts = header.glossy.iter();
    kinds::each(&mut ReadEach { caches: &mut caches.glossy, counts, reader: &mut reader })?;
    if reader.bytes.len() != 4 {
        return Err(CacheFileError::Format("bytes left over"));
    }
    caches.walk.clone_from(&header.walk);
    Ok(caches)
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
