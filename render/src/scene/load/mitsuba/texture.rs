//! `texture`: images, checkerboards, constants.

use super::Builder;
use super::object::Object;
use super::objects::ObjectId;
use super::spectrum::spectrum;
use crate::image::{Channels, Raster, Samples};
use crate::scene::load::error::LoadError;
use crate::scene::load::image::{self, Decoded};
use crate::scene::{
    Bitmap, ColorTexture, FloatTexture, Interpolation, Reading, Rgb, Stored, Texels, Texture, TextureId, Transfer,
    Wrap, luminance,
};
use glam::{Affine2, Mat2, Vec2};
use std::collections::HashSet;
use std::path::PathBuf;
use std::sync::Arc;

/// What a texture is used for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Decode {
    /// A colour.
    Color,
    /// A number: the luminance of the colour, or the chosen channel.
    Scalar,
    /// A vector: the values as stored.
    Vector,
}

/// From the parameters `raw` and `gamma` (−1 means sRGB); `None` is sRGB for formats made for display, none for the others.
pub fn transfer(object: &Object, raw: bool) -> Result<Option<Transfer>, LoadError> {
    let raw = object.boolean_or("raw", raw)?;
    Ok(match object.number("gamma")? {
        None if raw => Some(Transfer::Linear),
        None => None,
        Some(-1.0) => Some(Transfer::Srgb),
        Some(1.0) => Some(Transfer::Linear),
        Some(gamma) if (0.1..=10.0).contains(&gamma) => Some(Transfer::Gamma(gamma as f32)),
        Some(gamma) => return Err(object.error(format!("a gamma of {gamma}"))),
    })
}

/// The curve of an image where the scene names none.
pub fn own_transfer(raster: &Raster) -> Transfer {
    if raster.is_display_referred() { Transfer::Srgb } else { Transfer::Linear }
}

