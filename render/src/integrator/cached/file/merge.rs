//! Caches that were filled apart become one.

use super::super::caches::Caches;
use super::super::kinds::{self, EachKind, GlossyCaches, Listed};
use super::header::Header;
use super::{CacheFileError, open, read, records, to_bytes, write_numbers};
use crate::cache::Cache;
use crate::record::Record;
use core::convert::Infallible;
use glam::Vec3A;
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// Why caches cannot become one.
#[derive(Debug, thiserror::Error)]
pub enum MergeError {
    /// A file is of no use.
    #[error("{}: {error}", path.display())]
    File {
        /// Which.
        path: PathBuf,
        /// Why.
        error: CacheFileError,
    },
    /// Two are of different things.
    #[error("{} and {}: filled for another {what}", .paths[0].display(), .paths[1].display())]
    Other {
        /// Which.
        paths: [PathBuf; 2],
        /// What differs.
        what: &'static str,
    },
}

/// The bytes of a cache file with the records of all these, whatever their order: those of the file that is filled for the earliest
/// frames of a walk come first. A record that is in several files, because they began with the same one, comes once, and
/// reaches as far as where it reaches least.
///
/// # Errors
/// Files that are damaged, or that were not made for the same scene with the same settings.
pub fn merge(paths: &[PathBuf]) -> Result<Vec<u8>, MergeError> {
    let failed = |path: &Path, error| MergeError::File { path: path.into(), error };
    let mut files = Vec::with_capacity(paths.len());
    for path in paths {
        files.push((path, read(path).map_err(|e| failed(path, e))?));
    }
    let mut parts: Vec<(&PathBuf, Header, Caches)> = Vec::with_capacity(files.len());
    let mut orders = Vec::with_capacity(files.len());
    for (path, bytes) in &files {
        // Bounds of the scene are not known here, nor is any record looked for.
        let empty = Caches::new(Vec3A::splat(-1.0), Vec3A::ONE);
        let (header, caches) = open(bytes)
            .and_then(|(header, reader)| records(&header, reader, empty).map(|caches| (header, caches)))
            .map_err(|e| failed(path, e))?;
        if let Some((first, expected, _)) = parts.first()
            && let Some(what) = difference(&header, expected)
        {
            return Err(MergeError::Other { paths: [first.to_path_buf(), path.to_path_buf()], what });
        }
        let begins = header.walk.as_ref().and_then(|walk| walk.filled.first().copied());
        orders.push((begins.is_none(), begins, bytes));
        parts.push((path, header, caches));
    }
    let mut order: Vec<usize> = (0..parts.len()).collect();
    order.sort_by(|a, b| orders[*a].cmp(&orders[*b]));
    let sorted: Vec<&Caches> = order.iter().map(|i| &parts[*i].2).collect();
    let mut all = Caches::new(Vec3A::splat(-1.0), Vec3A::ONE);
    join(&mut all.coarse, sorted.iter().map(|c| &c.coarse), |r, bytes| write_numbers(bytes, r.to_numbers()));
    join(&mut all.irradiance, sorted.iter().map(|c| &c.irradiance), |r, bytes| write_numbers(bytes, r.to_numbers()));
    let Ok(()) = kinds::each(&mut JoinEach { from: &sorted, to: &mut all.glossy });
    // The mark of a walk, if all files have one.
    all.walk = sorted.first().and_then(|first| first.walk.clone());
    for other in &sorted {
        all.walk = all.walk.zip(other.walk.as_ref()).map(|(mut walk, other)| {
            walk.join(other);
            walk
        });
    }
    let (path, header, _) = &parts[order[0]];
    to_bytes(header, &all).map_err(|e| failed(path, e))
}

/// What keeps two files from becoming one.
fn difference(a: &Header, b: &Header) -> Option<&'static str> {
    if let Err(CacheFileError::Stale(what)) = a.check(b) {
        return Some(what);
    }
    if !a.is_alike(b) {
        return Some("tau, or with another spacing");
    }
    let paths = a.walk.as_ref().zip(b.walk.as_ref());
    paths.is_some_and(|(a, b)| (a.path, a.frames) != (b.path, b.frames)).then_some("path of a walk")
}

/// Adds records, each once.
fn join<'a, R: Record + Clone + 'a>(
    to: &mut Cache<R>,
    from: impl Iterator<Item = &'a Cache<R>>,
    write: impl Fn(&R, &mut Vec<u8>),
) {
    let mut known: HashMap<Vec<u8>, usize> = HashMap::new();
    let mut all: Vec<R> = Vec::new();
    for record in from.flat_map(|cache| cache.records()) {
        let mut key = Vec::new();
        let mut alone = record.clone();
        alone.set_radius(1.0);
        write(&alone, &mut key);
        match known.get(&key) {
            Some(&i) => {
                let least = all[i].radius().min(record.radius());
                all[i].set_radius(least);
            }
            None => {
                known.insert(key, all.len());
                all.push(record.clone());
            }
        }
    }
    all.into_iter().for_each(|record| to.insert(record));
}

struct JoinEach<'a> {
    from: &'a [&'a Caches],
    to: &'a mut GlossyCaches,
}

impl EachKind for JoinEach<'_> {
    type Error = Infallible;

    fn run<K: Listed>(&mut self) -> Result<(), Infallible> {
        join(K::cache_mut(self.to), self.from.iter().map(|c| K::cache(&c.glossy)), K::write);
        Ok(())
    }
}
