//! A material: a Lambertian part, which needs no table, and a specular part at unit strength, coloured at run time.

mod error;

use crate::brdf::{Brdf, Key, Model, Presence, Specular, Value, Values};
use core::f64::consts::FRAC_1_PI;
use core::fmt;
use glam::{DVec2, DVec3};
use serde::{Deserialize, Serialize};

pub use error::MaterialError;

/// f_r = kd/π + ks · specular · tint, per channel. Decoding one does not check it: call [`Material::validate`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Material {
    /// Albedo of the Lambertian part, RGB.
    pub kd: [f64; 3],
    /// Strength of the specular part, RGB; without effect when there is none.
    pub ks: [f64; 3],
    /// Specular part.
    pub specular: Option<Specular>,
}

/// Name of the model without specular part.
const LAMBERT: &str = "lambert";
const LAMBERT_KEYS: [Key; 1] = [Key::color("reflectance", 0.0, 1.0, Presence::Required)];
const COMMON_KEYS: [Key; 2] = [
    Key::color("ks", 0.0, 1.0, Presence::Default(Value::Color([1.0; 3]))),
    Key::color("kd", 0.0, 1.0, Presence::Default(Value::Color([0.0; 3]))),
];
/// The albedo at normal incidence is computed to about this, and refused only beyond.
const ENERGY_TOLERANCE: f64 = 1e-3;

/// The keys that a recipe of this `model` accepts.
///
/// # Errors
/// [`MaterialError::Model`].
pub fn keys(model: &str) -> Result<Vec<Key>, MaterialError> {
    if model == LAMBERT {
        return Ok(LAMBERT_KEYS.to_vec());
    }
    Model::find(model)
        .map(|m| [m.keys, &COMMON_KEYS].concat())
        .ok_or_else(|| MaterialError::Model { name: model.into(), known: model_names() })
}

/// Names of all models that a recipe can have.
pub fn model_names() -> Vec<&'static str> {
    let mut names = vec![LAMBERT];
    names.extend(crate::brdf::ALL.iter().map(|m| m.recipe));
    names.dedup();
    names
}

impl Material {
    /// A Lambertian material.
    pub fn lambert(reflectance: [f64; 3]) -> Self {
        Self { kd: reflectance, ks: [0.0; 3], specular: None }
    }

    /// A purely specular material at unit strength.
    pub fn specular(specular: Specular) -> Self {
        Self { kd: [0.0; 3], ks: [1.0; 3], specular: Some(specular) }
    }

    /// The material a recipe describes: `values` of the keys that [`keys`] lists for `model`, defaults filled in.
    ///
    /// # Errors
    /// The model is unknown, a key without default is absent, two exclude each other, or [`Material::validate`] refuses the result.
    pub fn from_values(model: &str, values: &Values) -> Result<Self, MaterialError> {
        let mut values = values.clone();
        for key in keys(model)? {
            match (values.get(key.name), &key.presence) {
                (Some(value), _) => key.check(value)?,
                (None, Presence::Default(value)) => values.0.push((key.name, value.clone())),
                (None, Presence::Required) => return Err(MaterialError::Missing { key: key.name }),
                (None, Presence::Optional) => {}
            }
        }
        let material = match Model::find(model) {
            None => Self::lambert(values.color("reflectance")?),
            Some(m) => Self { kd: values.color("kd")?, ks: values.color("ks")?, specular: Some((m.build)(&values)?) },
        };
        material.validate().map(|()| material)
    }

    /// Model name and values of the recipe of this material.
    pub fn values(&self) -> (&'static str, Values) {
        let Some(specular) = &self.specular else {
            return (LAMBERT, Values(vec![("reflectance", Value::Color(self.kd))]));
        };
        let (model, mut values) = specular.values();
        values.0.push(("ks", Value::Color(self.ks)));
        values.0.push(("kd", Value::Color(self.kd)));
        (model, values)
    }

    /// Checks every parameter against the range of its key, and the energy at normal incidence but of measured materials.
    ///
    /// The albedo away from the normal is left alone: Ward 1992 and published Lafortune fits pass 1 at grazing.
    ///
    /// # Errors
    /// The first thing found wrong.
    pub fn validate(&self) -> Result<(), MaterialError> {
        // What was measured is what it is: it has no recipe, its values were checked when they were read, and instruments do
        // report more light than there was.
        if let Some(Specular::Measured(_)) = &self.specular {
            let values = Values(vec![("ks", Value::Color(self.ks)), ("kd", Value::Color(self.kd))]);
            return COMMON_KEYS
                .iter()
                .try_for_each(|key| values.get(key.name).map_or(Ok(()), |value| key.check(value)));
        }
        let (model, values) = self.values();
        for key in keys(model)? {
            values.get(key.name).map_or(Ok(()), |value| key.check(value))?;
        }
        let albedo = self.normal_albedo();
        match (0..3).find(|&c| albedo[c] > 1.0 + ENERGY_TOLERANCE) {
            Some(c) => Err(MaterialError::Energy { channel: ['r', 'g', 'b'][c], albedo: albedo[c] }),
            None => Ok(()),
        }
    }

