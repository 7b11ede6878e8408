//! Numbers and colours as scene text writes them.

use super::xml::Element;
use crate::image::from_srgb;
use crate::scene::Rgb;
use crate::scene::load::color::{self, Weighting};
use crate::scene::load::error::{FileError, LoadError, read_file};
use crate::scene::load::files::Folders;
use crate::scene::load::text;
use std::path::Path;

/// A finite number; an `f` after its last digit, as programmers write it, is no part of it.
pub fn real(text: &str) -> Result<f64, String> {
    let word = text.trim();
    let digits = word.strip_suffix(['f', 'F']).filter(|w| w.ends_with(|c: char| c.is_ascii_digit() || c == '.'));
    let value: f64 = digits.unwrap_or(word).parse().map_err(|_| format!("`{text}` is not a number"))?;
    if value.is_finite() { Ok(value) } else { Err(format!("`{text}` is not finite")) }
}

/// Numbers separated by blanks or commas.
pub fn numbers(text: &str) -> Result<Vec<f64>, String> {
    words(text).map(real).collect()
}

fn words(text: &str) -> impl Iterator<Item = &str> {
    text.split(|c: char| c == ',' || c.is_whitespace()).filter(|w| !w.is_empty())
}

/// `true` or `false`, in capitals or not.
pub fn boolean(text: &str) -> Result<bool, String> {
    match text.trim().to_ascii_lowercase().as_str() {
        "true" | "1" => Ok(true),
        "false" | "0" => Ok(false),
        _ => Err(format!("`{text}` is neither true nor false")),
    }
}

/// What a colour is for; decides how spectra become RGB.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ColorContext {
    /// The parent is an emitter: the value is radiance, not reflectance.
    pub emitter: bool,
    /// The file is of version 0.x, whose RGB mode never weights with an illuminant.
    pub legacy: bool,
    /// The value may exceed 1 (index of refraction, absorption).
    pub unbounded: bool,
}

/// An `rgb`, `srgb`, `spectrum` or `blackbody` element as linear sRGB.
pub fn color(element: &Element, context: ColorContext, folders: &Folders) -> Result<Rgb, LoadError> {
    let error = |what: String| element.error(what);
    match element.tag.as_str() {
        "rgb" => triple(element.require("value")?).map_err(error),
        "srgb" => triple(element.require("value")?).map_err(error).map(|c| Rgb::from(c.to_array().map(from_srgb))),
        "blackbody" => {
            let temperature = element.require("temperature")?.trim_end_matches(['k', 'K']);
            let temperature = real(temperature).map_err(error)?;
            if temperature <= 0.0 {
                return Err(element.error("a temperature above 0 K is needed"));
            }
            let scale = element.attribute("scale").map_or(Ok(1.0), real).map_err(error)?;
            Ok(color::blackbody(temperature) * scale as f32)
        }
        _ => {
            let samples = match (element.attribute("value"), element.attribute("filename")) {
                (Some(value), None) if value.contains(':') => pairs(value).map_err(error)?,
                (Some(value), None) => return constant(value, context).map_err(error),
                (None, Some(name)) => {
                    let file = &element.place.file;
                    table(&folders.resolve(file, name)).map_err(|error| {
                        let error = folders.advise(file, name, error);
                        LoadError::Asset { place: element.place.clone(), error }
                    })?
                }
                _ => return Err(element.error("a spectrum needs either `value` or `filename`")),
            };
            if samples.windows(2).any(|w| w[0].0 >= w[1].0) {
                return Err(element.error("the wavelengths must increase"));
            }
            let weighting =
                if context.emitter || context.legacy { Weighting::EqualEnergy } else { Weighting::Daylight };
            let rgb = color::from_samples(&samples, weighting);
            Ok(if context.emitter || context.unbounded || context.legacy { rgb } else { rgb.min(Rgb::ONE) })
        }
    }
}

/// One number, three numbers or `#rrggbb`.
fn triple(text: &str) -> Result<Rgb, String> {
    if let Some(hex) = text.trim().strip_prefix('#') {
        let valid = hex.len() == 6 && hex.bytes().all(|b| b.is_ascii_hexdigit());
        let code = valid.then(|| u32::from_str_radix(hex, 16).ok()).flatten();
        let code = code.ok_or_else(|| format!("`{text}` is not of the form #rrggbb"))?;
        return Ok(Rgb::from([16, 8, 0].map(|shift| (code >> shift & 255) as f32 / 255.0)));
    }
    match numbers(text)?.as_slice() {
        &[v] => Ok(Rgb::splat(v as f32)),
        &[r, g, b] => Ok(Rgb::new(r as f32, g as f32, b as f32)),
        v => Err(format!("a colour has 1 or 3 numbers, not {}", v.len())),
    }
}

/// A spectrum of one number. For reflectances, and everywhere in version 0.x, it is a grey; Mitsuba 3 takes an
/// emitter's as an equal-energy spectrum, whose linear sRGB is not grey.
fn constant(text: &str, context: ColorContext) -> Result<Rgb, String> {
    match numbers(text)?.as_slice() {
        &[v] if context.emitter && !context.legacy => Ok(color::from_xyz([v; 3])),
        &[v] => Ok(Rgb::splat(v as f32)),
        &[r, g, b] if context.legacy => Ok(Rgb::new(r as f32, g as f32, b as f32)),
        v => Err(format!("a spectrum is one number or wavelength:value pairs, not {} numbers", v.len())),
    }
}

fn pairs(text: &str) -> Result<Vec<(f64, f64)>, String> {
    let pair = |word: &str| {
        let (wavelength, value) = word.split_once(':').ok_or_else(|| format!("`{word}` is not wavelength:value"))?;
        Ok((real(wavelength)?, real(value)?))
    };
    words(text).map(pair).collect()
}

/// A file of `wavelength value` lines; `#` starts a comment.
fn table(path: &Path) -> Result<Vec<(f64, f64)>, FileError> {
    let text = text::decode(&read_file(path, 1 << 24)?, path)?;
    let mut samples = Vec::new();
    for (i, line) in text.lines().enumerate() {
        let line = line.split('#').next().unwrap_or_default();
        match numbers(line).map_err(|e| FileError::at(path, i + 1, e))?.as_slice() {
            [] => {}
            &[wavelength, value] => samples.push((wavelength, value)),
            v => return Err(FileError::at(path, i + 1, format_args!("expected 2 numbers, found {}", v.len()))),
        }
    }
    Ok(samples)
}
