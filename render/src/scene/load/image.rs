//! Images of scenes, by the reader of all pictures: each decoded once, and many of them at a time.

use super::error::{FileError, read_file};
use crate::image::{self, ImageError, Pixels, Raster};
use std::collections::{HashMap, HashSet};
use std::hash::Hash;
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, OnceLock};

/// Larger image files are refused.
const MAX_FILE: u64 = 1 << 31;

/// Reads an image file, recognised by its first bytes.
pub fn read(path: &Path) -> Result<Pixels, FileError> {
    decode(&read_file(path, MAX_FILE)?, path)
}

/// Decodes an image in memory; `path` serves error messages only.
pub fn decode(bytes: &[u8], path: &Path) -> Result<Pixels, FileError> {
    image::decode(bytes, path).map_err(|error| match error {
        ImageError::Content { reason, .. } => FileError::new(path, reason),
        other => FileError::new(path, other),
    })
}

/// An image that textures share.
#[derive(Clone, Debug)]
pub struct Decoded {
    /// Its pixels.
    pub raster: Arc<Raster>,
    /// What the file left open: one line each.
    pub warnings: Arc<[String]>,
}

impl From<Pixels> for Decoded {
    fn from(pixels: Pixels) -> Self {
        Self { raster: Arc::new(pixels.raster), warnings: pixels.warnings.into() }
    }
}

type Outcome = Result<Decoded, FileError>;

/// The images of a scene by what names them.
pub struct Images<K> {
    done: HashMap<K, Outcome>,
    skip_missing: bool,
}

impl<K: Clone + Eq + Hash + Send + Sync> Images<K> {
    /// None yet. With `skip_missing`, a file that is not there is no reason to stop.
    pub fn new(skip_missing: bool) -> Self {
        Self { done: HashMap::new(), skip_missing }
    }

    /// Decodes images that will be asked for, one per thread at a time, so that what decoding takes besides the pixels
    /// stays within bounds. Ends at the first error, which is told to who asks for that image; later ones wait until then.
    pub fn announce(
        &mut self,
        keys: impl IntoIterator<Item = K>,
        read: impl Fn(&K) -> Result<Pixels, FileError> + Sync,
    ) {
        let mut known = HashSet::new();
        let keys: Vec<K> = keys.into_iter().filter(|key| known.insert(key.clone())).collect();
        let outcomes: Vec<OnceLock<Outcome>> = keys.iter().map(|_| OnceLock::new()).collect();
        let (next, failed) = (AtomicUsize::new(0), AtomicBool::new(false));
        // Every thread takes the next image of the list. Parallel iterators would begin other images within the one at
        // hand, when that waits for blocks of its own.
        rayon::broadcast(|_| {
            while !failed.load(Ordering::Relaxed) {
                let i = next.fetch_add(1, Ordering::Relaxed);
                let Some(key) = keys.get(i) else { break };
                let outcome = read(key).map(Decoded::from);
                if outcome.as_ref().is_err_and(|e| !(e.missing && self.skip_missing)) {
                    failed.store(true, Ordering::Relaxed);
                }
                let _ = outcomes[i].set(outcome);
            }
        });
        let decoded = keys.into_iter().zip(outcomes).filter_map(|(key, outcome)| Some((key, outcome.into_inner()?)));
        self.done.extend(decoded);
    }

    /// Whether an image was asked for, or announced, and is there.
    pub fn holds(&self, key: &K) -> bool {
        matches!(self.done.get(key), Some(Ok(_)))
    }

    /// An image, decoded now if it was not before.
    pub fn get(&mut self, key: &K, read: impl FnOnce(&K) -> Result<Pixels, FileError>) -> Outcome {
        self.done.entry(key.clone()).or_insert_with(|| read(key).map(Decoded::from)).clone()
    }
}
