//! What a cache file says of itself.

use super::super::kinds::KINDS;
use super::{CacheFileError, WalkMark, open, read};
use serde::Serialize;
use std::path::Path;

/// What a cache file says of itself.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Info {
    /// Bytes of the file.
    pub bytes: u64,
    /// τ of its records.
    pub tau: f32,
    /// Coarse irradiance records.
    pub coarse: u64,
    /// Irradiance records.
    pub irradiance: u64,
    /// Glossy records, by kind.
    pub glossy: Vec<(&'static str, u64)>,
    /// The walk for which it was filled.
    pub walk: Option<WalkMark>,
}

impl Info {
    /// Records of all kinds.
    pub fn records(&self) -> u64 {
        self.coarse + self.irradiance + self.glossy.iter().map(|(_, count)| count).sum::<u64>()
    }
}

/// Reads what a whole cache file says of itself.
///
/// # Errors
/// A file that is damaged, or that is no cache.
pub fn info(path: &Path) -> Result<Info, CacheFileError> {
    let bytes = read(path)?;
    let (header, _) = open(&bytes)?;
    let glossy = KINDS.iter().zip(header.glossy).map(|(kind, count)| (kind.name, count));
    Ok(Info {
        bytes: bytes.len() as u64,
        tau: header.tolerance,
        coarse: header.coarse,
        irradiance: header.irradiance,
        glossy: glossy.collect(),
        walk: header.walk,
    })
}
