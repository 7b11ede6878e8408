//! KHR_materials_sheen.

use super::Builder;
use super::texture::{Channel, number};
use crate::scene::load::error::FileError;
use crate::scene::{ColorTexture, FloatTexture, Material, MaterialId, Rgb, TextureId};
use brdf_tables::brdf::{Sheen, Specular};

/// Smallest α of the fibres, as recipes have it.
const LEAST: f32 = 0.07;

impl Builder<'_> {
    /// A material under its fibres, if it has some. They have the normals of what lies below.
    pub(super) fn sheened(
        &mut self,
        base: MaterialId,
        normal: Option<(TextureId, f32)>,
        source: &gltf::Material,
        uv_sets: &mut Vec<u32>,
    ) -> Result<MaterialId, FileError> {
        let Some(json) = source.extension_value("KHR_materials_sheen") else { return Ok(base) };
        let channel = |i: usize| number(json.get("sheenColorFactor").and_then(|c| c.get(i)), 0.0).clamp(0.0, 1.0);
        let factor = Rgb::new(channel(0), channel(1), channel(2));
        if factor == Rgb::ZERO {
            return Ok(base);
        }
        let color = match json.get("sheenColorTexture") {
            Some(t) => ColorTexture::Scaled(self.texture(&self.reference(t)?, Channel::Color, uv_sets)?, factor),
            None => ColorTexture::Constant(factor),
        };
        let of_roughness = json.get("sheenRoughnessTexture").map(|t| self.reference(t)).transpose()?;
        let roughness = number(json.get("sheenRoughnessFactor"), 0.0).clamp(0.0, 1.0);
        let roughness = match self.scaled(roughness, of_roughness.as_ref(), Channel::Linear(3), uv_sets)? {
            FloatTexture::Constant(roughness) => roughness,
            texture => {
                self.note("a texture for the roughness of sheen is drawn as its mean", super::material::label(source));
                texture.mean(&self.scene.textures)
            }
        };
        let alpha = roughness * roughness;
        if alpha < LEAST {
            let what = "sheen of a roughness below 0.265 is drawn with that: the formula makes light there";
            self.note(what, super::material::label(source));
        }
        let model = Specular::Sheen(Sheen { alpha: alpha.clamp(LEAST, 1.0).into() });
        let (black, white) = (ColorTexture::Constant(Rgb::ZERO), ColorTexture::Constant(Rgb::ONE));
        let fibres = self.push(Material::Lobe { diffuse: black, specular: white, model }, source);
        let fibres = self.bent(fibres, normal, source);
        let fibres = self.both_sides(fibres, source);
        Ok(self.push(Material::Sheen { color, fibres, base }, source))
    }
}
