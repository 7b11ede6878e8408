//! Spectra given as plugins: `<spectrum type="irregular" …>`.

use super::object::Object;
use super::value::{numbers, real};
use crate::scene::Rgb;
use crate::scene::load::color::{self, Weighting};
use crate::scene::load::error::LoadError;

/// Most samples of a spectrum with even steps.
const MAX_SAMPLES: usize = 1 << 16;

/// Linear sRGB of a spectrum that is its own plugin; `None` for other plugins.
pub fn spectrum(object: &Object, emitter: bool) -> Result<Option<Rgb>, LoadError> {
    let error = |what: String| object.error(what);
    let list = |name: &str| numbers(object.require_text(name)?).map_err(error);
    let samples: Vec<(f64, f64)> = match object.plugin.as_str() {
        "blackbody" => {
            let temperature = match object.text("temperature") {
                Ok(Some(text)) => real(text.trim_end_matches(['k', 'K'])).map_err(error)?,
                _ => object.number("temperature")?.unwrap_or(0.0),
            };
            if temperature <= 0.0 {
                return Err(object.error("a temperature above 0 K is needed"));
            }
            object.ignore(&["wavelength_min", "wavelength_max"]);
            return Ok(Some(color::blackbody(temperature) * object.number_or("scale", 1.0)? as f32));
        }
        "irregular" => {
            let (wavelengths, values) = (list("wavelengths")?, list("values")?);
            if wavelengths.len() != values.len() {
                return Err(error(format!("{} wavelengths, but {} values", wavelengths.len(), values.len())));
            }
            wavelengths.into_iter().zip(values).collect()
        }
        "regular" => {
            let values = list("values")?;
            let (first, last) =
                (object.number_or("wavelength_min", 360.0)?, object.number_or("wavelength_max", 830.0)?);
            if !(2..=MAX_SAMPLES).contains(&values.len()) {
                return Err(error(format!("2 to {MAX_SAMPLES} values are needed, not {}", values.len())));
            }
            let step = (last - first) / (values.len() - 1) as f64;
            values.into_iter().enumerate().map(|(i, v)| (first + step * i as f64, v)).collect()
        }
        _ => return Ok(None),
    };
    if samples.is_empty() || samples.windows(2).any(|w| w[0].0 >= w[1].0) {
        return Err(object.error("the wavelengths must increase"));
    }
    let rgb = color::from_samples(&samples, if emitter { Weighting::EqualEnergy } else { Weighting::Daylight });
    if rgb.min_element() < 0.0 || !rgb.is_finite() {
        return Err(object.error(format!("a colour is not negative, but this is {rgb}")));
    }
    Ok(Some(if emitter { rgb } else { rgb.min(Rgb::ONE) }))
}
