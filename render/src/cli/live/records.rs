//! The file in which a view keeps its records.

use anyhow::{Result, anyhow};
use render::integrator::cached::file::{CacheFileError, Key, Lock};
use render::integrator::cached::policy::Policy;
use render::integrator::cached::{Caches, Settings};
use render::world::World;
use std::path::{Path, PathBuf};

/// Records of a file, which nobody else fills meanwhile.
#[derive(Default)]
pub(super) struct Records {
    file: Option<(PathBuf, Key, Lock)>,
    caches: Option<Caches>,
    /// How many there were.
    count: usize,
}

impl Records {
    /// Reads a file, where it is.
    ///
    /// # Errors
    /// A file that is damaged, or was made for something else; a folder in which no lock can be made.
    pub fn open(path: &Path, world: &World, policy: &Policy, settings: &Settings, tolerance: f32) -> Result<Self> {
        let wait = || eprintln!("render: {}: another process is filling it: waiting", path.display());
        let lock = Lock::of(path, wait).map_err(|e| anyhow!("{}: no lock: {e}", path.display()))?;
        let key = Key::new(world, policy, settings, tolerance);
        let load = || key.load(path, world).map_err(|e: CacheFileError| anyhow!("{}: {e}", path.display()));
        let loaded = if path.exists() { Some(load()?) } else { None };
        if loaded.as_ref().is_some_and(|loaded| !loaded.alike) {
            return Err(anyhow!("{}: the records were made at another tau, or with another spacing", path.display()));
        }
        let caches = loaded.map(|loaded| loaded.caches);
        let count = caches.as_ref().map_or(0, Caches::records);
        Ok(Self { file: Some((path.into(), key, lock)), caches, count })
    }

    /// What was read.
    pub fn take(&mut self) -> Option<Caches> {
        self.caches.take()
    }

    /// Writes what there is, if anything came to it.
    ///
    /// # Errors
    /// A place that cannot be written.
    pub fn save(&self, mut caches: Caches) -> Result<()> {
        let Some((path, key, _)) = self.file.as_ref().filter(|_| caches.records() != self.count) else {
            return Ok(());
        };
        // More records are there than were made for a walk.
        caches.walk = None;
        caches.refile();
        key.anywhere().save(path, &caches).map_err(|e| anyhow!("{}: {e}", path.display()))?;
        eprintln!("render: {}: {} records kept", path.display(), caches.records());
        Ok(())
    }
}
