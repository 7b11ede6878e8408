//! glTF textures: images, samplers, transforms of texture coordinates.

use super::Builder;
use crate::image::{Raster, Samples};
use crate::scene::load::error::FileError;
use crate::scene::load::image::Images;
use crate::scene::{Bitmap, Interpolation, Reading, Stored, Texels, Texture, TextureId, Transfer, Wrap};
use glam::Affine2;
use gltf::texture::{MagFilter, WrappingMode};
use serde_json::Value;
use std::collections::{HashMap, HashSet};
use std::sync::Arc;

/// What a texture is read for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Channel {
    /// sRGB-encoded colour.
    Color,
    /// One channel, linear.
    Linear(u8),
    /// Alpha; red in an image without: Blender's exporter leaves a strength where it was.
    Strength,
    /// 1 where alpha reaches the cutoff (its bits), else 0.
    Cutoff(u32),
    /// Tangent-space normal; glTF's green points up, this crate's v down.
    Normal,
}

/// Images decoded and textures made so far.
pub struct TextureCache {
    images: Images<usize>,
    /// Images whose files are missing, and may be.
    missing: HashSet<usize>,
    textures: HashMap<(usize, Channel, [u32; 6], bool), TextureId>,
}

impl TextureCache {
    pub fn new(skip_missing: bool) -> Self {
        Self { images: Images::new(skip_missing), missing: HashSet::new(), textures: HashMap::new() }
    }
}

/// The textures that materials refer to, of those that are drawn.
const READ: [&str; 12] = [
    "baseColorTexture",
    "metallicRoughnessTexture",
    "normalTexture",
    "emissiveTexture",
    "transmissionTexture",
    "specularTexture",
    "specularColorTexture",
    "clearcoatTexture",
    "clearcoatRoughnessTexture",
    "clearcoatNormalTexture",
    "sheenColorTexture",
    "sheenRoughnessTexture",
];

/// Indices of the textures that a material in JSON refers to, in the order of the text.
fn references(material: &Value, found: &mut Vec<usize>) {
    for (name, value) in material.as_object().into_iter().flatten() {
        match value.get("index").and_then(Value::as_u64) {
            Some(index) if READ.contains(&name.as_str()) => found.push(index as usize),
            _ => references(value, found),
        }
    }
}

/// The fields that the different kinds of texture references of the `gltf` crate share.
pub(super) struct Reference<'a> {
    pub texture: gltf::Texture<'a>,
    pub uv_set: u32,
    pub to_uv: Affine2,
}

impl<'a> Reference<'a> {
    pub fn info(info: &gltf::texture::Info<'a>) -> Self {
        let Some(t) = info.texture_transform() else {
            return Self { texture: info.texture(), uv_set: info.tex_coord(), to_uv: Affine2::IDENTITY };
        };
        let uv_set = t.tex_coord().unwrap_or(info.tex_coord());
        Self { texture: info.texture(), uv_set, to_uv: to_uv(t.scale(), t.rotation(), t.offset()) }
    }

    /// A normal texture, whose transform the `gltf` crate hands out as JSON.
    pub fn normal(normal: &gltf::material::NormalTexture<'a>) -> Self {
        let (texture, uv_set) = (normal.texture(), normal.tex_coord());
        let Some(json) = normal.extension_value("KHR_texture_transform") else {
            return Self { texture, uv_set, to_uv: Affine2::IDENTITY };
        };
        Self::transformed(texture, uv_set, json)
    }

    /// With a KHR_texture_transform as JSON.
    fn transformed(texture: gltf::Texture<'a>, uv_set: u32, json: &Value) -> Self {
        let pair = |name: &str, missing| [0, 1].map(|i| number(json.get(name).and_then(|v| v.get(i)), missing));
        let rotation = number(json.get("rotation"), 0.0);
        let uv_set = json.get("texCoord").and_then(Value::as_u64).map_or(uv_set, |set| set as u32);
        Self { texture, uv_set, to_uv: to_uv(pair("scale", 1.0), rotation, pair("offset", 0.0)) }
    }
}

