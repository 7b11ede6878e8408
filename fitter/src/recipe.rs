//! A material from what a person types: an inline recipe, `phong:exponent=100,ks=1,kd=0`, a TOML file, or measured data.
//!
//! Both forms have the same keys, and the inline form is rewritten to TOML, one item per line, before it is parsed.

use crate::measured;
use brdf_tables::brdf::{Key, Kind, Value, Values};
use brdf_tables::material::{Material, MaterialError, keys};
use brdf_tables::measured::ReadError;
use core::fmt;
use std::io::{self, Read};
use std::path::Path;
use toml::de::{DeTable, DeValue};

/// Longest recipe, in bytes.
const MAX_BYTES: u64 = 64 * 1024;

/// Where in the input an error is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// File name, or the inline recipe itself.
    pub source: String,
    /// Line of a file from 1; item of an inline recipe from 1, where 0 is the model's name.
    pub line: Option<usize>,
    /// Whether `source` is the recipe itself.
    pub inline: bool,
}

/// Why there is no material.
#[derive(Debug, thiserror::Error)]
pub enum RecipeError {
    /// The file cannot be read.
    #[error("{file}: {source}")]
    Read {
        /// Its name.
        file: String,
        /// What the system says.
        source: io::Error,
    },
    /// The recipe is longer than 64 KiB.
    #[error("{file}: a recipe has at most 64 KiB")]
    TooLong {
        /// Name of the file, or start of the inline recipe.
        file: String,
    },
    /// Not TOML, or not `key=value`.
    #[error("{place}: {message}")]
    Syntax {
        /// Where.
        place: Place,
        /// What was expected.
        message: String,
    },
    /// A key that the model does not have.
    #[error("{place}: unknown key {key:?} ({accepted})")]
    UnknownKey {
        /// Where.
        place: Place,
        /// The key.
        key: String,
        /// What the model takes.
        accepted: String,
    },
    /// A file of measured data that cannot be read.
    #[error(transparent)]
    Measured(#[from] ReadError),
    /// A value that the model does not accept, or the lack of one.
    #[error("{place}: {error} ({accepted})")]
    Material {
        /// Where.
        place: Place,
        /// What is wrong.
        error: MaterialError,
        /// What the model takes.
        accepted: String,
    },
    /// A lone word that is no material: it is as likely the name of a file.
    #[error("{0}; nor is there a file of this name")]
    NoFile(Box<Self>),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.inline, self.line) {
            (false, Some(line)) => write!(f, "{}:{line}", self.source),
            (false, None) => f.write_str(&self.source),
            (true, Some(item)) if item > 0 => write!(f, "{:?}, item {item}", self.source),
            (true, _) => write!(f, "{:?}", self.source),
        }
    }
}

/// The material that a command-line argument names: measured data if it ends as they do, a TOML file if there is one of this
/// name or the name ends in `.toml`, an inline recipe otherwise.
///
/// # Errors
/// The file or the recipe is bad; the message is one line that names the place and the accepted keys.
pub fn material(argument: &str) -> Result<Material, RecipeError> {
    if measured::is_data(argument) {
        return Ok(measured::load(Path::new(argument))?.1);
    }
    if argument.ends_with(".toml") || Path::new(argument).is_file() {
        return from_file(argument);
    }
    inline(argument).map_err(|error| match error {
        RecipeError::Material { .. } if !argument.contains([':', '=']) => RecipeError::NoFile(error.into()),
        error => error,
    })
}

/// As [`material`], with lines about what was measured.
///
/// # Errors
/// As [`material`].
pub fn material_with_notes(argument: &str) -> Result<(Material, Vec<String>), RecipeError> {
    if measured::is_data(argument) {
        let (_, material, notes) = measured::load(Path::new(argument))?;
        return Ok((material, notes));
    }
    Ok((material(argument)?, Vec::new()))
}

/// The material of a TOML recipe.
fn from_file(file: &str) -> Result<Material, RecipeError> {
    let read = |source| RecipeError::Read { file: file.into(), source };
    let metadata = std::fs::metadata(file).map_err(read)?;
    if !metadata.is_file() {
        return Err(read(io::Error::other("not a regular file")));
    }
    if metadata.len() > MAX_BYTES {
        return Err(RecipeError::TooLong { file: file.into() });
    }
    let mut bytes = Vec::new();
    std::fs::File::open(file).and_then(|f| f.take(MAX_BYTES).read_to_end(&mut bytes)).map_err(read)?;
    from_bytes(file, &bytes)
}

/// The material of the bytes of a TOML recipe; `file` is its name in messages. A byte order mark is skipped.
///
/// # Errors
/// The recipe is bad; the message is one line that names the place and the accepted keys.
pub fn from_bytes(file: &str, bytes: &[u8]) -> Result<Material, RecipeError> {
    let place = |line| Place { source: file.into(), line, inline: false };
    let bytes = bytes.strip_prefix(&[0xef, 0xbb, 0xbf]).unwrap_or(bytes);
    let text = core::str::from_utf8(bytes).map_err(|error| {
        let line = 1 + bytes[..error.valid_up_to()].iter().filter(|b| **b == b'\n').count();
        RecipeError::Syntax { place: place(Some(line)), message: "not UTF-8 text".into() }
    })?;
    parse(text, &place)
}

