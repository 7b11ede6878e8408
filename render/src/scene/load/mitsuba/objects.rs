//! All plugins of a scene file as objects, references resolved.

use super::object::{Child, Object, Parameter, Value};
use super::transform;
use super::value::{self, ColorContext};
use super::xml::{Document, Element};
use crate::scene::load::error::{FileError, LoadError};
use crate::scene::load::files::Folders;
use std::cell::Cell;
use std::collections::HashMap;
use std::path::PathBuf;

/// Index into [`Objects`].
pub type ObjectId = usize;

/// All plugins of a scene; the last one is the scene itself.
pub struct Objects {
    list: Vec<Object>,
    folders: Folders,
    /// Whether the file is of version 0.x.
    pub legacy: bool,
}

impl std::ops::Index<ObjectId> for Objects {
    type Output = Object;
    fn index(&self, id: ObjectId) -> &Object {
        &self.list[id]
    }
}

/// `ref` elements wait here until every id is known: (object, index of the child, id).
type References = Vec<(ObjectId, usize, String)>;

impl Objects {
    /// Turns the elements of a document into objects.
    pub fn new(document: Document) -> Result<Self, LoadError> {
        let legacy = document.version.0 == 0;
        let mut objects = Self { list: Vec::new(), folders: document.folders, legacy };
        let (mut references, mut aliases) = (Vec::new(), Vec::new());
        objects.add(&document.root, &mut references, &mut aliases)?;
        objects.link(references, aliases)?;
        objects.refuse_cycles()?;
        Ok(objects)
    }

    /// The scene.
    pub fn root(&self) -> ObjectId {
        self.list.len() - 1
    }

    /// Path of a file that an object names.
    pub fn path(&self, object: &Object, name: &str) -> PathBuf {
        self.folders.resolve(&object.place.file, name)
    }

    /// An error of a file that an object names, with what it may be called instead, where it is missing.
    pub fn asset(&self, object: &Object, name: &str, error: FileError) -> LoadError {
        let error = self.folders.advise(&object.place.file, name, error);
        LoadError::Asset { place: object.place.clone(), error }
    }

