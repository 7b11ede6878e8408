//! What can go wrong.

use std::path::PathBuf;

/// Why a picture cannot be denoised.
#[derive(Debug, thiserror::Error)]
pub enum DenoiseError {
    /// The system knows no Open Image Denoise.
    #[error(
        "Open Image Denoise is not installed: get it with `pip download --no-deps pyoidn && python3 -m zipfile -e pyoidn-*.whl oidn`, \
         then give --oidn oidn/pyoidn/oidn/lib (or set OIDN_LIBRARY); --denoise builtin needs nothing"
    )]
    NotFound,
    /// A folder without it.
    #[error("{}: the folder holds no Open Image Denoise ({})", .0.display(), .1)]
    NotInFolder(PathBuf, &'static str),
    /// A file that is not there.
    #[error("{}: there is no such file or folder", .0.display())]
    Missing(PathBuf),
    /// A library that cannot be loaded, or another one.
    #[error("{}: {reason}", .path.display())]
    Library {
        /// Its file.
        path: PathBuf,
        /// What the system or the library says.
        reason: String,
    },
    /// It was loaded, and failed at work.
    #[error("Open Image Denoise failed: {0}")]
    Failed(String),
    /// The crate was built without the feature `oidn`.
    #[error("Open Image Denoise is not supported: the feature `oidn` was left out when the program was built")]
    NotBuilt,
}
