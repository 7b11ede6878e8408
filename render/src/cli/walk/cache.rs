//! The cache file of a walk: read, kept while it is filled, and saved.

use super::task::Task;
use anyhow::{Result, anyhow, ensure};
use render::integrator::cached::Caches;
use render::integrator::cached::file::{CacheFileError, Key, Lock};
use std::path::Path;
use std::time::{Duration, Instant};

/// Largest share of the time of a fill that goes into keeping what is filled so far.
const SAVING_SHARE: f64 = 0.1;

/// The cache file of a walk, locked against others that would fill it.
pub(super) struct Kept<'a> {
    path: Option<&'a Path>,
    _lock: Option<Lock>,
    /// When what is filled so far was kept, and how long that took.
    drafted: (Instant, Duration),
}

impl<'a> Kept<'a> {
    /// `read_only` takes no lock: the file is whole at any time.
    pub fn open(path: Option<&'a Path>, read_only: bool) -> Result<Self> {
        let lock = |path: &Path| {
            let wait = || eprintln!("render: {}: another process is filling it: waiting", path.display());
            Lock::of(path, wait).map_err(|e| anyhow!("{}: no lock: {e}", path.display()))
        };
        let lock = path.filter(|_| !read_only).map(lock).transpose()?;
        Ok(Self { path, _lock: lock, drafted: (Instant::now(), Duration::ZERO) })
    }

    /// The records of the file, if there is one, and whether they were made at the same τ.
    pub fn read(&self, key: &Key, task: &Task) -> Result<(Caches, bool)> {
        let Some(path) = self.path.filter(|path| task.args.frames_only || path.exists()) else {
            return Ok((task.empty(), false));
        };
        let loaded = key.load(path, &task.world).map_err(|e: CacheFileError| anyhow!("{}: {e}", path.display()))?;
        let mark = loaded.caches.walk.as_ref();
        let same = mark.is_some_and(|mark| mark.path == task.walk.checksum());
        if task.args.frames_only {
            let place = path.display();
            ensure!(same, "{place}: the cache was not filled for this path and film");
            ensure!(loaded.alike, "{place}: the cache was filled at another tau, or with another spacing");
            ensure!(
                mark.is_some_and(|mark| mark.is_complete()),
                "{place}: the cache is filled for a part of the path only: fill the rest, or merge the parts"
            );
        }
        let mut caches = loaded.caches;
        if !loaded.alike {
            // What was filled so was filled for something else.
            caches.walk = None;
        }
        Ok((caches, same && loaded.alike))
    }

    /// Keeps what is filled so far, but where that would take too much of the time.
    pub fn stage(&mut self, key: &Key, caches: &Caches) -> Result<()> {
        let (when, took) = self.drafted;
        let Some(path) = self.path.filter(|_| took <= when.elapsed().mul_f64(SAVING_SHARE)) else { return Ok(()) };
        let start = Instant::now();
        key.save_draft(path, caches).map_err(|e| anyhow!("{}: {e}", path.display()))?;
        self.drafted = (Instant::now(), start.elapsed());
        Ok(())
    }

    /// Writes the file.
    pub fn save(&self, key: &Key, caches: &Caches) -> Result<()> {
        let Some(path) = self.path else { return Ok(()) };
        key.save(path, caches).map_err(|e| anyhow!("{}: {e}", path.display()))
    }
}
