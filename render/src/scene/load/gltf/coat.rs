//! KHR_materials_clearcoat.

use super::Builder;
use super::texture::{Channel, number};
use crate::scene::load::error::FileError;
use crate::scene::{ColorTexture, FloatTexture, Material, MaterialId, Rgb};

impl Builder<'_> {
    /// A material under its clear coat, if it has one. The coat has its own normals.
    pub(super) fn coated(
        &mut self,
        base: MaterialId,
        source: &gltf::Material,
        uv_sets: &mut Vec<u32>,
    ) -> Result<MaterialId, FileError> {
        let Some(json) = source.extension_value("KHR_materials_clearcoat") else { return Ok(base) };
        let share = |name| number(json.get(name), 0.0).clamp(0.0, 1.0);
        let texture = |builder: &Self, name: &str| json.get(name).map(|t| builder.reference(t)).transpose();
        let [factor, roughness] = ["clearcoatFactor", "clearcoatRoughnessFactor"].map(share);
        if factor == 0.0 {
            return Ok(base);
        }
        let normal = match json.get("clearcoatNormalTexture") {
            Some(map) => {
                let reference = self.reference(map)?;
                Some((self.texture(&reference, Channel::Normal, uv_sets)?, number(map.get("scale"), 1.0)))
            }
            None => None,
        };
        let of_factor = texture(self, "clearcoatTexture")?;
        let of_roughness = texture(self, "clearcoatRoughnessTexture")?;
        let weight = self.scaled(factor, of_factor.as_ref(), Channel::Linear(0), uv_sets)?;
        let roughness = self.scaled(roughness, of_roughness.as_ref(), Channel::Linear(1), uv_sets)?;
        // What reflects all.
        let one = FloatTexture::Constant(1.0);
        let white = ColorTexture::Constant(Rgb::ONE);
        let coat = Material::MetallicRoughness {
            base_color: white,
            metallic: one,
            roughness,
            f0: white,
            specular: one,
            layered: None,
        };
        let coat = self.push(coat, source);
        let coat = self.bent(coat, normal, source);
        let coat = self.both_sides(coat, source);
        Ok(self.push(Material::Coat { added: false, weight, coat, base }, source))
    }
}
