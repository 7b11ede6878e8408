//! Emitters.

use super::{Bitmap, ColorTexture, Rgb};
use glam::{Mat3A, Vec3A};
use serde::{Deserialize, Serialize};

/// Diffuse emission from the front of a shape.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AreaEmitter {
    /// Radiance in W·m⁻²·sr⁻¹.
    pub radiance: ColorTexture,
}

/// A light without a surface.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Light {
    /// Radiates equally in all directions from a point.
    Point {
        /// World position.
        position: Vec3A,
        /// Radiant intensity in W·sr⁻¹.
        intensity: Rgb,
    },
    /// Radiates into a cone; the intensity falls linearly in the angle from `beam` to `cutoff`, as Mitsuba's.
    Spot {
        /// World position.
        position: Vec3A,
        /// Unit axis of the cone, away from the light.
        direction: Vec3A,
        /// Radiant intensity on the axis in W·sr⁻¹.
        intensity: Rgb,
        /// Half angle of full intensity in radians.
        beam: f32,
        /// Half angle in radians outside which there is no light, ≥ `beam`.
        cutoff: f32,
    },
    /// Parallel light, a sun without extent.
    Directional {
        /// Unit direction in which the light travels.
        direction: Vec3A,
        /// Irradiance on a surface facing the light in W·m⁻².
        irradiance: Rgb,
    },
}

/// Radiance from infinity.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Environment {
    /// The same in all directions.
    Constant(Rgb),
    /// An image in latitude and longitude.
    Map(EnvironmentMap),
}

/// Where the rows of a latitude-longitude image lie, j being counted from the top of h.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Rows {
    /// At v = j/(h − 1), as in Mitsuba 3: the first and the last row are the poles.
    #[default]
    Poles,
    /// At v = (j + ½)/h, as in most programs: every row is a band of its own.
    Bands,
}

/// A latitude-longitude image. A unit direction d in the map's own frame (y up) has
/// u = atan2(d.x, −d.z)/2π modulo 1 and v = acos(d.y)/π. The centres of the i-th of w texels of a row are at
/// u = (i + ½)/w, and `rows` says at which v.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EnvironmentMap {
    /// Radiance before `scale`; `wrap`, `interpolation` and `to_uv` of the bitmap are not used.
    pub image: Bitmap,
    /// Rotation (a reflection is allowed) from the map's frame to the world: orthonormal columns.
    pub to_world: Mat3A,
    /// Factor on the radiance.
    pub scale: f32,
    /// Where the rows lie.
    pub rows: Rows,
}
