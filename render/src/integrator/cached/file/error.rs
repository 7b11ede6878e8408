//! What can be wrong with a cache file.

use kit::output::OutputError;

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
