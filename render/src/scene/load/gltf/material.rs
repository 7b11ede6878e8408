//! glTF materials and textures.

use super::Builder;
use crate::scene::load::error::FileError;
use crate::scene::load::image::{Pixels, srgb_to_linear};
use crate::scene::{
    AreaEmitter, Bitmap, ColorTexture, Distribution, FloatTexture, Interpolation, Material, MaterialId, Rgb, Texels,
    Texture, TextureId, Wrap,
};
use glam::{Affine2, Vec3A};
use gltf::material::AlphaMode;
use gltf::texture::{MagFilter, WrappingMode};
use std::collections::HashMap;
use std::rc::Rc;

/// A material as shapes use it.
#[derive(Clone)]
pub struct Made {
    pub id: MaterialId,
    pub emitter: Option<AreaEmitter>,
    /// Set of texture coordinates that its textures use.
    pub uv_set: u32,
}

/// What a texture is read for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Channel {
    /// sRGB-encoded colour.
    Color,
    /// One channel, linear.
    Linear(usize),
    /// 1 where alpha reaches the cutoff (its bits), else 0.
    Cutoff(u32),
    /// Tangent-space normal; glTF's green points up, this crate's v down.
    Normal,
}

/// Images decoded and textures made so far.
#[derive(Default)]
pub struct TextureCache {
    /// `None` where the file is missing, and may be.
    images: HashMap<usize, Option<Rc<Pixels>>>,
    textures: HashMap<(usize, Channel, [u32; 6]), TextureId>,
}

/// The fields that the different kinds of texture references of the `gltf` crate share.
struct Reference<'a> {
    texture: gltf::Texture<'a>,
    uv_set: u32,
    to_uv: Affine2,
}

impl<'a> Reference<'a> {
    fn info(info: &gltf::texture::Info<'a>) -> Self {
        let Some(t) = info.texture_transform() else {
            return Self { texture: info.texture(), uv_set: info.tex_coord(), to_uv: Affine2::IDENTITY };
        };
        let uv_set = t.tex_coord().unwrap_or(info.tex_coord());
        Self { texture: info.texture(), uv_set, to_uv: to_uv(t.scale(), t.rotation(), t.offset()) }
    }

    /// A normal texture, whose transform the `gltf` crate hands out as JSON.
    fn normal(normal: &gltf::material::NormalTexture<'a>) -> Self {
        let (texture, uv_set) = (normal.texture(), normal.tex_coord());
        let Some(json) = normal.extension_value("KHR_texture_transform") else {
            return Self { texture, uv_set, to_uv: Affine2::IDENTITY };
        };
        let number = |value: Option<&serde_json::Value>, missing| {
            value.and_then(serde_json::Value::as_f64).map_or(missing, |v| v as f32)
        };
        let pair = |name: &str, missing| [0, 1].map(|i| number(json.get(name).and_then(|v| v.get(i)), missing));
        let rotation = number(json.get("rotation"), 0.0);
        let uv_set = json.get("texCoord").and_then(serde_json::Value::as_u64).map_or(uv_set, |set| set as u32);
        Self { texture, uv_set, to_uv: to_uv(pair("scale", 1.0), rotation, pair("offset", 0.0)) }
    }
}

/// KHR_texture_transform, which turns coordinates counter-clockwise as seen with v pointing down.
fn to_uv(scale: [f32; 2], rotation: f32, offset: [f32; 2]) -> Affine2 {
    Affine2::from_scale_angle_translation(scale.into(), -rotation, offset.into())
}