    fn add<'a>(
        &mut self,
        element: &'a Element,
        references: &mut References,
        aliases: &mut Vec<&'a Element>,
    ) -> Result<ObjectId, LoadError> {
        let class = element.tag.clone();
        let plugin = if class == "scene" { "scene" } else { element.require("type")? }.to_string();
        let (mut parameters, mut children) = (Vec::new(), Vec::new());
        let mut pending = Vec::new();
        for child in &element.children {
            let name = child.attribute("name").map(snake_case);
            match child.tag.as_str() {
                "ref" => {
                    pending.push((children.len(), child.require("id")?.to_string()));
                    let place = child.place.clone();
                    children.push(Child { name, object: usize::MAX, place, used: Cell::new(false) });
                }
                "alias" => aliases.push(child),
                tag if is_class(tag) || child.attribute("type").is_some() => {
                    let object = self.add(child, references, aliases)?;
                    children.push(Child { name, object, place: child.place.clone(), used: Cell::new(false) });
                }
                _ => {
                    let name = name.ok_or_else(|| child.error("the attribute `name` is missing"))?;
                    let value = self.value(child, &name, element)?;
                    if parameters.iter().any(|p: &Parameter| p.name == name) {
                        return Err(child.error(format!("the parameter `{name}` is given twice")));
                    }
                    parameters.push(Parameter { name, value, place: child.place.clone(), used: Cell::new(false) });
                }
            }
        }
        let id = element.attribute("id").map(String::from);
        let object = self.list.len();
        references.extend(pending.into_iter().map(|(child, id)| (object, child, id)));
        let place = element.place.clone();
        self.list.push(Object { class, plugin, id, place, parameters, children, visited: Cell::new(false) });
        Ok(object)
    }

    fn value(&self, element: &Element, name: &str, parent: &Element) -> Result<Value, LoadError> {
        let error = |what: String| element.error(what);
        Ok(match element.tag.as_str() {
            "float" | "integer" => Value::Number(value::real(element.require("value")?).map_err(error)?),
            "boolean" => Value::Boolean(value::boolean(element.require("value")?).map_err(error)?),
            "string" => Value::Text(element.require("value")?.into()),
            "point" | "vector" => Value::Vector(transform::vector(element, 0.0)?),
            "transform" => Value::Transform(transform::parse(element)?),
            "rgb" | "srgb" | "spectrum" | "blackbody" => {
                let context = ColorContext {
                    emitter: parent.tag == "emitter",
                    legacy: self.legacy,
                    unbounded: matches!(name, "eta" | "k"),
                };
                let color = value::color(element, context, &self.folders)?;
                if color.min_element() < 0.0 || !color.is_finite() {
                    return Err(element.error(format!("a colour is not negative, but this is {color}")));
                }
                Value::Color(color)
            }
            "animation" => return Err(element.error("animated transforms are not supported")),
            other => return Err(element.error(format!("no such element: `{other}`"))),
        })
    }

    fn link(&mut self, references: References, aliases: Vec<&Element>) -> Result<(), LoadError> {
        let mut ids: HashMap<String, ObjectId> = HashMap::new();
        for (i, object) in self.list.iter().enumerate() {
            if let Some(id) = &object.id
                && ids.insert(id.clone(), i).is_some()
            {
                let what = format!("the id `{id}` is used twice");
                return Err(LoadError::Element { place: object.place.clone(), what });
            }
        }
        for alias in aliases {
            let (id, new) = (alias.require("id")?, alias.require("as")?);
            let target = *ids.get(id).ok_or_else(|| alias.error(format!("nothing has the id `{id}`")))?;
            ids.insert(new.into(), target);
        }
        for (object, child, id) in references {
            let child = &mut self.list[object].children[child];
            let target = ids.get(&id).copied();
            child.object = target.ok_or_else(|| LoadError::Element {
                place: child.place.clone(),
                what: format!("nothing has the id `{id}`"),
            })?;
        }
        Ok(())
    }

    /// Walks the references depth first; an object met again on its own path refers to itself.
    fn refuse_cycles(&self) -> Result<(), LoadError> {
        #[derive(Clone, Copy, PartialEq)]
        enum Mark {
            New,
            OnPath,
            Done,
        }
        let mut marks = vec![Mark::New; self.list.len()];
        for start in 0..self.list.len() {
            if marks[start] != Mark::New {
                continue;
            }
            // The path from `start`, each with the index of its next child.
            let mut path = vec![(start, 0)];
            marks[start] = Mark::OnPath;
            while let Some((object, next)) = path.last_mut() {
                let Some(child) = self.list[*object].children.get(*next) else {
                    marks[*object] = Mark::Done;
                    path.pop();
                    continue;
                };
                *next += 1;
                match marks[child.object] {
                    Mark::OnPath => {
                        let what = "refers to an object that contains this reference".into();
                        return Err(LoadError::Element { place: child.place.clone(), what });
                    }
                    Mark::New => {
                        marks[child.object] = Mark::OnPath;
                        path.push((child.object, 0));
                    }
                    Mark::Done => {}
                }
                if path.len() > 1000 {
                    return Err(LoadError::Element {
                        place: self.list[start].place.clone(),
                        what: "more than 1000 objects inside each other".into(),
                    });
                }
            }
        }
        Ok(())
    }

    /// One line for every object that was read while some of its parameters or children were not.
    pub fn unused(&self) -> Vec<String> {
        let mut warnings = Vec::new();
        for object in self.list.iter().filter(|o| o.visited.get()) {
            let parameters = object.parameters.iter().filter(|p| !p.used.get()).map(|p| (&p.place, p.name.as_str()));
            let children = object.children.iter().filter(|c| !c.used.get());
            let children = children.map(|c| (&c.place, c.name.as_deref().unwrap_or(&self.list[c.object].plugin)));
            for (place, name) in parameters.chain(children) {
                warnings.push(format!("{place}: `{name}` has no effect in `{}`", object.plugin));
            }
        }
        warnings
    }
}

fn is_class(tag: &str) -> bool {
    matches!(
        tag,
        "bsdf"
            | "shape"
            | "emitter"
            | "sensor"
            | "film"
            | "rfilter"
            | "sampler"
            | "integrator"
            | "texture"
            | "medium"
            | "phase"
            | "volume"
            | "subsurface"
    )
}

/// `toWorld` → `to_world`, `intIOR` → `int_ior`: version 0.x writes camelCase, version 3 snake_case.
fn snake_case(name: &str) -> String {
    let mut out = String::with_capacity(name.len() + 4);
    let mut previous_lower = false;
    for c in name.chars() {
        if c.is_ascii_uppercase() && previous_lower {
            out.push('_');
        }
        previous_lower = c.is_ascii_lowercase();
        out.push(c.to_ascii_lowercase());
    }
    out
}
