//! Scene text as a tree of elements: includes spliced in, parameters substituted, every element with its place.

use crate::scene::load::error::{FileError, LoadError, Place, read_file};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Larger scene files are refused; geometry belongs in mesh files.
const MAX_FILE: u64 = 1 << 28;
/// Deeper nesting is refused: the tree is walked recursively.
const MAX_DEPTH: usize = 64;
/// Files included in all, so that includes that include twice cannot grow without end.
const MAX_INCLUDES: usize = 10_000;
/// Longest attribute value after substitution.
const MAX_VALUE: usize = 1 << 20;

/// An XML element after substitution.
pub struct Element {
    /// Name of the tag.
    pub tag: String,
    /// Attributes in order.
    pub attributes: Vec<(String, String)>,
    /// Child elements; `default` and `include` have been carried out.
    pub children: Vec<Element>,
    /// Where it stands.
    pub place: Place,
}

impl Element {
    /// Value of an attribute.
    pub fn attribute(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|(n, _)| n == name).map(|(_, v)| v.as_str())
    }

    /// Value of an attribute that must be there.
    pub fn require(&self, name: &str) -> Result<&str, LoadError> {
        self.attribute(name).ok_or_else(|| self.error(format!("the attribute `{name}` is missing")))
    }

    /// An error at this element.
    pub fn error(&self, what: impl Into<String>) -> LoadError {
        LoadError::Element { place: self.place.clone(), what: what.into() }
    }
}

/// A scene file with everything it includes.
pub struct Document {
    /// The `scene` element.
    pub root: Element,
    /// Folders in which file names are looked up: the scene's own first, then those of `path` elements.
    pub folders: Vec<PathBuf>,
    /// Parameters given by the caller that the scene does not mention.
    pub unused_defines: Vec<String>,
}

/// Reads scene text. `defines` win over the file's own `default`s.
pub fn read(path: &Path, defines: &[(String, String)]) -> Result<Document, LoadError> {
    let folder = path.parent().map(Path::to_path_buf).unwrap_or_default();
    let values = defines.iter().map(|(name, value)| (name.clone(), Parameter { value: value.clone(), used: false }));
    let mut reader = Reader { values: values.collect(), folders: vec![folder], stack: Vec::new(), includes: 0 };
    let root = reader.file(path)?;
    let unused = defines.iter().map(|(name, _)| name).filter(|name| !reader.values[*name].used);
    Ok(Document { root, unused_defines: unused.cloned().collect(), folders: reader.folders })
}

struct Parameter {
    value: String,
    used: bool,
}

struct Reader {
    values: BTreeMap<String, Parameter>,
    folders: Vec<PathBuf>,
    /// Files being read, canonical: the outermost first.
    stack: Vec<PathBuf>,
    includes: usize,
}

impl Reader {
    fn file(&mut self, path: &Path) -> Result<Element, LoadError> {
        let bytes = read_file(path, MAX_FILE)?;
        let text = String::from_utf8(bytes).map_err(|_| FileError::new(path, "not UTF-8 text"))?;
        let xml = roxmltree::Document::parse(&text).map_err(|e| FileError::at(path, e.pos().row as usize, e))?;
        let canonical = path.canonicalize().map_err(|e| FileError::new(path, e))?;
        self.stack.push(canonical);
        let source = Source { file: path.into(), text: &text, lines: line_starts(&text) };
        let root = self.element(xml.root_element(), &source, 0)?;
        self.stack.pop();
        if root.tag != "scene" {
            return Err(root.error("not a Mitsuba scene: the outermost element must be <scene>"));
        }
        Ok(root)
    }

