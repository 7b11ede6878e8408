//! glTF materials and textures.

use super::Builder;
use super::glass::Opaque;
use super::texture::{Channel, Reference};
use crate::scene::load::error::FileError;
use crate::scene::{AreaEmitter, ColorTexture, FloatTexture, Material, MaterialId, Rgb, TextureId};
use gltf::material::AlphaMode;

/// A material as shapes use it.
#[derive(Clone)]
pub struct Made {
    pub id: MaterialId,
    pub emitter: Option<AreaEmitter>,
    /// Set of texture coordinates that its textures use.
    pub uv_set: u32,
}

impl Builder<'_> {
    /// The material, made once; `solid`: as glass, where it is, that a mesh encloses.
    pub(super) fn material(&mut self, source: &gltf::Material, solid: bool) -> Result<Made, FileError> {
        let key = (source.index(), solid);
        if let Some(done) = self.materials.get(&key) {
            return Ok(done.clone());
        }
        let mut uv_sets = Vec::new();
        let made = self.make(source, solid, &mut uv_sets)?;
        uv_sets.sort_unstable();
        uv_sets.dedup();
        let uv_set = uv_sets.first().copied().unwrap_or(0);
        if uv_sets.len() > 1 {
            self.warn(format_args!("{}: all its textures use texture coordinates {uv_set}", label(source)));
        }
        let made = Made { id: made.0, emitter: made.1, uv_set };
        self.materials.insert(key, made.clone());
        Ok(made)
    }

    pub(super) fn push(&mut self, material: Material, source: &gltf::Material) -> MaterialId {
        self.scene.materials.push(material);
        self.scene.material_names.push(source.name().map_or_else(|| label(source), String::from));
        MaterialId(self.scene.materials.len() as u32 - 1)
    }

    /// A material under a normal map with its scale.
    pub(super) fn bent(
        &mut self,
        inner: MaterialId,
        normal: Option<(TextureId, f32)>,
        source: &gltf::Material,
    ) -> MaterialId {
        match normal {
            Some((texture, scale)) => self.push(Material::NormalMap { texture, scale, inner }, source),
            None => inner,
        }
    }

    fn make(
        &mut self,
        source: &gltf::Material,
        solid: bool,
        uv_sets: &mut Vec<u32>,
    ) -> Result<(MaterialId, Option<AreaEmitter>), FileError> {
        let pbr = source.pbr_metallic_roughness();
        let [r, g, b, alpha] = pbr.base_color_factor();
        let tint = Rgb::new(r, g, b);
        let base = pbr.base_color_texture().map(|t| Reference::info(&t));
        let base_color = match &base {
            Some(reference) => ColorTexture::Scaled(self.texture(reference, Channel::Color, uv_sets)?, tint),
            None => ColorTexture::Constant(tint),
        };
        let surface = pbr.metallic_roughness_texture().map(|t| Reference::info(&t));
        let mut scaled = |factor: f32, channel| match &surface {
            Some(reference) => self.texture(reference, channel, uv_sets).map(|t| FloatTexture::Scaled(t, factor)),
            None => Ok(FloatTexture::Constant(factor)),
        };
        let roughness = scaled(pbr.roughness_factor(), Channel::Linear(1))?;
        let metallic = scaled(pbr.metallic_factor(), Channel::Linear(2))?;
        let ior = source.ior().unwrap_or(1.5);
        let (f0, f90) = self.fresnel(source, ior);
        let opaque = Material::MetallicRoughness { base_color, metallic, roughness, f0, f90 };
        let opaque = self.push(opaque, source);
        let normal = match source.normal_texture() {
            Some(map) => {
                let texture = self.texture(&Reference::normal(&map), Channel::Normal, uv_sets)?;
                Some((texture, map.scale()))
            }
            None => None,
        };
        let opaque = self.bent(opaque, normal, source);
        // Culled backs have no meaning where light travels everywhere: both sides are drawn.
        let mut id = self.push(Material::TwoSided { front: opaque, back: opaque }, source);
        if let Some(transmission) = source.transmission() {
            let weight = match transmission.transmission_texture() {
                Some(t) => {
                    let texture = self.texture(&Reference::info(&t), Channel::Linear(0), uv_sets)?;
                    FloatTexture::Scaled(texture, transmission.transmission_factor())
                }
                None => FloatTexture::Constant(transmission.transmission_factor()),
            };
            id = self.glass(source, &Opaque { id, normal, base_color, metallic, roughness, solid }, weight);
        }
        let opacity = self.opacity(source, alpha, base.as_ref(), uv_sets)?;
        if let Some(opacity) = opacity {
            id = self.push(Material::Mask { opacity, inner: id }, source);
        }
        Ok((id, self.emission(source, uv_sets)?))
    }

    /// Reflectance of the dielectric part at normal and at grazing incidence (KHR_materials_specular).
    fn fresnel(&mut self, source: &gltf::Material, ior: f32) -> (Rgb, f32) {
        let smooth = Some(((ior - 1.0) / (ior + 1.0)).powi(2)).filter(|f| f.is_finite()).unwrap_or(1.0);
        let smooth = Rgb::splat(smooth.min(1.0));
        let Some(specular) = source.specular() else { return (smooth, 1.0) };
        if specular.specular_texture().is_some() || specular.specular_color_texture().is_some() {
            self.note("textures of KHR_materials_specular are ignored", label(source));
        }
        let factor = specular.specular_factor().clamp(0.0, 1.0);
        let tint = Rgb::from(specular.specular_color_factor()).clamp(Rgb::ZERO, Rgb::splat(1e30));
        ((smooth * tint).min(Rgb::ONE) * factor, factor)
    }

    fn opacity(
        &mut self,
        source: &gltf::Material,
        alpha: f32,
        base: Option<&Reference>,
        uv_sets: &mut Vec<u32>,
    ) -> Result<Option<FloatTexture>, FileError> {
        let cutoff = source.alpha_cutoff().unwrap_or(0.5);
        Ok(Some(match (source.alpha_mode(), base) {
            (AlphaMode::Opaque, _) => return Ok(None),
            (AlphaMode::Blend, None) => FloatTexture::Constant(alpha.clamp(0.0, 1.0)),
            (AlphaMode::Blend, Some(base)) => {
                FloatTexture::Scaled(self.texture(base, Channel::Linear(3), uv_sets)?, alpha)
            }
            (AlphaMode::Mask, None) => FloatTexture::Constant(if alpha >= cutoff { 1.0 } else { 0.0 }),
            (AlphaMode::Mask, Some(base)) => {
                let threshold = if alpha > 0.0 { cutoff / alpha } else { f32::INFINITY };
                FloatTexture::Texture(self.texture(base, Channel::Cutoff(threshold.to_bits()), uv_sets)?)
            }
        }))
    }

    fn emission(&mut self, source: &gltf::Material, uv_sets: &mut Vec<u32>) -> Result<Option<AreaEmitter>, FileError> {
        let factor = Rgb::from(source.emissive_factor()) * source.emissive_strength().unwrap_or(1.0);
        if factor == Rgb::ZERO {
            return Ok(None);
        }
        if !factor.is_finite() || factor.min_element() < 0.0 {
            return Err(self.data.error(format_args!("{}: emission must be ≥ 0", label(source))));
        }
        let radiance = match source.emissive_texture() {
            Some(t) => ColorTexture::Scaled(self.texture(&Reference::info(&t), Channel::Color, uv_sets)?, factor),
            None => ColorTexture::Constant(factor),
        };
        Ok(Some(AreaEmitter { radiance }))
    }
}

pub(super) fn label(material: &gltf::Material) -> String {
    match (material.name(), material.index()) {
        (Some(name), _) => format!("material `{name}`"),
        (None, Some(index)) => format!("material {index}"),
        (None, None) => "the default material".into(),
    }
}

/// Whether surfaces of this material shine.
pub(super) fn emits(material: &gltf::Material) -> bool {
    material.emissive_factor() != [0.0; 3] && material.emissive_strength() != Some(0.0)
}
