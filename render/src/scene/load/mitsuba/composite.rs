//! Materials made of others, and the textures that bend their normals.

use super::Builder;
use super::object::Object;
use super::texture::Decode;
use super::value::numbers;
use crate::scene::load::error::LoadError;
use crate::scene::{ColorTexture, FloatTexture, Material, MaterialId, Rgb, TextureId};

impl Builder<'_> {
    /// Materials nested in another one, in order.
    pub(super) fn nested(&mut self, object: &Object) -> Result<Vec<MaterialId>, LoadError> {
        let inside: Vec<_> = object.children_of(self.objects, "bsdf").map(|(id, _)| id).collect();
        inside.into_iter().map(|id| self.material(id)).collect()
    }

    pub(super) fn inner(&mut self, object: &Object) -> Result<MaterialId, LoadError> {
        match self.nested(object)?.as_slice() {
            &[inner] => Ok(inner),
            other => Err(object.error(format!("one bsdf inside is needed, not {}", other.len()))),
        }
    }

    pub(super) fn two_sided(&mut self, object: &Object) -> Result<Material, LoadError> {
        match self.nested(object)?.as_slice() {
            &[both] => Ok(Material::TwoSided { front: both, back: both }),
            &[front, back] => Ok(Material::TwoSided { front, back }),
            other => Err(object.error(format!("one or two bsdfs inside are needed, not {}", other.len()))),
        }
    }

    /// Texture and factor of a height field; version 0.x scales it by a `scale` texture around it.
    pub(super) fn height(&mut self, object: &Object) -> Result<(TextureId, f32), LoadError> {
        let (mut id, mut factor) = (self.inner_texture(object)?, 1.0);
        let objects = self.objects;
        while objects[id].plugin == "scale" {
            factor *= objects[id].number_or("scale", 1.0)? as f32;
            id = self.inner_texture(&objects[id])?;
        }
        Ok((self.texture(id, Decode::Scalar)?, factor))
    }

    /// Weights w₁ … wₙ as nested blends; what is missing to a sum of 1 is black.
    pub(super) fn mixture(&mut self, object: &Object) -> Result<Material, LoadError> {
        let weights = numbers(object.require_text("weights")?).map_err(|e| object.error(e))?;
        let mut parts = self.nested(object)?;
        let sum: f64 = weights.iter().sum();
        if parts.is_empty() || parts.len() != weights.len() || weights.iter().any(|w| *w < 0.0) || sum <= 0.0 {
            let what = format!("{} weights ≥ 0 are needed, one for each bsdf inside", parts.len());
            return Err(object.error(what));
        }
        if sum > 1.0 + 1e-6 {
            self.warn(object, format_args!("the weights add up to {sum}: they are divided by that, as Mitsuba does"));
        }
        let mut weights: Vec<f64> = weights.iter().map(|w| w / sum.max(1.0)).collect();
        if sum < 1.0 - 1e-6 {
            let black = Material::Diffuse { reflectance: ColorTexture::Constant(Rgb::ZERO) };
            parts.push(self.push_material(black, "black".into()));
            weights.push(1.0 - sum);
        }
        // From the end: the first of the rest has the share w / (sum of the rest).
        let (mut rest, mut rest_weight) = (parts[parts.len() - 1], weights[weights.len() - 1]);
        let mut whole = Material::Blend { weight: FloatTexture::Constant(0.0), first: rest, second: rest };
        for i in (0..parts.len() - 1).rev() {
            let total = weights[i] + rest_weight;
            let share = if total > 0.0 { rest_weight / total } else { 0.0 };
            whole = Material::Blend { weight: FloatTexture::Constant(share as f32), first: parts[i], second: rest };
            rest_weight = total;
            if i > 0 {
                rest = self.push_material(whole.clone(), format!("mixture:{}", object.place.line));
            }
        }
        Ok(whole)
    }
}
