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

/// How the intensity of a spot falls from 1 at the angle `beam` to 0 at `cutoff`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Falloff {
    /// Linearly in the angle, as Mitsuba's.
    #[default]
    Linear,
    /// As the square of what is linear in the cosine, which glTF recommends (KHR_lights_punctual).
    Cosine,
    /// As 3t² − 2t³, t being linear in the cosine: Blender's.
    Smooth,
}

impl Falloff {
    /// The share of the intensity at `angle` from the axis; angles in radians.
    #[inline]
    pub fn share(self, angle: f32, beam: f32, cutoff: f32) -> f32 {
        // 1 − cos x is 2 sin² ½x, which keeps its digits where x is small.
        let versine = |x: f32| (0.5 * x).sin().powi(2);
        let linear = |of: f32, from: f32, to: f32| ((to - of) / (to - from).max(f32::MIN_POSITIVE)).clamp(0.0, 1.0);
        let t = linear(versine(angle), versine(beam), versine(cutoff));
        match self {
            Self::Linear => ((cutoff - angle) / (cutoff - beam).max(1e-6)).clamp(0.0, 1.0),
            Self::Cosine => t * t,
            Self::Smooth => t * t * (3.0 - 2.0 * t),
        }
    }
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
    /// Radiates into a cone; the intensity falls from `beam` to `cutoff`.
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
        /// How it falls between both.
        falloff: Falloff,
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spots_fall_from_one_to_nothing() {
        for (beam, cutoff) in [(0.3f32, 0.6f32), (0.0, 1.5), (0.5, 0.5), (1e-4, 2e-4), (0.0, 0.0)] {
            for falloff in [Falloff::Linear, Falloff::Cosine, Falloff::Smooth] {
                let share = |angle| falloff.share(angle, beam, cutoff);
                assert_eq!(
                    (share(1.001 * cutoff + 1e-5), beam == cutoff || share(beam) == 1.0),
                    (0.0, true),
                    "{falloff:?}"
                );
                let middle = share(0.5 * (beam + cutoff));
                assert!(beam == cutoff || (0.01..=0.99).contains(&middle), "{falloff:?} {middle}");
            }
        }
        // Half way in the cosine.
        let half = (0.5 * (0.3f32.cos() + 0.6f32.cos())).acos();
        assert!((Falloff::Cosine.share(half, 0.3, 0.6) - 0.25).abs() < 1e-5);
        assert!((Falloff::Smooth.share(half, 0.3, 0.6) - 0.5).abs() < 1e-5);
        assert!((Falloff::Linear.share(0.4, 0.3, 0.6) - 2.0 / 3.0).abs() < 1e-5);
    }
}