impl Builder<'_> {
    /// The colour parameter `name`: a number, a colour or a texture.
    pub(super) fn color_texture(
        &mut self,
        object: &Object,
        name: &str,
        default: ColorTexture,
    ) -> Result<ColorTexture, LoadError> {
        match object.child_named(name) {
            Some(id) => self.color_of(id, object.class == "emitter"),
            None => Ok(object.color(name)?.map_or(default, ColorTexture::Constant)),
        }
    }

    /// The colour parameter `name` where it cannot be a texture.
    pub(super) fn even_color(&mut self, object: &Object, name: &str) -> Result<Rgb, LoadError> {
        match self.color_texture(object, name, ColorTexture::Constant(Rgb::ONE))? {
            ColorTexture::Constant(color) => Ok(color),
            _ => Err(object.error(format!("a texture for `{name}` is not supported"))),
        }
    }

    fn color_of(&mut self, id: ObjectId, emitter: bool) -> Result<ColorTexture, LoadError> {
        let objects = self.objects;
        let object = &objects[id];
        let color = |name| object.color(name).map(|c| c.unwrap_or(Rgb::ONE));
        Ok(match object.plugin.as_str() {
            "scale" => {
                let factor = color("scale")?;
                self.color_of(self.inner_texture(object)?, emitter)?.times(factor)
            }
            "uniform" => ColorTexture::Constant(color("value")?),
            "srgb" => ColorTexture::Constant(color("color")?),
            "d65" => ColorTexture::Constant(color("color")? * object.number_or("scale", 1.0)? as f32),
            _ => match spectrum(object, emitter)? {
                Some(color) => ColorTexture::Constant(color),
                None => ColorTexture::Texture(self.texture(id, Decode::Color)?),
            },
        })
    }

    /// The number parameter `name`: a number or a texture.
    pub(super) fn float_texture(
        &mut self,
        object: &Object,
        name: &str,
        default: FloatTexture,
    ) -> Result<FloatTexture, LoadError> {
        match object.child_named(name) {
            Some(id) => self.float_of(id),
            None => Ok(object.color(name)?.map_or(default, |c| FloatTexture::Constant(luminance(c)))),
        }
    }

    fn float_of(&mut self, id: ObjectId) -> Result<FloatTexture, LoadError> {
        let objects = self.objects;
        let object = &objects[id];
        Ok(match object.plugin.as_str() {
            "scale" => {
                let factor = object.number_or("scale", 1.0)? as f32;
                self.float_of(self.inner_texture(object)?)?.times(factor)
            }
            "uniform" => FloatTexture::Constant(object.number_or("value", 1.0)? as f32),
            _ => FloatTexture::Texture(self.texture(id, Decode::Scalar)?),
        })
    }

    /// The only texture inside another one or inside a bump or normal map, whatever its name.
    pub(super) fn inner_texture(&self, object: &Object) -> Result<ObjectId, LoadError> {
        let mut inner = object.children_of(self.objects, "texture");
        match (inner.next(), inner.next()) {
            (Some((id, _)), None) => Ok(id),
            _ => Err(object.error("exactly one texture inside is needed")),
        }
    }

    /// A texture that varies, made once for every use it is put to.
    pub(super) fn texture(&mut self, id: ObjectId, decode: Decode) -> Result<TextureId, LoadError> {
        if let Some(&done) = self.textures.get(&(id, decode)) {
            return Ok(done);
        }
        let objects = self.objects;
        let object = &objects[id];
        let texture = match (object.class.as_str(), object.plugin.as_str()) {
            ("texture", "bitmap") => Texture::Bitmap(self.bitmap(object, decode)?),
            ("texture", "checkerboard") => {
                let color = |name, default| {
                    let color = object.color(name).map(|c| c.unwrap_or(Rgb::splat(default)));
                    color.map(|c| if decode == Decode::Scalar { Rgb::splat(luminance(c)) } else { c })
                };
                Texture::Checkerboard {
                    color0: color("color0", 0.4)?,
                    color1: color("color1", 0.2)?,
                    to_uv: to_uv(object)?,
                }
            }
            (class, plugin) => return Err(object.error(format!("{class} `{plugin}` is not supported as a texture"))),
        };
        let new = TextureId(self.scene.textures.len() as u32);
        self.scene.textures.push(texture);
        self.textures.insert((id, decode), new);
        Ok(new)
    }

    fn bitmap(&mut self, object: &Object, decode: Decode) -> Result<Bitmap, LoadError> {
        object.ignore(&["cache", "max_anisotropy", "format"]);
        let transfer = transfer(object, decode == Decode::Vector)?;
        let interpolation = match object.text("filter_type")?.map(str::to_ascii_lowercase).as_deref() {
            Some("nearest") => Interpolation::Nearest,
            // Many samples per pixel filter the texture; the filters of version 0.x only save some of them.
            None | Some("bilinear" | "trilinear" | "ewa") => Interpolation::Bilinear,
            Some(other) => return Err(object.error(format!("no such texture filter: `{other}`"))),
        };
        let wrap = self.wrap(object)?;
        let (raster, there) = self.texture_image(object, decode)?;
        let reading = match (object.text("channel")?.map(str::to_ascii_lowercase), decode) {
            (Some(name), _) => {
                let at = ["r", "g", "b", "a"].iter().position(|c| *c == name);
                let at = at.ok_or_else(|| object.error(format!("no channel `{name}` (r, g, b or a)")))?;
                if let Some((x, y)) = raster.alpha_not_finite().filter(|_| at == 3) {
                    return Err(object.error(format!("alpha of pixel ({x}, {y}) is not finite")));
                }
                Reading::Channel(at as u8)
            }
            (None, Decode::Scalar) => Reading::Luminance,
            (None, _) => Reading::Color,
        };
        // Vectors are never colours, whether the file says so or not.
        let transfer = if decode == Decode::Vector || !there { Some(Transfer::Linear) } else { transfer };
        let transfer = transfer.unwrap_or_else(|| own_transfer(&raster));
        let (width, height, to_uv) = (raster.width, raster.height, to_uv(object)?);
        let texels = Texels::Stored(Stored::new(raster, reading, transfer));
        Ok(Bitmap { width, height, texels, wrap, interpolation, second_uv: false, to_uv })
    }

    fn wrap(&mut self, object: &Object) -> Result<[Wrap; 2], LoadError> {
        let both = object.text("wrap_mode")?.unwrap_or("repeat");
        let (u, v) = (object.text("wrap_mode_u")?.unwrap_or(both), object.text("wrap_mode_v")?.unwrap_or(both));
        let mut along = |mode| match mode {
            "repeat" => Ok(Wrap::Repeat),
            "mirror" => Ok(Wrap::Mirror),
            "clamp" => Ok(Wrap::Clamp),
            "zero" | "one" => {
                self.warn(object, format_args!("the wrap mode `{mode}` is not supported: `clamp` is used instead"));
                Ok(Wrap::Clamp)
            }
            other => Err(object.error(format!("no such wrap mode: `{other}`"))),
        };
        let first = along(u)?;
        Ok([first, if u == v { first } else { along(v)? }])
    }

    /// What the file of an image left open.
    pub(super) fn warn_of(&mut self, object: &Object, name: &str, warnings: &[String]) {
        for warning in warnings {
            self.warn(object, format_args!("{name}: {warning}"));
        }
    }

    /// The image of a texture, and whether it is there: an even grey where it is missing and may be.
    fn texture_image(&mut self, object: &Object, decode: Decode) -> Result<(Arc<Raster>, bool), LoadError> {
        let name = object.require_text("filename")?;
        let path = self.objects.path(object, name);
        match self.images.get(&path, |path| image::read(path)) {
            Ok(Decoded { raster, warnings }) => {
                self.files.push(path);
                self.warn_of(object, name, &warnings);
                Ok((raster, true))
            }
            Err(error) if error.missing && self.skip_missing => {
                self.missing_textures.push(name.into());
                let z = if decode == Decode::Vector { 1.0 } else { 0.5 };
                let samples = Samples::F32(vec![0.5, 0.5, z, 0.5]);
                Ok((Arc::new(Raster { width: 1, height: 1, channels: Channels::Rgba, samples }), false))
            }
            Err(error) if error.missing => {
                let error = error.advise("--skip-missing draws an even grey instead");
                Err(self.objects.asset(object, name, error))
            }
            Err(error) => Err(self.objects.asset(object, name, error)),
        }
    }

    /// Decodes together the images of all textures that objects hold.
    pub(super) fn announce_images(&mut self, holders: &[ObjectId]) {
        let objects = self.objects;
        let (mut waiting, mut seen) = (holders.iter().rev().copied().collect::<Vec<_>>(), HashSet::new());
        let mut paths: Vec<PathBuf> = Vec::new();
        while let Some(id) = waiting.pop() {
            if seen.insert(id) {
                let object = &objects[id];
                let image = object.peek("filename").filter(|_| object.class == "texture" && object.plugin == "bitmap");
                paths.extend(image.map(|name| objects.path(object, name)));
                waiting.extend(object.children.iter().rev().map(|child| child.object));
            }
        }
        self.images.announce(paths, |path| image::read(path));
    }
}

/// Version 3 gives a transform, version 0.x scales and offsets: uv · scale + offset.
fn to_uv(object: &Object) -> Result<Affine2, LoadError> {
    let transform = object.transform("to_uv")?;
    let part = |name, default| object.number_or(name, default).map(|v| v as f32);
    let scale = Vec2::new(part("uscale", 1.0)?, part("vscale", 1.0)?);
    let offset = Vec2::new(part("uoffset", 0.0)?, part("voffset", 0.0)?);
    let m = transform.matrix3;
    let columns = Mat2::from_cols(m.x_axis.truncate().as_vec2(), m.y_axis.truncate().as_vec2());
    let given = Affine2::from_mat2_translation(columns, transform.translation.truncate().as_vec2());
    Ok(given * Affine2::from_scale_angle_translation(scale, 0.0, offset))
}
