//! glTF materials and textures.

use super::Builder;
use super::glass::{self, Opaque};
use super::texture::{Channel, Reference};
use crate::scene::load::error::FileError;
use crate::scene::{AreaEmitter, ColorTexture, FloatTexture, Material, MaterialId, Rgb, TextureId};
use gltf::material::AlphaMode;

/// A material as shapes use it.
#[derive(Clone)]
pub struct Made {
    pub id: MaterialId,
    pub emitter: Option<AreaEmitter>,
    /// How its back shines, if it does.
    pub back: Option<Back>,
    /// Sets of texture coordinates that its textures use, at most two.
    pub uv_sets: Vec<u32>,
}

/// The back of a lamp that shines on both sides.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Back {
    /// Of a surface without holes: the inside of a closed one is not seen.
    Whole,
    /// Of a surface with holes, whose material is there from the front alone, so that two sheets let as much light through
    /// as one.
    Pierced,
}

/// What of a mesh a material depends on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct On {
    /// Whether its glass, if it is one, is enclosed by the mesh.
    pub solid: bool,
    /// Whether the vertices have colours.
    pub painted: bool,
}

impl Builder<'_> {
    /// The material, made once.
    pub(super) fn material(&mut self, source: &gltf::Material, on: On) -> Result<Made, FileError> {
        let key = (source.index(), on);
        if let Some(done) = self.materials.get(&key) {
            return Ok(done.clone());
        }
        let mut uv_sets = Vec::new();
        let made = match self.blenders_own(source) {
            Some(id) => Made { id, emitter: None, back: None, uv_sets },
            None => {
                let (id, emitter, back) = self.make(source, on, &mut uv_sets)?;
                Made { id, emitter, back, uv_sets }
            }
        };
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
            Some((texture, scale)) => self.push(Material::NormalMap { texture, scale, raised: true, inner }, source),
            None => inner,
        }
    }

    /// A surface under its normal map, the same on both sides.
    fn opaque(&mut self, surface: Material, normal: Option<(TextureId, f32)>, source: &gltf::Material) -> MaterialId {
        let surface = self.push(surface, source);
        let surface = self.bent(surface, normal, source);
        self.both_sides(surface, source)
    }

    /// Culled backs have no meaning where light travels everywhere: both sides are drawn.
    pub(super) fn both_sides(&mut self, side: MaterialId, source: &gltf::Material) -> MaterialId {
        self.push(Material::TwoSided { front: side, back: side }, source)
    }

    /// A factor, times a channel of a texture if there is one.
    pub(super) fn scaled(
        &mut self,
        factor: f32,
        texture: Option<&Reference>,
        channel: Channel,
        uv_sets: &mut Vec<u32>,
    ) -> Result<FloatTexture, FileError> {
        match texture {
            Some(reference) => Ok(FloatTexture::Scaled(self.texture(reference, channel, uv_sets)?, factor)),
            None => Ok(FloatTexture::Constant(factor)),
        }
    }

    fn make(
        &mut self,
        source: &gltf::Material,
        on: On,
        uv_sets: &mut Vec<u32>,
    ) -> Result<(MaterialId, Option<AreaEmitter>, Option<Back>), FileError> {
        // The first set of texture coordinates gives the tangents: the normal map comes first.
        let normal = match source.normal_texture() {
            Some(map) => Some((self.texture(&Reference::normal(&map), Channel::Normal, uv_sets)?, map.scale())),
            None => None,
        };
        let pbr = source.pbr_metallic_roughness();
        let [r, g, b, alpha] = pbr.base_color_factor();
        let tint = Rgb::new(r, g, b);
        let base = pbr.base_color_texture().map(|t| Reference::info(&t));
        let texture = base.as_ref().map(|base| self.texture(base, Channel::Color, uv_sets)).transpose()?;
        let base_color = match (texture, on.painted) {
            (texture, true) => ColorTexture::Painted(texture, tint),
            (Some(texture), false) => ColorTexture::Scaled(texture, tint),
            (None, false) => ColorTexture::Constant(tint),
        };
        let (mut id, emitter) = if source.unlit() {
            self.unlit(source, base_color)?
        } else {
            let surface = pbr.metallic_roughness_texture().map(|t| Reference::info(&t));
            let roughness = self.scaled(pbr.roughness_factor(), surface.as_ref(), Channel::Linear(1), uv_sets)?;
            let metallic = self.scaled(pbr.metallic_factor(), surface.as_ref(), Channel::Linear(2), uv_sets)?;
            let (f0, specular) = self.fresnel(source, uv_sets)?;
            let layered = self.blender.then(|| glass::index(source));
            let surface =
                |metallic| Material::MetallicRoughness { base_color, metallic, roughness, f0, specular, layered };
            let mut id = self.opaque(surface(metallic), normal, source);
            if let Some(transmission) = source.transmission() {
                let texture = transmission.transmission_texture().map(|t| Reference::info(&t));
                let factor = transmission.transmission_factor();
                let weight = self.scaled(factor, texture.as_ref(), Channel::Linear(0), uv_sets)?;
                let metal = match metallic {
                    FloatTexture::Constant(m) if m <= 0.0 => None,
                    _ => Some(self.opaque(surface(FloatTexture::Constant(1.0)), normal, source)),
                };
                let opaque = Opaque { id, metal, normal, base_color, metallic, roughness, solid: on.solid };
                id = self.glass(source, &opaque, weight);
            }
            let id = self.sheened(id, normal, source, uv_sets)?;
            (self.coated(id, source, uv_sets)?, self.emission(source, uv_sets)?)
        };
        let lamp = lamp(source);
        if emitter.is_some()
            && let Some(hidden) = lamp
        {
            let id = self.push(Material::FrontAlone { inner: id, hidden }, source);
            return Ok((id, emitter, None));
        }
        // Cycles knows no culling.
        let mut back = (emitter.is_some() && (source.double_sided() || self.blender)).then_some(Back::Whole);
        if let Some(opacity) = self.opacity(source, alpha, base.as_ref(), on.painted, uv_sets)? {
            id = self.push(Material::Mask { opacity, inner: id }, source);
            if back.is_some() {
                back = Some(Back::Pierced);
                id = self.push(Material::FrontAlone { inner: id, hidden: false }, source);
            }
        }
        Ok((id, emitter, back))
    }

    /// What Cycles gives surfaces without a material. (That of glTF is a rough white metal.)
    fn blenders_own(&mut self, source: &gltf::Material) -> Option<MaterialId> {
        (self.blender && source.index().is_none()).then(|| {
            let reflectance = ColorTexture::Constant(Rgb::splat(0.8));
            let grey = self.push(Material::Diffuse { reflectance }, source);
            self.both_sides(grey, source)
        })
    }

    /// KHR_materials_unlit: a surface that shows its colour whatever light falls on it shines with it.
    fn unlit(
        &mut self,
        source: &gltf::Material,
        radiance: ColorTexture,
    ) -> Result<(MaterialId, Option<AreaEmitter>), FileError> {
        let black = self.push(Material::Diffuse { reflectance: ColorTexture::Constant(Rgb::ZERO) }, source);
        let factor = radiance.factor();
        if !factor.is_finite() || factor.min_element() < 0.0 {
            return Err(self.data.error(format_args!("{}: its colour must be ≥ 0", label(source))));
        }
        let shines = factor != Rgb::ZERO;
        Ok((self.both_sides(black, source), shines.then_some(AreaEmitter { radiance })))
    }

    /// Reflectance of the dielectric part, at normal incidence over that at grazing incidence, and at grazing incidence
    /// (KHR_materials_specular).
    fn fresnel(
        &mut self,
        source: &gltf::Material,
        uv_sets: &mut Vec<u32>,
    ) -> Result<(ColorTexture, FloatTexture), FileError> {
        let ior = source.ior().unwrap_or(1.5);
        let smooth = Some(((ior - 1.0) / (ior + 1.0)).powi(2)).filter(|f| f.is_finite()).unwrap_or(1.0);
        let smooth = Rgb::splat(smooth.min(1.0));
        let Some(specular) = source.specular() else {
            return Ok((ColorTexture::Constant(smooth), FloatTexture::Constant(1.0)));
        };
        let tint = Rgb::from(specular.specular_color_factor()).clamp(Rgb::ZERO, Rgb::splat(1e30));
        let f0 = match specular.specular_color_texture() {
            Some(t) => {
                ColorTexture::Scaled(self.texture(&Reference::info(&t), Channel::Color, uv_sets)?, smooth * tint)
            }
            None => ColorTexture::Constant((smooth * tint).min(Rgb::ONE)),
        };
        let texture = specular.specular_texture().map(|t| Reference::info(&t));
        let factor = specular.specular_factor().clamp(0.0, 1.0);
        let channel = if self.blender { Channel::Strength } else { Channel::Linear(3) };
        Ok((f0, self.scaled(factor, texture.as_ref(), channel, uv_sets)?))
    }

    fn opacity(
        &mut self,
        source: &gltf::Material,
        alpha: f32,
        base: Option<&Reference>,
        painted: bool,
        uv_sets: &mut Vec<u32>,
    ) -> Result<Option<FloatTexture>, FileError> {
        let cutoff = source.alpha_cutoff().unwrap_or(0.5);
        let threshold = if alpha > 0.0 { cutoff / alpha } else { f32::INFINITY };
        if painted && source.alpha_mode() != AlphaMode::Opaque {
            let texture = base.map(|base| self.texture(base, Channel::Linear(3), uv_sets)).transpose()?;
            return Ok(Some(match source.alpha_mode() {
                AlphaMode::Mask => FloatTexture::PaintedStep(texture, threshold.min(f32::MAX)),
                _ => FloatTexture::Painted(texture, alpha),
            }));
        }
        Ok(Some(match (source.alpha_mode(), base) {
            (AlphaMode::Opaque, _) => return Ok(None),
            (AlphaMode::Blend, None) => FloatTexture::Constant(alpha.clamp(0.0, 1.0)),
            (AlphaMode::Blend, Some(base)) => {
                FloatTexture::Scaled(self.texture(base, Channel::Linear(3), uv_sets)?, alpha)
            }
            (AlphaMode::Mask, None) => FloatTexture::Constant(if alpha >= cutoff { 1.0 } else { 0.0 }),
            (AlphaMode::Mask, Some(base)) => {
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

/// Whether a material is that of a lamp as Blender has them: it shines from its front, and is not seen from behind; then
/// whether the camera does not see it. Both are custom properties, `area_lamp` and `hidden_from_camera`.
fn lamp(source: &gltf::Material) -> Option<bool> {
    let extras: serde_json::Value = serde_json::from_str(source.extras().as_ref()?.get()).ok()?;
    let set = |name: &str| extras.get(name).is_some_and(|v| v == true || v.as_f64().is_some_and(|v| v != 0.0));
    set("area_lamp").then(|| set("hidden_from_camera"))
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
    material.unlit() || material.emissive_factor() != [0.0; 3] && material.emissive_strength() != Some(0.0)
}