/// The material of an inline recipe.
fn inline(argument: &str) -> Result<Material, RecipeError> {
    if argument.len() as u64 > MAX_BYTES {
        return Err(RecipeError::TooLong { file: argument.chars().take(40).collect() });
    }
    let place =
        |line: Option<usize>| Place { source: argument.into(), line: line.map(|l| l.saturating_sub(1)), inline: true };
    let syntax = |line, message: &str| RecipeError::Syntax { place: place(line), message: message.into() };
    if argument.contains(char::is_control) {
        return Err(syntax(None, "control character"));
    }
    let (model, items) = argument.split_once(':').unwrap_or((argument, ""));
    let mut text = format!("model = {}\n", quoted(model));
    for (at, item) in split(items).into_iter().enumerate() {
        let (key, value) = item.split_once('=').ok_or_else(|| syntax(Some(at + 2), "expected key=value"))?;
        let (key, value) = (key.trim(), value.trim());
        let is_word = value.starts_with(|c: char| c.is_ascii_alphabetic());
        let value = if is_word { quoted(value) } else { value.into() };
        text.push_str(&format!("{key} = {value}\n"));
    }
    parse(&text, &place)
}

/// `text`, which holds no control character, as a TOML string.
fn quoted(text: &str) -> String {
    format!("\"{}\"", text.replace('\\', "\\\\").replace('"', "\\\""))
}

/// Items between the commas that are outside brackets.
fn split(items: &str) -> Vec<&str> {
    if items.trim().is_empty() {
        return Vec::new();
    }
    let mut depth = 0i32;
    items
        .split(|c| {
            depth += i32::from(c == '[') - i32::from(c == ']');
            c == ',' && depth <= 0
        })
        .collect()
}

/// The material of a TOML text; `place` names a line of it.
fn parse(text: &str, place: &dyn Fn(Option<usize>) -> Place) -> Result<Material, RecipeError> {
    let line = |offset: usize| Some(1 + text[..offset.min(text.len())].matches('\n').count());
    let table = DeTable::parse(text).map_err(|e| RecipeError::Syntax {
        place: place(e.span().and_then(|span| line(span.start))),
        message: e.message().replace('\n', " "),
    })?;
    let table = table.get_ref();
    let lines: Vec<_> = table.keys().map(|key| (key.get_ref().as_ref(), line(key.span().start))).collect();
    let line_of = |key: &str| lines.iter().find(|(name, _)| *name == key).and_then(|(_, line)| *line);

    // The model decides which keys there may be.
    let refuse = |key: Option<&str>, error, accepted: &str| RecipeError::Material {
        place: place(key.and_then(line_of)),
        error,
        accepted: accepted.into(),
    };
    let models = "model = \"…\" chooses the formula";
    let model = table.get("model").ok_or_else(|| refuse(None, MaterialError::Missing { key: "model" }, models))?;
    let model = model.get_ref().as_str().ok_or_else(|| {
        refuse(Some("model"), MaterialError::Kind { key: "model", expected: "a string".into() }, models)
    })?;
    let keys = keys(model).map_err(|error| match error {
        MaterialError::Model { name, known } => MaterialError::Model { name: shortened(&name), known },
        error => error,
    });
    let keys = keys.map_err(|e| refuse(Some("model"), e, models))?;
    let accepted = format!("{model} takes {}", keys.iter().map(|key| key.name).collect::<Vec<_>>().join(", "));

    // Each value must have the type of its key.
    let mut values = Values::default();
    for (name, value) in table {
        let name = name.get_ref().as_ref();
        if name == "model" {
            continue;
        }
        let key = keys.iter().find(|key| key.name == name).ok_or_else(|| RecipeError::UnknownKey {
            place: place(line_of(name)),
            key: shortened(name),
            accepted: accepted.clone(),
        })?;
        let value = convert(key, value.get_ref()).ok_or_else(|| {
            refuse(Some(name), MaterialError::Kind { key: key.name, expected: key.kind.describe() }, &accepted)
        })?;
        values.0.push((key.name, value));
    }
    Material::from_values(model, &values).map_err(|e| refuse(e.key(), e, &accepted))
}

/// The start of what a file says, for a message.
fn shortened(text: &str) -> String {
    const MOST: usize = 40;
    if text.chars().count() <= MOST { text.into() } else { text.chars().take(MOST).chain(['…']).collect() }
}

/// A TOML value as the type of its key; `None` for another type.
fn convert(key: &Key, value: &DeValue) -> Option<Value> {
    match &key.kind {
        Kind::Number { .. } => number(value).map(Value::Number),
        Kind::Color { .. } => {
            number(value).map(|x| [x; 3]).or_else(|| value.as_array().and_then(numbers)).map(Value::Color)
        }
        Kind::Lobes => {
            let lobes = value.as_array()?.iter().map(|lobe| lobe.get_ref().as_array().and_then(numbers));
            lobes.collect::<Option<Vec<_>>>().map(Value::Lobes)
        }
        Kind::Word(words) => words.iter().find(|word| value.as_str() == Some(word)).map(|word| Value::Word(word)),
    }
}

/// Exactly N numbers.
fn numbers<const N: usize>(array: &toml::de::DeArray) -> Option<[f64; N]> {
    array.iter().map(|x| number(x.get_ref())).collect::<Option<Vec<_>>>()?.try_into().ok()
}

/// A TOML integer or float.
fn number(value: &DeValue) -> Option<f64> {
    match value {
        DeValue::Integer(i) => i64::from_str_radix(i.as_str(), i.radix()).ok().map(|i| i as f64),
        DeValue::Float(x) => x.as_str().parse().ok(),
        _ => None,
    }
}