impl Builder<'_> {
    /// The material, made once.
    pub(super) fn material(&mut self, source: &gltf::Material) -> Result<Made, FileError> {
        if let Some(done) = self.materials.get(&source.index()) {
            return Ok(done.clone());
        }
        let mut uv_sets = Vec::new();
        let made = self.make(source, &mut uv_sets)?;
        uv_sets.sort_unstable();
        uv_sets.dedup();
        let uv_set = uv_sets.first().copied().unwrap_or(0);
        if uv_sets.len() > 1 {
            self.warn(format_args!("{}: all its textures use texture coordinates {uv_set}", label(source)));
        }
        let made = Made { id: made.0, emitter: made.1, uv_set };
        self.materials.insert(source.index(), made.clone());
        Ok(made)
    }

    fn push(&mut self, material: Material, source: &gltf::Material) -> MaterialId {
        self.scene.materials.push(material);
        self.scene.material_names.push(source.name().map_or_else(|| label(source), String::from));
        MaterialId(self.scene.materials.len() as u32 - 1)
    }

    fn make(
        &mut self,
        source: &gltf::Material,
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
        let mut id = self.push(opaque, source);
        if let Some(normal) = source.normal_texture() {
            let reference = Reference::normal(&normal);
            let texture = self.texture(&reference, Channel::Normal, uv_sets)?;
            id = self.push(Material::NormalMap { texture, scale: normal.scale(), inner: id }, source);
        }
        // Culled backs have no meaning where light travels everywhere: both sides are drawn.
        id = self.push(Material::TwoSided { front: id, back: id }, source);
        if let Some(transmission) = source.transmission() {
            let weight = match transmission.transmission_texture() {
                Some(t) => {
                    let texture = self.texture(&Reference::info(&t), Channel::Linear(0), uv_sets)?;
                    FloatTexture::Scaled(texture, transmission.transmission_factor())
                }
                None => FloatTexture::Constant(transmission.transmission_factor()),
            };
            let glass = self.push(glass(base_color, ior, pbr.roughness_factor()), source);
            id = self.push(Material::Blend { weight, first: id, second: glass }, source);
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

    /// The image of a texture, decoded once.
    fn pixels(&mut self, texture: &gltf::Texture) -> Result<Option<Rc<Pixels>>, FileError> {
        let Some(image) = texture.source() else {
            let names = texture.extensions().map(|e| e.keys().cloned().collect::<Vec<_>>().join(", "));
            let names = names.filter(|n| !n.is_empty()).unwrap_or_else(|| "no image at all".into());
            let what = format!("texture {}: its image is not of glTF itself, but of {names}", texture.index());
            return Err(self.data.error(what));
        };
        if let Some(pixels) = self.textures.images.get(&image.index()) {
            return Ok(pixels.clone());
        }
        let pixels = match self.data.image(&image) {
            Ok(pixels) => Some(Rc::new(pixels)),
            Err(e) if e.missing && self.skip_missing => {
                self.missing.push(e.path.file_name().unwrap_or_default().to_string_lossy().into_owned());
                None
            }
            Err(e) if e.missing => return Err(e.advise("--skip-missing draws an even grey instead")),
            Err(e) => return Err(e),
        };
        self.textures.images.insert(image.index(), pixels.clone());
        Ok(pixels)
    }

    fn texture(
        &mut self,
        reference: &Reference,
        channel: Channel,
        uv_sets: &mut Vec<u32>,
    ) -> Result<TextureId, FileError> {
        uv_sets.push(reference.uv_set);
        let key = (reference.texture.index(), channel, reference.to_uv.to_cols_array().map(f32::to_bits));
        if let Some(&done) = self.textures.textures.get(&key) {
            return Ok(done);
        }
        let pixels = self.pixels(&reference.texture)?;
        let sampler = reference.texture.sampler();
        if sampler.wrap_s() != sampler.wrap_t() {
            self.warn(format_args!("texture {}: its wrap mode of u is used for v too", reference.texture.index()));
        }
        let bitmap = Bitmap {
            width: pixels.as_ref().map_or(1, |p| p.width),
            height: pixels.as_ref().map_or(1, |p| p.height),
            texels: pixels.map_or_else(|| even(channel), |p| texels(&p, channel)),
            wrap: match sampler.wrap_s() {
                WrappingMode::Repeat => Wrap::Repeat,
                WrappingMode::MirroredRepeat => Wrap::Mirror,
                WrappingMode::ClampToEdge => Wrap::Clamp,
            },
            interpolation: match sampler.mag_filter() {
                Some(MagFilter::Nearest) => Interpolation::Nearest,
                Some(MagFilter::Linear) | None => Interpolation::Bilinear,
            },
            to_uv: reference.to_uv,
        };
        let new = TextureId(self.scene.textures.len() as u32);
        self.scene.textures.push(Texture::Bitmap(bitmap));
        self.textures.textures.insert(key, new);
        Ok(new)
    }
}

fn texels(pixels: &Pixels, channel: Channel) -> Texels {
    let rgba = pixels.rgba.iter();
    match channel {
        Channel::Color => Texels::Rgb(rgba.map(|&[r, g, b, _]| [r, g, b].map(srgb_to_linear)).collect()),
        Channel::Linear(i) => Texels::Gray(rgba.map(|p| p[i]).collect()),
        Channel::Cutoff(bits) => {
            let threshold = f32::from_bits(bits);
            Texels::Gray(rgba.map(|p| if p[3] >= threshold { 1.0 } else { 0.0 }).collect())
        }
        Channel::Normal => Texels::Rgb(rgba.map(|&[r, g, b, _]| [r, 1.0 - g, b]).collect()),
    }
}

/// Stands for an image that is missing: grey, smooth, and everywhere there.
fn even(channel: Channel) -> Texels {
    match channel {
        Channel::Color => Texels::Rgb(vec![[0.5; 3]]),
        Channel::Linear(3) | Channel::Cutoff(_) => Texels::Gray(vec![1.0]),
        Channel::Linear(_) => Texels::Gray(vec![0.5]),
        Channel::Normal => Texels::Rgb(vec![[0.5, 0.5, 1.0]]),
    }
}

/// Solid glass, as Blender draws what it exports as transmission.
fn glass(tint: ColorTexture, eta: f32, roughness: f32) -> Material {
    let (reflectance, transmittance) = (ColorTexture::Constant(Vec3A::ONE), tint);
    let alpha = roughness * roughness;
    if alpha < 1e-3 {
        return Material::Dielectric { eta, reflectance, transmittance };
    }
    let alpha = FloatTexture::Constant(alpha);
    let distribution = Distribution::Ggx;
    Material::RoughDielectric { distribution, alpha_u: alpha, alpha_v: alpha, eta, reflectance, transmittance }
}

fn label(material: &gltf::Material) -> String {
    match (material.name(), material.index()) {
        (Some(name), _) => format!("material `{name}`"),
        (None, Some(index)) => format!("material {index}"),
        (None, None) => "the default material".into(),
    }
}
