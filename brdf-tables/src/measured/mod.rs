//! Files of measured materials, read to functions of two directions and from there to [`Measured`](crate::brdf::Measured).
//!
//! One format a file: [`Format`] lists them. Sizes are checked against the length of the file before memory is taken, numbers
//! must be finite; an error names the place. What a file leaves open (directions that nobody measured, colours) is filled in
//! ways that [`Reading::notes`] tells.

#[doc(hidden)]
pub mod cie;
mod cornell;
mod csv;
mod error;
mod fits;
mod lines;
mod merl;
mod openpbr;
pub mod rgl;
mod scattered;
pub mod shape;
mod spectrum;

use crate::brdf::{Built, build};
use glam::DVec3;
use std::path::Path;

pub use error::{Place, ReadError};

/// A kind of file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// `.binary`: MERL (Matusik et al. 2003), isotropic, half and difference angles.
    Merl,
    /// `.brdf`: text of Cornell's measurements, scattered directions, spectra.
    Cornell,
    /// `.csv`: `theta_i,theta_o,phi,r,g,b`, isotropic, scattered directions.
    Csv,
    /// `.bsdf`: the adaptive parametrisation of Dupuy and Jakob 2018.
    Rgl,
    /// `.sgd`: parameters of the shifted gamma distribution (Bagher et al. 2012).
    Sgd,
    /// `.abc`: parameters of the ABC model (Löw et al. 2012).
    Abc,
    /// `.openpbr`: parameters of OpenPBR's base, specular, coat and fuzz.
    OpenPbr,
}

/// Largest file read, bytes.
pub const MAX_BYTES: u64 = 1 << 30;

impl Format {
    /// Every format.
    pub const ALL: [Self; 7] = [Self::Merl, Self::Cornell, Self::Csv, Self::Rgl, Self::Sgd, Self::Abc, Self::OpenPbr];

    /// What names of its files end in.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Merl => "binary",
            Self::Cornell => "brdf",
            Self::Csv => "csv",
            Self::Rgl => "bsdf",
            Self::Sgd => "sgd",
            Self::Abc => "abc",
            Self::OpenPbr => "openpbr",
        }
    }

    /// The format that a name ends in.
    pub fn of(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_str()?.to_lowercase();
        Self::ALL.into_iter().find(|format| format.extension() == extension)
    }
}

/// f_r as a function that a file gives.
pub trait Source: Send + Sync {
    /// f_r in sr⁻¹, RGB, without the cosine, of two directions above the horizon; `None` where the file does not say.
    fn rgb(&self, wi: DVec3, wo: DVec3) -> Option<[f64; 3]>;
    /// Whether the function is the same for both mirror images and for exchanged directions.
    fn is_folded(&self) -> bool;
}

/// What was read.
pub struct Reading {
    /// Its format.
    pub format: Format,
    /// The function.
    pub source: Box<dyn Source>,
    /// Lines about what the file holds, and what was made of what it does not.
    pub notes: Vec<String>,
}

impl Reading {
    /// Reads a file by what its name ends in.
    ///
    /// # Errors
    /// What is wrong with the file, in one line that names it and the place.
    #[cfg(feature = "fs")]
    pub fn load(path: &Path) -> Result<Self, ReadError> {
        let (format, bytes) = Self::bytes(path)?;
        Self::from_bytes(format, &bytes).map_err(|e| e.within(path))
    }

    /// The format and the bytes of a file, whose size is checked before memory is taken.
    ///
    /// # Errors
    /// What is wrong with the file, in one line that names it and the place.
    #[cfg(feature = "fs")]
    pub fn bytes(path: &Path) -> Result<(Format, Vec<u8>), ReadError> {
        let fail = |what: String| ReadError::new(Place::File, what).within(path);
        let format = Format::of(path).ok_or_else(|| {
            let known = Format::ALL.map(|f| format!(".{}", f.extension())).join(", ");
            fail(format!("measured data end in {known}"))
        })?;
        let metadata = std::fs::metadata(path).map_err(|e| fail(e.to_string()))?;
        if !metadata.is_file() {
            return Err(fail("not a regular file".into()));
        }
        if metadata.len() > MAX_BYTES {
            return Err(fail(format!("{} bytes, at most {MAX_BYTES} are read", metadata.len())));
        }
        let head = |bytes: usize| {
            use std::io::Read;
            let mut head = Vec::new();
            let file = std::fs::File::open(path).map_err(|e| fail(e.to_string()))?;
            file.take(bytes as u64).read_to_end(&mut head).map_err(|e| fail(e.to_string()))?;
            Ok::<_, ReadError>(head)
        };
        // The sizes of a binary file stand in its first bytes: a wrong one is refused before the rest is read.
        if format == Format::Merl {
            merl::check(&head(12)?, metadata.len()).map_err(|e| e.within(path))?;
        }
        Ok((format, head(metadata.len() as usize)?))
    }

    /// Reads the bytes of a file.
    ///
    /// # Errors
    /// What is wrong with them.
    pub fn from_bytes(format: Format, bytes: &[u8]) -> Result<Self, ReadError> {
        match format {
            Format::Merl => merl::read(bytes),
            Format::Cornell => cornell::read(bytes),
            Format::Csv => csv::read(bytes),
            Format::Rgl => rgl::reading(bytes),
            Format::Sgd => fits::sgd(bytes),
            Format::Abc => fits::abc(bytes),
            Format::OpenPbr => openpbr::read(bytes),
        }
    }

    /// The material, as the renderer and tables have it.
    ///
    /// # Errors
    /// The values make none.
    pub fn material(&self, name: &str) -> Result<Built, ReadError> {
        let built = build(name, self.source.is_folded(), |wi, wo| self.source.rgb(wi, wo));
        built.map_err(|e| ReadError::new(Place::File, e.to_string()))
    }
}

/// Reads a file and makes its material, named as the file is.
///
/// # Errors
/// As [`Reading::load`] and [`Reading::material`].
#[cfg(feature = "fs")]
pub fn load(path: &Path) -> Result<(Reading, Built), ReadError> {
    let reading = Reading::load(path)?;
    let name = path.file_name().and_then(|n| n.to_str()).unwrap_or("measured");
    let built = reading.material(name).map_err(|e| e.within(path))?;
    Ok((reading, built))
}
