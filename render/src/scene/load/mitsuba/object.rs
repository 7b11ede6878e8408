//! A plugin with named parameters, each noted when it is read.

use super::objects::{ObjectId, Objects};
use crate::scene::Rgb;
use crate::scene::load::error::{LoadError, Place};
use glam::{DAffine3, DVec3};
use std::cell::Cell;

/// Value of a parameter.
#[derive(Clone, Debug)]
pub enum Value {
    /// `float` or `integer`.
    Number(f64),
    /// `boolean`.
    Boolean(bool),
    /// `string`.
    Text(String),
    /// `rgb`, `srgb`, `spectrum`, `blackbody`.
    Color(Rgb),
    /// `point`, `vector`.
    Vector(DVec3),
    /// `transform`.
    Transform(DAffine3),
}

/// A named value.
pub struct Parameter {
    /// Name in snake_case.
    pub name: String,
    /// Its value.
    pub value: Value,
    pub(super) place: Place,
    pub(super) used: Cell<bool>,
}

/// A nested or referenced plugin.
pub struct Child {
    pub(super) name: Option<String>,
    pub(super) object: ObjectId,
    pub(super) place: Place,
    pub(super) used: Cell<bool>,
}

/// A plugin: `<bsdf type="phong">` has class `bsdf` and plugin `phong`.
pub struct Object {
    /// Tag of the element.
    pub class: String,
    /// Type attribute.
    pub plugin: String,
    /// Id attribute.
    pub id: Option<String>,
    /// Where it stands.
    pub place: Place,
    pub(super) parameters: Vec<Parameter>,
    pub(super) children: Vec<Child>,
    pub(super) visited: Cell<bool>,
}

impl Object {
    /// An error at this object.
    pub fn error(&self, what: impl Into<String>) -> LoadError {
        LoadError::Element { place: self.place.clone(), what: what.into() }
    }

    /// A parameter, which counts as used from now on.
    pub fn parameter(&self, name: &str) -> Option<&Parameter> {
        self.visited.set(true);
        let found = self.parameters.iter().find(|p| p.name == name);
        found.inspect(|p| p.used.set(true))
    }

    /// Takes note of parameters that do not concern the picture.
    pub fn ignore(&self, names: &[&str]) {
        for name in names {
            self.parameter(name);
        }
    }

    fn typed<T>(&self, name: &str, kind: &str, get: impl Fn(&Value) -> Option<T>) -> Result<Option<T>, LoadError> {
        self.parameter(name).map(|p| get(&p.value).ok_or_else(|| p.error(format!("{kind} is needed")))).transpose()
    }

    /// A number.
    pub fn number(&self, name: &str) -> Result<Option<f64>, LoadError> {
        self.typed(name, "a number", |v| if let Value::Number(x) = v { Some(*x) } else { None })
    }

    /// A number, or `default`.
    pub fn number_or(&self, name: &str, default: f64) -> Result<f64, LoadError> {
        Ok(self.number(name)?.unwrap_or(default))
    }

    /// A whole number of 0 … 2³² − 1, or `default`.
    pub fn count_or(&self, name: &str, default: u32) -> Result<u32, LoadError> {
        let Some(value) = self.number(name)? else { return Ok(default) };
        if value.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(&value) {
            return Ok(value as u32);
        }
        Err(self.error(format!("`{name}` must be a whole number ≥ 0, not {value}")))
    }

    /// A boolean, or `default`.
    pub fn boolean_or(&self, name: &str, default: bool) -> Result<bool, LoadError> {
        let found = self.typed(name, "true or false", |v| if let Value::Boolean(x) = v { Some(*x) } else { None });
        Ok(found?.unwrap_or(default))
    }

    /// A string.
    pub fn text(&self, name: &str) -> Result<Option<&str>, LoadError> {
        let Some(p) = self.parameter(name) else { return Ok(None) };
        if let Value::Text(text) = &p.value { Ok(Some(text)) } else { Err(p.error("a string is needed")) }
    }

    /// A string, if there is one; it does not count as used.
    pub fn peek(&self, name: &str) -> Option<&str> {
        let found = self.parameters.iter().find(|p| p.name == name);
        found.and_then(|p| if let Value::Text(text) = &p.value { Some(text.as_str()) } else { None })
    }

    /// A string that must be there.
    pub fn require_text(&self, name: &str) -> Result<&str, LoadError> {
        self.text(name)?.ok_or_else(|| self.error(format!("the parameter `{name}` is missing")))
    }

    /// A point or vector.
    pub fn vector(&self, name: &str) -> Result<Option<DVec3>, LoadError> {
        self.typed(name, "a point or vector", |v| if let Value::Vector(x) = v { Some(*x) } else { None })
    }

    /// A transform, or the identity.
    pub fn transform(&self, name: &str) -> Result<DAffine3, LoadError> {
        let found = self.typed(name, "a transform", |v| if let Value::Transform(x) = v { Some(*x) } else { None });
        Ok(found?.unwrap_or(DAffine3::IDENTITY))
    }

    /// A colour, or a number standing for a grey.
    pub fn color(&self, name: &str) -> Result<Option<Rgb>, LoadError> {
        self.typed(name, "a colour", |v| match v {
            Value::Color(c) => Some(*c),
            Value::Number(x) => Some(Rgb::splat(*x as f32)),
            _ => None,
        })
    }

    /// Nested or referenced objects of a class, which count as used from now on, with their names.
    pub fn children_of<'a>(
        &'a self,
        objects: &'a Objects,
        class: &'a str,
    ) -> impl Iterator<Item = (ObjectId, Option<&'a str>)> {
        self.visited.set(true);
        let children = self.children.iter().filter(move |c| objects[c.object].class == class);
        children.inspect(|c| c.used.set(true)).map(|c| (c.object, c.name.as_deref()))
    }

    /// The nested or referenced object of a name, which counts as used from now on.
    pub fn child_named(&self, name: &str) -> Option<ObjectId> {
        self.visited.set(true);
        let found = self.children.iter().find(|c| c.name.as_deref() == Some(name));
        found.inspect(|c| c.used.set(true)).map(|c| c.object)
    }
}

impl Parameter {
    /// An error at this parameter.
    pub fn error(&self, what: impl Into<String>) -> LoadError {
        LoadError::Element { place: self.place.clone(), what: what.into() }
    }
}
