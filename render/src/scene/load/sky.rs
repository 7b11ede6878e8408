//! A sky from outside, for files that have none.

use super::error::FileError;
use super::image;
use crate::image::Image;
use crate::scene::{Bitmap, Environment, EnvironmentMap, Interpolation, Rgb, Rows, Texels, Wrap};
use core::f32::consts::FRAC_PI_2;
use glam::{Affine2, Mat3A};
use std::fmt;
use std::path::{Path, PathBuf};

/// Where the radiance of a [`Sky`] comes from.
#[derive(Clone, Debug, PartialEq)]
pub enum SkySource {
    /// The same from everywhere: linear RGB in W·m⁻²·sr⁻¹.
    Color([f32; 3]),
    /// A latitude-longitude picture in any format that [`crate::image::read`] reads: radiance where it is made for
    /// light (OpenEXR, Radiance HDR), sRGB where it is made for display (PNG, JPEG).
    Picture(PathBuf),
}

impl fmt::Display for SkySource {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Color([r, g, b]) => write!(f, "{r},{g},{b}"),
            Self::Picture(path) => path.display().fmt(f),
        }
    }
}

/// Light from infinity for a file without any.
///
/// A picture lies as Blender's world does after Blender's glTF export (y up): its top is +y, its middle +x, its left and
/// right ends −x; the middle of its left half is −z (Blender's +Y), that of its right half +z (Blender's −Y).
#[derive(Clone, Debug, PartialEq)]
pub struct Sky {
    /// The radiance.
    pub source: SkySource,
    /// Factor on it, ≥ 0.
    pub scale: f32,
    /// Angle in radians by which a picture is turned about the y axis, counter-clockwise as seen from above.
    pub turn: f32,
}

impl Sky {
    /// The environment, and what its file left open.
    pub(super) fn environment(&self, warnings: &mut Vec<String>) -> Result<Environment, FileError> {
        match &self.source {
            SkySource::Color(c) => {
                let radiance = Rgb::from_array(*c) * self.scale;
                let finite = radiance.is_finite() && radiance.min_element() >= 0.0;
                let error = || FileError::new(Path::new("--env"), "a radiance that is negative or not finite");
                if finite { Ok(Environment::Constant(radiance)) } else { Err(error()) }
            }
            SkySource::Picture(path) => self.map(path, warnings).map(Environment::Map),
        }
    }

    fn map(&self, path: &Path, warnings: &mut Vec<String>) -> Result<EnvironmentMap, FileError> {
        let mut pixels = image::read(path)?;
        let mut warn = |what: String| warnings.push(format!("{}: {what}", path.display()));
        std::mem::take(&mut pixels.warnings).into_iter().for_each(&mut warn);
        let Image { width, height, pixels: mut texels } = pixels.into();
        if width != 2 * height {
            warn(format!("{width} × {height} pixels, where a latitude-longitude picture is twice as wide as high"));
        }
        // Resampled high dynamic range images often ring below zero.
        let negative = texels.iter_mut().flatten().filter(|c| **c < 0.0).map(|c| *c = 0.0).count();
        if negative > 0 {
            warn(format!("{negative} negative values became 0"));
        }
        let brightest = texels.iter().flatten().fold(0.0f32, |most, c| most.max(*c));
        if !(brightest * self.scale).is_finite() {
            return Err(FileError::new(path, format_args!("its radiance times {} is not finite", self.scale)));
        }
        let image = Bitmap {
            width,
            height,
            texels: Texels::Rgb(texels),
            wrap: [Wrap::Repeat; 2],
            second_uv: false,
            interpolation: Interpolation::Bilinear,
            to_uv: Affine2::IDENTITY,
        };
        // The middle of a map is +z in its own frame.
        let to_world = Mat3A::from_rotation_y(FRAC_PI_2 + self.turn);
        Ok(EnvironmentMap { image, to_world, scale: self.scale, rows: Rows::Bands })
    }
}