/// A number of an extension that the `gltf` crate hands out as JSON.
pub(super) fn number(value: Option<&Value>, missing: f32) -> f32 {
    value.and_then(Value::as_f64).map_or(missing, |v| v as f32)
}

/// KHR_texture_transform, which turns coordinates counter-clockwise as seen with v pointing down.
fn to_uv(scale: [f32; 2], rotation: f32, offset: [f32; 2]) -> Affine2 {
    Affine2::from_scale_angle_translation(scale.into(), -rotation, offset.into())
}

impl<'a> Builder<'a> {
    /// A texture that an extension refers to in JSON.
    pub(super) fn reference(&self, json: &Value) -> Result<Reference<'a>, FileError> {
        let index = json.get("index").and_then(Value::as_u64);
        let texture = index.and_then(|i| self.document.textures().nth(i as usize));
        let texture = texture.ok_or_else(|| self.data.error("an extension refers to a missing texture"))?;
        let uv_set = json.get("texCoord").and_then(Value::as_u64).unwrap_or(0) as u32;
        Ok(match json.get("extensions").and_then(|e| e.get("KHR_texture_transform")) {
            Some(transform) => Reference::transformed(texture, uv_set, transform),
            None => Reference { texture, uv_set, to_uv: Affine2::IDENTITY },
        })
    }

    /// Decodes together the images that the materials of meshes read.
    pub(super) fn announce_images(&mut self, meshes: &[gltf::Mesh]) {
        let materials = meshes.iter().flat_map(|mesh| mesh.primitives()).filter_map(|p| p.material().index());
        let (mut seen, mut textures) = (HashSet::new(), Vec::new());
        for material in materials.filter(|index| seen.insert(*index)) {
            let json = self.document.as_json().materials.get(material).map(serde_json::to_value);
            references(&json.and_then(Result::ok).unwrap_or_default(), &mut textures);
        }
        let all: Vec<gltf::Texture> = self.document.textures().collect();
        let images = textures.into_iter().filter_map(|index| Some(self.image_of(all.get(index)?)?.0.index()));
        let (images, data): (Vec<usize>, _) = (images.collect(), self.data);
        let all: Vec<gltf::Image> = self.document.images().collect();
        self.textures.images.announce(images, |index| data.image(&all[*index]));
    }

    /// The image of a texture, and whether an extension names it: a WebP image, which goes first.
    fn image_of(&self, texture: &gltf::Texture) -> Option<(gltf::Image<'a>, bool)> {
        let webp = texture.extension_value("EXT_texture_webp").and_then(|e| e.get("source")).and_then(Value::as_u64);
        let webp = webp.and_then(|i| self.document.images().nth(i as usize));
        let by_extension = webp.is_some();
        let own = || self.document.images().nth(texture.source()?.index());
        webp.or_else(own).map(|image| (image, by_extension))
    }

    /// The pixels of a texture; `None` where the file is missing, and may be.
    fn pixels(&mut self, texture: &gltf::Texture) -> Result<Option<Arc<Raster>>, FileError> {
        let Some((image, by_extension)) = self.image_of(texture) else {
            let names = texture.extensions().map(|e| e.keys().cloned().collect::<Vec<_>>().join(", "));
            let names = names.filter(|n| !n.is_empty()).unwrap_or_else(|| "no image at all".into());
            let what = format!("texture {}: its image is not of glTF itself, but of {names}", texture.index());
            return Err(self.data.error(what));
        };
        match self.textures.images.get(&image.index(), |_| self.data.image(&image)) {
            Ok(decoded) => Ok(Some(decoded.raster)),
            Err(e) if e.missing && self.skip_missing => {
                if self.textures.missing.insert(image.index()) {
                    self.missing.push(e.path.file_name().unwrap_or_default().to_string_lossy().into_owned());
                }
                Ok(None)
            }
            Err(e) if e.missing => Err(e.advise("--skip-missing draws an even grey instead")),
            Err(e) if by_extension => {
                let (i, what) = (texture.index(), e.what);
                Err(self.data.error(format_args!("texture {i}: its image of EXT_texture_webp: {what}")))
            }
            Err(e) => Err(e),
        }
    }

    /// The images that textures show.
    pub(super) fn images_read(&self) -> impl Iterator<Item = gltf::Image<'a>> {
        self.document.images().filter(|image| self.textures.images.holds(&image.index()))
    }

    /// Whether a material reads a set of texture coordinates as its second; of more than two, the first stands in.
    fn slot(&mut self, set: u32, uv_sets: &mut Vec<u32>) -> bool {
        if !uv_sets.contains(&set) && uv_sets.len() == 2 {
            self.note("more than two sets of texture coordinates in a material: the first is used", "TEXCOORD");
            return false;
        }
        if !uv_sets.contains(&set) {
            uv_sets.push(set);
        }
        uv_sets.first() != Some(&set)
    }

    pub(super) fn texture(
        &mut self,
        reference: &Reference,
        channel: Channel,
        uv_sets: &mut Vec<u32>,
    ) -> Result<TextureId, FileError> {
        let second_uv = self.slot(reference.uv_set, uv_sets);
        let to_uv = reference.to_uv.to_cols_array().map(f32::to_bits);
        let key = (reference.texture.index(), channel, to_uv, second_uv);
        if let Some(&done) = self.textures.textures.get(&key) {
            return Ok(done);
        }
        let pixels = self.pixels(&reference.texture)?;
        let sampler = reference.texture.sampler();
        let bitmap = Bitmap {
            width: pixels.as_ref().map_or(1, |p| p.width),
            height: pixels.as_ref().map_or(1, |p| p.height),
            texels: pixels.map_or_else(|| even(channel), |p| Texels::Stored(stored(p, channel))),
            wrap: [sampler.wrap_s(), sampler.wrap_t()].map(|mode| match mode {
                WrappingMode::Repeat => Wrap::Repeat,
                WrappingMode::MirroredRepeat => Wrap::Mirror,
                WrappingMode::ClampToEdge => Wrap::Clamp,
            }),
            second_uv,
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

fn stored(raster: Arc<Raster>, channel: Channel) -> Stored {
    match channel {
        Channel::Color => Stored::new(raster, Reading::Color, Transfer::Srgb),
        Channel::Linear(i) => Stored::new(raster, Reading::Channel(i), Transfer::Linear),
        Channel::Strength => {
            let reading = Reading::Channel(if is_opaque(&raster) { 0 } else { 3 });
            Stored::new(raster, reading, Transfer::Linear)
        }
        Channel::Cutoff(bits) => Stored::new(raster, Reading::Step(f32::from_bits(bits)), Transfer::Linear),
        Channel::Normal => Stored::new(raster, Reading::Normal, Transfer::Linear),
    }
}

/// Whether the alpha of an image says nothing.
fn is_opaque(raster: &Raster) -> bool {
    let (Some(alpha), count) = (raster.channels.alpha(), raster.channels.count()) else { return true };
    match &raster.samples {
        Samples::U8(samples) => samples.chunks_exact(count).all(|pixel| pixel[alpha] == u8::MAX),
        _ => raster.pixels().all(|p| p[3] >= 1.0),
    }
}

/// Stands for an image that is missing: grey, smooth, and everywhere there.
fn even(channel: Channel) -> Texels {
    match channel {
        Channel::Color => Texels::Rgb(vec![[0.5; 3]]),
        Channel::Linear(3) | Channel::Strength | Channel::Cutoff(_) => Texels::Gray(vec![1.0]),
        Channel::Linear(_) => Texels::Gray(vec![0.5]),
        Channel::Normal => Texels::Rgb(vec![[0.5, 0.5, 1.0]]),
    }
}