    fn element(&mut self, node: roxmltree::Node, source: &Source, depth: usize) -> Result<Element, LoadError> {
        let place = source.place(node);
        let error = |what: String| LoadError::Element { place: place.clone(), what };
        if depth > MAX_DEPTH {
            return Err(error(format!("more than {MAX_DEPTH} elements inside each other")));
        }
        let mut attributes = Vec::new();
        for attribute in node.attributes() {
            let value = self.substitute(attribute.value()).map_err(error)?;
            attributes.push((attribute.name().to_string(), value));
        }
        let mut element = Element { tag: node.tag_name().name().into(), attributes, children: Vec::new(), place };
        for child in node.children().filter(roxmltree::Node::is_element) {
            let child = self.element(child, source, depth + 1)?;
            match child.tag.as_str() {
                "default" => self.default(&child)?,
                "include" => element.children.extend(self.include(&child, source)?.children),
                "path" => {
                    let folder = source.folder().join(child.require("value")?);
                    self.folders.push(folder);
                }
                _ => element.children.push(child),
            }
        }
        Ok(element)
    }

    /// A parameter that is set already, by the caller or by an earlier `default`, keeps its value.
    fn default(&mut self, element: &Element) -> Result<(), LoadError> {
        let (name, value) = (element.require("name")?, element.require("value")?);
        let parameter = self.values.entry(name.into()).or_insert_with(|| Parameter { value: value.into(), used: true });
        parameter.used = true;
        Ok(())
    }

    fn include(&mut self, element: &Element, source: &Source) -> Result<Element, LoadError> {
        let name = Path::new(element.require("filename")?);
        let path = resolve(&self.folders, &source.file, name);
        self.includes += 1;
        if self.includes > MAX_INCLUDES {
            return Err(element.error(format!("more than {MAX_INCLUDES} files included")));
        }
        if path.canonicalize().is_ok_and(|c| self.stack.contains(&c)) {
            return Err(element.error(format!("{} includes itself", path.display())));
        }
        self.file(&path).map_err(|e| match e {
            LoadError::File(source) if source.line.is_none() => {
                LoadError::Asset { place: element.place.clone(), source }
            }
            other => other,
        })
    }

    /// Puts the values of parameters in place of `$name`.
    fn substitute(&mut self, value: &str) -> Result<String, String> {
        let mut parts = value.split('$');
        let mut out = parts.next().unwrap_or_default().to_string();
        for part in parts {
            let end = part.find(|c: char| !(c.is_alphanumeric() || c == '_')).unwrap_or(part.len());
            let (name, rest) = part.split_at(end);
            let parameter = self.values.get_mut(name);
            let parameter = parameter
                .ok_or_else(|| format!("the parameter ${name} has no value: add a <default> or give -D {name}=…"))?;
            parameter.used = true;
            out += &parameter.value;
            out += rest;
            if out.len() > MAX_VALUE {
                return Err(format!("the value grows beyond {MAX_VALUE} bytes"));
            }
        }
        Ok(out)
    }
}

/// `name` in the first of `folders` that holds it, or beside `file`, where it is named; the first folder if it is
/// nowhere, so that the error names a sensible path.
pub fn resolve(folders: &[PathBuf], file: &Path, name: &Path) -> PathBuf {
    let beside = file.parent().map(Path::to_path_buf);
    let mut candidates = folders.iter().chain(&beside).map(|f| f.join(name));
    candidates.find(|p| p.exists()).unwrap_or_else(|| folders[0].join(name))
}

struct Source<'a> {
    file: Arc<Path>,
    text: &'a str,
    lines: Vec<usize>,
}

fn line_starts(text: &str) -> Vec<usize> {
    std::iter::once(0).chain(text.match_indices('\n').map(|(i, _)| i + 1)).collect()
}

impl Source<'_> {
    fn folder(&self) -> &Path {
        self.file.parent().unwrap_or(Path::new(""))
    }

    fn place(&self, node: roxmltree::Node) -> Place {
        let start = node.range().start;
        let line = self.lines.partition_point(|&l| l <= start);
        let column = self.text[self.lines[line - 1]..start].chars().count() + 1;
        let mut element = format!("<{}", node.tag_name().name());
        for name in ["type", "name", "id"] {
            if let Some(value) = node.attribute(name) {
                element += &format!(" {name}=\"{}\"", value.chars().take(80).collect::<String>());
            }
        }
        element.push('>');
        Place { file: self.file.clone(), line: line as u32, column: column as u32, element: element.into() }
    }
}
