//! `bsdf` plugins of ours: the models of `brdf-tables` that Mitsuba has no plugin for (`sheen`, `lafortune`, …), by the
//! names and keys of their recipes, with `diffuse_reflectance` and `specular_reflectance` for kd and ks.

use super::Builder;
use super::object::Object;
use crate::scene::load::error::LoadError;
use crate::scene::{ColorTexture, Material, Rgb};
use brdf_tables::brdf::{Key, Kind, Model, Value, Values};

/// Whether there is such a model.
pub(super) fn is_model(plugin: &str) -> bool {
    Model::find(plugin).is_some()
}

impl Builder<'_> {
    /// A model by its recipe.
    pub(super) fn lobe(&mut self, object: &Object) -> Result<Material, LoadError> {
        let constant = |v| ColorTexture::Constant(Rgb::splat(v));
        let diffuse = self.reflectance(object, "diffuse_reflectance", constant(0.0))?;
        let specular = self.reflectance(object, "specular_reflectance", constant(1.0))?;
        let mut values = Values::default();
        for key in Model::find(&object.plugin).map_or(&[][..], |m| m.keys) {
            if let Some(value) = value(object, key)? {
                values.0.push((key.name, value));
            }
        }
        let recipe = brdf_tables::Material::from_values(&object.plugin, &values);
        let recipe = recipe.map_err(|e| object.error(format!("{}: {e}", object.plugin)))?;
        let none = || object.error(format!("`{}` has no specular part", object.plugin));
        Ok(Material::Lobe { diffuse, specular, model: recipe.specular.ok_or_else(none)? })
    }
}

/// What a scene says of one key of a recipe.
fn value(object: &Object, key: &Key) -> Result<Option<Value>, LoadError> {
    Ok(match &key.kind {
        Kind::Number { .. } => object.number(key.name)?.map(Value::Number),
        Kind::Color { .. } => object.color(key.name)?.map(|c| Value::Color(c.to_array().map(f64::from))),
        Kind::Lobes => object.text(key.name)?.map(|text| lobes(object, key, text)).transpose()?,
        Kind::Word(words) => match object.text(key.name)? {
            None => None,
            Some(text) => {
                let word = words.iter().find(|word| **word == text);
                let refused = || object.error(format!("`{}` must be {}, not `{text}`", key.name, key.kind.describe()));
                Some(Value::Word(word.ok_or_else(refused)?))
            }
        },
    })
}

/// Lobes as text: four numbers each, divided by blanks or commas, with a semicolon between lobes.
fn lobes(object: &Object, key: &Key, text: &str) -> Result<Value, LoadError> {
    let refused = || object.error(format!("`{}` must be lobes \"cx cy cz n; …\", not `{text:.80}`", key.name));
    let lobe = |part: &str| {
        let numbers: Result<Vec<f64>, _> =
            part.split([' ', ',', '\t', '\n', '\r']).filter(|w| !w.is_empty()).map(str::parse).collect();
        numbers.ok().and_then(|n| <[f64; 4]>::try_from(n).ok()).ok_or_else(refused)
    };
    let parts = text.trim().trim_end_matches(';').split(';');
    parts.map(lobe).collect::<Result<Vec<_>, _>>().map(Value::Lobes)
}