    /// f_r(wi, wo) in sr⁻¹, RGB, without the cosine; 0 where either direction is below the horizon.
    pub fn eval(&self, wi: DVec3, wo: DVec3) -> [f64; 3] {
        if wi.z <= 0.0 || wo.z <= 0.0 {
            return [0.0; 3];
        }
        let diffuse = self.kd.map(|kd| kd * FRAC_1_PI);
        let Some(specular) = &self.specular else { return diffuse };
        let (strength, tint) = (specular.eval(wi, wo), specular.tint(wi, wo));
        core::array::from_fn(|c| diffuse[c] + self.ks[c] * strength * tint[c])
    }

    /// Albedo at normal incidence: the mean of f_r cos/pdf over a regular grid of the model's own sampler.
    fn normal_albedo(&self) -> [f64; 3] {
        const GRID: (usize, usize) = (256, 8);
        let mut albedo = self.kd;
        let Some(specular) = &self.specular else { return albedo };
        for at in 0..GRID.0 * GRID.1 {
            let cell = DVec2::new((at / GRID.1) as f64, (at % GRID.1) as f64) + 0.5;
            let Some(wi) = specular.sample(DVec3::Z, cell / DVec2::new(GRID.0 as f64, GRID.1 as f64)) else { continue };
            let weight = specular.eval(wi, DVec3::Z) * wi.z / specular.pdf(wi, DVec3::Z) / (GRID.0 * GRID.1) as f64;
            let tint = specular.tint(wi, DVec3::Z);
            for c in 0..3 {
                albedo[c] += self.ks[c] * weight * tint[c];
            }
        }
        albedo
    }

    /// One canonical line that parses back to the same material, e.g. `phong:exponent=100,ks=1,kd=0`.
    pub fn recipe_text(&self) -> String {
        self.to_string()
    }
}

impl fmt::Display for Material {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (model, values) = self.values();
        for (at, (key, value)) in values.0.iter().enumerate() {
            let before = if at == 0 { format!("{model}:") } else { ",".into() };
            write!(f, "{before}{key}=")?;
            match value {
                Value::Number(x) => write!(f, "{x}")?,
                Value::Color([r, g, b]) if r == g && g == b => write!(f, "{r}")?,
                Value::Color(rgb) => write!(f, "{rgb:?}")?,
                Value::Lobes(lobes) => write!(f, "{lobes:?}")?,
                Value::Word(word) => f.write_str(word)?,
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::brdf::{ALL, MAX_LOBES};

    fn config() -> impl bincode::config::Config {
        bincode::config::standard().with_limit::<4096>()
    }

    #[test]
    fn every_model_survives_bincode() {
        for specular in ALL.iter().flat_map(|model| (model.examples)()) {
            let material = Material { kd: [0.1, 0.0, 0.2], ks: [0.5, 0.6, 0.7], specular: Some(specular) };
            let bytes = bincode::serde::encode_to_vec(material, config()).unwrap();
            let (back, used) = bincode::serde::decode_from_slice::<Material, _>(&bytes, config()).unwrap();
            assert_eq!((back, used), (material, bytes.len()));
        }
    }

    /// Lobes are checked where they are decoded: no count or coefficient gets past [`crate::brdf::Lafortune::new`].
    #[test]
    fn bad_lobes_do_not_decode() {
        let decode = |lobes: Vec<[f64; 4]>| {
            let bytes = bincode::serde::encode_to_vec(lobes, config()).unwrap();
            bincode::serde::decode_from_slice::<crate::brdf::Lafortune, _>(&bytes, config())
        };
        assert!(decode(vec![[-1.0, -1.0, 1.0, 9.0]; MAX_LOBES]).is_ok());
        for bad in [vec![], vec![[-1.0, -1.0, 1.0, 9.0]; MAX_LOBES + 1], vec![[f64::NAN, 0.0, 0.0, 9.0]]] {
            assert!(decode(bad).is_err());
        }
    }

    #[test]
    fn parts_add_up() {
        let specular = (ALL[0].examples)()[0];
        let material = Material { kd: [0.3, 0.2, 0.1], ks: [0.5, 0.0, 0.25], specular: Some(specular) };
        let (wi, wo) = (crate::frame::spherical(0.4, 0.1), crate::frame::spherical(0.6, 2.9));
        let strength = specular.eval(wi, wo);
        for (c, f) in material.eval(wi, wo).into_iter().enumerate() {
            assert!((f - (material.kd[c] * FRAC_1_PI + material.ks[c] * strength)).abs() < 1e-15);
        }
        assert_eq!(material.eval(-wi, wo), [0.0; 3]);
        assert_eq!(Material::lambert([0.5; 3]).eval(wi, wo), [0.5 * FRAC_1_PI; 3]);
    }
}
