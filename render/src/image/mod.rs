//! Pictures in memory and in files.

#[cfg(feature = "formats")]
mod layers;
#[cfg(feature = "formats")]
mod note;
mod raster;
#[cfg(feature = "formats")]
mod read;
#[cfg(feature = "formats")]
mod screen;
pub mod view;
#[cfg(feature = "formats")]
mod write;

use crate::picture::Picture;

#[cfg(feature = "formats")]
pub use layers::Part;
#[cfg(feature = "formats")]
pub use note::read_note;
pub use raster::{Channels, Raster, Samples, half};
#[cfg(feature = "formats")]
pub use read::{Pixels, Window, Windows, decode, read, read_noise, read_pixels};
#[cfg(feature = "formats")]
pub use screen::{Format, jpeg, write_png};
#[cfg(feature = "formats")]
pub use write::{Look, write_picture, write_whole};

pub use crate::color::{from_srgb, to_srgb};

/// Linear RGB, row by row from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// `width · height` pixels.
    pub pixels: Vec<[f32; 3]>,
}

impl Picture {
    /// The whole light, as a picture: without its noise where that has been taken away.
    pub fn image(&self) -> Image {
        let scale = 1.0 / self.spp.max(1) as f32;
        let noisy = || self.pixels.iter().map(|p| (p.sum().sum() * scale).to_array()).collect();
        Image { width: self.width, height: self.height, pixels: self.denoised.clone().unwrap_or_else(noisy) }
    }
}

/// A picture with the variance of every pixel's mean, as its own rendering estimated it.
#[derive(Clone, Debug, PartialEq)]
pub struct Noise {
    /// Variance of the mean, by pixel and channel.
    pub variance: Image,
    /// Samples per pixel behind it.
    pub spp: u32,
}

/// Why a picture could not be read or written.
#[cfg(feature = "formats")]
#[derive(Debug, thiserror::Error)]
pub enum ImageError {
    /// It cannot be read.
    #[error("{path}: {error}")]
    Io {
        /// The file.
        path: String,
        /// What it said; no `source`, which would be printed twice.
        error: std::io::Error,
    },
    /// It cannot be written.
    #[error(transparent)]
    Output(#[from] kit::output::OutputError),
    /// The content is broken or too large.
    #[error("{path}: {reason}")]
    Content {
        /// The file.
        path: String,
        /// What is wrong.
        reason: String,
    },
    /// No format that is written.
    #[error("{0}: the name must end in {1}")]
    Extension(String, &'static str),
}
