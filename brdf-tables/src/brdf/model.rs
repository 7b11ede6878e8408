//! What a recipe may say about a model.

use super::{ALL, Specular, lafortune};
use crate::material::MaterialError;

/// Range of a roughness: below it f32 cannot resolve the lobe, above it the distributions stop being lobes.
pub(super) const ALPHA: (f64, f64) = (1e-3, 1.0);

/// One entry of [`ALL`].
pub struct Model {
    /// Unique name of the family and variant.
    pub name: &'static str,
    /// The `model` of a recipe; entries that share it are variants chosen by a key, and share the keys.
    pub recipe: &'static str,
    /// Where the formula was published.
    pub source: &'static str,
    /// Keys of the recipe beside those of every material.
    pub keys: &'static [Key],
    /// Builds the model from the values of its keys.
    pub build: fn(&Values) -> Result<Specular, MaterialError>,
    /// Instances that span the ranges.
    pub examples: fn() -> Vec<Specular>,
    /// Properties that the published formula does not have.
    pub exceptions: &'static [Exception],
}

/// A property expected of every model which a named one lacks by its definition.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exception {
    /// The albedo exceeds 1 towards grazing.
    AlbedoAboveOne,
}

/// One key of a recipe.
#[derive(Clone, Debug)]
pub struct Key {
    /// Name.
    pub name: &'static str,
    /// What it holds.
    pub kind: Kind,
    /// What happens when it is absent.
    pub presence: Presence,
}

/// Type and range of a recipe's value; the ranges are closed.
#[derive(Clone, Debug)]
pub enum Kind {
    /// One number.
    Number {
        /// Smallest value.
        min: f64,
        /// Largest value.
        max: f64,
    },
    /// A number for all channels, or three.
    Color {
        /// Smallest value of a channel.
        min: f64,
        /// Largest value of a channel.
        max: f64,
    },
    /// A list of [Cx, Cy, Cz, n].
    Lobes,
    /// One of some words.
    Word(&'static [&'static str]),
}

/// Whether a key may be absent.
#[derive(Clone, Debug)]
pub enum Presence {
    /// It may not.
    Required,
    /// The model is built without it (or with another key instead).
    Optional,
    /// This value stands in.
    Default(Value),
}

/// A value of a recipe.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// One number.
    Number(f64),
    /// RGB.
    Color([f64; 3]),
    /// Lafortune lobes [Cx, Cy, Cz, n].
    Lobes(Vec<[f64; 4]>),
    /// A choice.
    Word(&'static str),
}

/// The values of a recipe, in the order they are printed in.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Values(pub Vec<(&'static str, Value)>);

impl Model {
    /// The entry of [`ALL`] that builds `model = "recipe"`.
    pub fn find(recipe: &str) -> Option<&'static Model> {
        ALL.iter().find(|m| m.recipe == recipe)
    }
}

impl Key {
    /// A number within `[min, max]`.
    pub(crate) const fn number(name: &'static str, min: f64, max: f64, presence: Presence) -> Self {
        Self { name, kind: Kind::Number { min, max }, presence }
    }

    /// A colour with channels within `[min, max]`.
    pub(crate) const fn color(name: &'static str, min: f64, max: f64, presence: Presence) -> Self {
        Self { name, kind: Kind::Color { min, max }, presence }
    }

    /// Refuses a value of another kind, out of range, or not finite.
    pub(crate) fn check(&self, value: &Value) -> Result<(), MaterialError> {
        let key = self.name;
        let within = |x: f64, min: f64, max: f64| {
            (min..=max).contains(&x).then_some(()).ok_or(MaterialError::Range { key, value: x, min, max })
        };
        match (&self.kind, value) {
            (Kind::Number { min, max }, Value::Number(x)) => within(*x, *min, *max),
            (Kind::Color { min, max }, Value::Color(rgb)) => rgb.iter().try_for_each(|&x| within(x, *min, *max)),
            (Kind::Lobes, Value::Lobes(lobes)) => lafortune::check(key, lobes),
            (Kind::Word(words), Value::Word(word)) if words.contains(word) => Ok(()),
            _ => Err(MaterialError::Kind { key, expected: self.kind.describe() }),
        }
    }
}

impl Kind {
    /// What the key holds, for messages.
    pub fn describe(&self) -> String {
        match self {
            Kind::Number { min, max } => format!("a number in {min}..={max}"),
            Kind::Color { min, max } => format!("a number or [r, g, b] in {min}..={max}"),
            Kind::Lobes => "a list of lobes [cx, cy, cz, n]".into(),
            Kind::Word(words) => format!("\"{}\"", words.join("\" or \"")),
        }
    }
}

impl Values {
    /// The value of `key`.
    pub fn get(&self, key: &str) -> Option<&Value> {
        self.0.iter().find(|(name, _)| *name == key).map(|(_, value)| value)
    }

    /// The number under `key`.
    ///
    /// # Errors
    /// [`MaterialError::Missing`], here and below.
    pub fn number(&self, key: &'static str) -> Result<f64, MaterialError> {
        self.read(key, |value| if let Value::Number(x) = value { Some(*x) } else { None })
    }

    /// The colour under `key`.
    pub fn color(&self, key: &'static str) -> Result<[f64; 3], MaterialError> {
        self.read(key, |value| if let Value::Color(rgb) = value { Some(*rgb) } else { None })
    }

    /// The lobes under `key`.
    pub fn lobes(&self, key: &'static str) -> Result<&[[f64; 4]], MaterialError> {
        self.read(key, |value| if let Value::Lobes(lobes) = value { Some(&lobes[..]) } else { None })
    }

    /// The word under `key`.
    pub fn word(&self, key: &'static str) -> Result<&'static str, MaterialError> {
        self.read(key, |value| if let Value::Word(word) = value { Some(*word) } else { None })
    }

    fn read<'a, T>(&'a self, key: &'static str, of: impl Fn(&'a Value) -> Option<T>) -> Result<T, MaterialError> {
        self.get(key).and_then(of).ok_or(MaterialError::Missing { key })
    }
}
