//! Indices of refraction: of metals by name or number, of dielectrics likewise.

use super::Builder;
use super::object::{Object, Value};
use crate::scene::load::color::conductor;
use crate::scene::load::error::LoadError;
use crate::scene::{ColorTexture, Rgb};

impl Builder<'_> {
    /// eta and k over the index outside. Version 0.x defaults to copper in air, version 3 to a perfect mirror.
    pub(super) fn metal(&mut self, object: &Object) -> Result<(ColorTexture, ColorTexture), LoadError> {
        let mut given = |name: &str| -> Result<Option<ColorTexture>, LoadError> {
            let is_given = object.child_named(name).is_some() || object.parameter(name).is_some();
            let zero = ColorTexture::Constant(Rgb::ZERO);
            is_given.then(|| self.color_texture(object, name, zero)).transpose()
        };
        let (eta, k) = (given("eta")?, given("k")?);
        let material = object.text("material")?;
        if material.is_some() && (eta.is_some() || k.is_some()) {
            return Err(object.error("give either `material` or `eta` and `k`"));
        }
        let name = material.unwrap_or(if self.objects.legacy && eta.is_none() && k.is_none() { "Cu" } else { "none" });
        let preset = conductor(name).ok_or_else(|| object.error(format!("no such conductor: `{name}`")))?;
        let outside = if self.objects.legacy && name != "none" || eta.is_some() {
            ior(object, "ext_eta", if self.objects.legacy { "air" } else { "vacuum" })?
        } else {
            1.0
        };
        let relative = |given: Option<ColorTexture>, preset| {
            given.unwrap_or(ColorTexture::Constant(preset)).times(Rgb::splat(1.0 / outside))
        };
        Ok((relative(eta, preset.0), relative(k, preset.1)))
    }
}

/// Index of refraction given as a number or as the name of a dielectric.
pub(super) fn ior(object: &Object, name: &str, default: &str) -> Result<f32, LoadError> {
    let text = match object.parameter(name).map(|p| &p.value) {
        Some(Value::Number(_)) => {
            let value = object.number_or(name, 1.0)?;
            if value <= 0.0 {
                return Err(object.error(format!("an index of refraction of {value}")));
            }
            return Ok(value as f32);
        }
        Some(_) => object.require_text(name)?.to_ascii_lowercase(),
        None => default.to_string(),
    };
    let found = DIELECTRICS.iter().find(|(n, _)| *n == text);
    found.map(|(_, ior)| *ior).ok_or_else(|| object.error(format!("no such dielectric: `{text}`")))
}

/// Indices of refraction at 589 nm (Hecht, Optics, 4th edition), under Mitsuba's names.
#[rustfmt::skip]
const DIELECTRICS: [(&str, f32); 23] = [
    ("vacuum", 1.0), ("helium", 1.000036), ("hydrogen", 1.000132), ("air", 1.000277), ("carbon dioxide", 1.00045),
    ("water", 1.333), ("acetone", 1.36), ("ethanol", 1.361), ("carbon tetrachloride", 1.461), ("glycerol", 1.4729),
    ("benzene", 1.501), ("silicone oil", 1.52045), ("bromine", 1.661), ("water ice", 1.31), ("fused quartz", 1.458),
    ("pyrex", 1.47), ("acrylic glass", 1.49), ("polypropylene", 1.49), ("bk7", 1.5046), ("sodium chloride", 1.544),
    ("amber", 1.55), ("pet", 1.575), ("diamond", 2.419),
];
