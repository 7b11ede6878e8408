//! Scenes in which nothing shines.

use crate::scene::{ColorTexture, Environment, Light, Rgb, Scene};

impl Scene {
    /// Whether anything gives off light: a lamp, an emitter, or the sky.
    pub(super) fn shines(&self) -> bool {
        let lamp = |light: &Light| match *light {
            Light::Point { intensity, .. } | Light::Spot { intensity, .. } => intensity != Rgb::ZERO,
            Light::Directional { irradiance, .. } => irradiance != Rgb::ZERO,
        };
        let emits = |color: &ColorTexture| match *color {
            ColorTexture::Constant(c) | ColorTexture::Scaled(_, c) | ColorTexture::Painted(_, c) => c != Rgb::ZERO,
            ColorTexture::Texture(_) => true,
        };
        let sky = match &self.environment {
            None => false,
            Some(Environment::Constant(radiance)) => *radiance != Rgb::ZERO,
            Some(Environment::Map(map)) => map.scale != 0.0,
        };
        let surface = self.shapes.iter().filter_map(|s| s.emitter.as_ref()).any(|e| emits(&e.radiance));
        sky || surface || self.lights.iter().any(lamp)
    }
}

/// What glTF cannot carry, and what to do about it.
pub const GLTF: &str = "nothing in the file gives off light: the picture is black; glTF has neither a world nor area \
    lamps, and exporters drop them (Blender's drops point, spot and sun lamps too unless \"Punctual Lights\" is ticked): \
    give the world's light with --env, make lamps of emissive meshes, or use point lamps";
