//! `bsdf` plugin `principled`: Burley's model, without what transmits.

use super::Builder;
use super::object::Object;
use crate::scene::load::error::LoadError;
use crate::scene::{ColorTexture, FloatTexture, Material, Rgb};

/// Index of the dielectric whose reflectance at normal incidence is 0.08 · `specular`.
fn index(specular: f64) -> f64 {
    2.0 / (1.0 - (0.08 * specular).sqrt()) - 1.0
}

/// Smallest `specular` and index: a model without reflection at grazing angles is not one of these.
const LEAST_SPECULAR: f64 = 1e-3;
const LEAST_INDEX: f64 = 1.001;

impl Builder<'_> {
    pub(super) fn principled(&mut self, object: &Object) -> Result<Material, LoadError> {
        object.ignore(&[
            "diffuse_reflectance_sampling_rate",
            "main_specular_sampling_rate",
            "clearcoat_sampling_rate",
            "spec_trans_sampling_rate",
        ]);
        let base_color = self.reflectance(object, "base_color", ColorTexture::Constant(Rgb::splat(0.5)))?;
        let metallic = self.number_in(object, "metallic", 0.0, 0.0..=1.0)?;
        let roughness = self.number_in(object, "roughness", 0.5, 0.0..=1.0)?;
        let spec_tint = self.number_in(object, "spec_tint", 0.0, 0.0..=1.0)?;
        let sheen = self.number_in(object, "sheen", 0.0, 0.0..=1.0)?;
        let sheen_tint = self.number_in(object, "sheen_tint", 0.0, 0.0..=1.0)?;
        let anisotropic = match self.number_in(object, "anisotropic", 0.0, 0.0..=1.0)? {
            FloatTexture::Constant(anisotropic) => anisotropic,
            texture => {
                self.warn(object, "a texture for `anisotropic` of `principled` is drawn as its mean");
                texture.mean(&self.scene.textures)
            }
        };
        let zero = FloatTexture::Constant(0.0);
        if self.number_in(object, "spec_trans", 0.0, 0.0..=1.0)? != zero {
            self.warn(
                object,
                "`principled` is drawn without its `spec_trans`: it is opaque (`roughdielectric` is glass)",
            );
        }
        if self.number_in(object, "flatness", 0.0, 0.0..=1.0)? != zero {
            self.warn(object, "`principled` is drawn without its `flatness`");
        }
        let eta = self.principled_index(object)? as f32;
        let surface =
            Material::Principled { base_color, metallic, roughness, anisotropic, eta, spec_tint, sheen, sheen_tint };
        let weight = self.number_in(object, "clearcoat", 0.0, 0.0..=1.0)?;
        let gloss = self.number_in(object, "clearcoat_gloss", 0.0, 0.0..=1.0)?;
        if weight == zero {
            return Ok(surface);
        }
        let name = object.id.clone().unwrap_or_else(|| format!("principled:{}", object.place.line));
        let coat = self.push_material(Material::ClearCoat { gloss }, format!("{name} (clear coat)"));
        let base = self.push_material(surface, name);
        Ok(Material::Coat { added: true, weight, coat, base })
    }

    /// From `specular` or `eta`.
    fn principled_index(&self, object: &Object) -> Result<f64, LoadError> {
        match (object.number("specular")?, object.number("eta")?) {
            (Some(_), Some(_)) => Err(object.error("give either `specular` or `eta`")),
            (None, Some(eta)) if (1.0..=100.0).contains(&eta) => Ok(eta.max(LEAST_INDEX)),
            (None, Some(eta)) => Err(object.error(format!("`eta` must lie between 1 and 100, but is {eta}"))),
            (specular, None) => match specular.unwrap_or(0.5) {
                s if (0.0..=1.0).contains(&s) => Ok(index(s.max(LEAST_SPECULAR))),
                s => Err(object.error(format!("`specular` must lie between 0 and 1, but is {s}"))),
            },
        }
    }
}
