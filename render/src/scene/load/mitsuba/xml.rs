//! Scene text as a tree of elements: includes spliced in, parameters substituted, every element with its place.

use super::upgrade::{Version, upgrade};
use crate::scene::load::error::{FileError, LoadError, Place, brief, read_file};
use crate::scene::load::files::Folders;
use crate::scene::load::text;
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
/// Bytes of all values that parameters are put into, so that a few long ones cannot be used without end.
const MAX_SUBSTITUTED: usize = 1 << 26;

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

    /// Changes an attribute that is there.
    pub fn set(&mut self, name: &str, value: &str) {
        self.attributes.iter_mut().filter(|(n, _)| n == name).for_each(|(_, v)| *v = value.into());
    }

    /// A new element that stands where this one does.
    pub fn child(&self, tag: &str, attributes: &[(&str, &str)]) -> Self {
        let attributes = attributes.iter().map(|(n, v)| (n.to_string(), v.to_string())).collect();
        Self { tag: tag.into(), attributes, children: Vec::new(), place: self.place.clone() }
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
    /// Version of the scene file, included files aside.
    pub version: Version,
    /// Where files are looked up.
    pub folders: Folders,
    /// The scene file and those that it includes.
    pub files: Vec<PathBuf>,
    /// What the reader should know: one line each.
    pub warnings: Vec<String>,
    /// Parameters given by the caller that the scene does not mention.
    pub unused_defines: Vec<String>,
}

/// Reads scene text. `defines` win over the file's own `default`s.
pub fn read(path: &Path, defines: &[(String, String)]) -> Result<Document, LoadError> {
    let folder = path.parent().map(Path::to_path_buf).unwrap_or_default();
    let values = defines.iter().map(|(name, value)| (name.clone(), Parameter { value: value.clone(), used: false }));
    let mut reader = Reader {
        values: values.collect(),
        folders: Folders(vec![folder]),
        stack: Vec::new(),
        files: Vec::new(),
        includes: 0,
        bytes: 0,
        substituted: 0,
        version: (3, 0),
        warnings: Vec::new(),
    };
    let root = reader.file(path)?;
    if root.tag != "scene" {
        return Err(root.error("not a Mitsuba scene: the outermost element must be <scene>"));
    }
    let unused = defines.iter().map(|(name, _)| name).filter(|name| !reader.values[*name].used);
    let unused_defines = unused.cloned().collect();
    let Reader { version, folders, files, warnings, .. } = reader;
    Ok(Document { root, version, folders, files, warnings, unused_defines })
}

struct Parameter {
    value: String,
    used: bool,
}

struct Reader {
    values: BTreeMap<String, Parameter>,
    folders: Folders,
    files: Vec<PathBuf>,
    /// Files being read, canonical: the outermost first.
    stack: Vec<PathBuf>,
    includes: usize,
    /// Bytes of text, in all files.
    bytes: usize,
    /// Bytes of values that parameters were put into.
    substituted: usize,
    /// Version of the outermost file.
    version: Version,
    warnings: Vec<String>,
}

impl Reader {
    fn file(&mut self, path: &Path) -> Result<Element, LoadError> {
        let text = text::decode(&read_file(path, MAX_FILE)?, path)?;
        self.files.push(path.into());
        self.bytes += text.len();
        if self.bytes as u64 > MAX_FILE {
            let what = format!("with it the scene is longer than the {MAX_FILE} bytes accepted");
            return Err(FileError::new(path, what).into());
        }
        let xml = roxmltree::Document::parse(&text).map_err(|e| FileError::at(path, e.pos().row as usize, e))?;
        let canonical = path.canonicalize().map_err(|e| FileError::new(path, e))?;
        let root = xml.root_element();
        let mut source = Source { file: path.into(), text: &text, lines: line_starts(&text), version: self.version };
        source.version = self.version(root, &source)?;
        if self.stack.is_empty() {
            self.version = source.version;
        }
        self.stack.push(canonical);
        let root = self.element(root, &source, 0)?;
        self.stack.pop();
        Ok(root)
    }

    /// The version that a file states. One that states none has that of the file that includes it, or the one that its
    /// spelling tells.
    fn version(&mut self, root: roxmltree::Node, source: &Source) -> Result<Version, LoadError> {
        let place = source.place(root);
        let Some(text) = root.attribute("version") else {
            if self.stack.is_empty() && root.tag_name().name() == "scene" {
                self.version = spelling(root);
                let (major, minor) = self.version;
                self.warnings.push(format!("{place}: no version is given: read as version {major}.{minor}"));
            }
            return Ok(self.version);
        };
        let mut numbers = text.trim().split('.').map(|n| n.parse::<u32>().ok());
        match (numbers.next().flatten(), numbers.next().flatten().unwrap_or(0)) {
            (Some(0), minor @ 3..) => {
                if minor == 3 && self.stack.is_empty() {
                    let what = format!("{place}: version {} is read by Mitsuba's rules of upgrade", brief(text));
                    self.warnings.push(what);
                }
                Ok((0, minor))
            }
            (Some(major @ (2 | 3)), minor) => Ok((major, minor)),
            _ => {
                let what = format!("version `{text}` (0.3 to 0.6, 2.x and 3.x are supported)");
                Err(LoadError::Element { place, what })
            }
        }
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
                "include" => match self.include(&child, source)? {
                    // Anything but a scene stands for itself.
                    root if root.tag != "scene" => element.children.push(root),
                    scene => element.children.extend(scene.children),
                },
                "path" => {
                    let folder = source.folder().join(child.require("value")?.replace('\\', "/"));
                    self.folders.0.push(folder);
                }
                _ => element.children.push(child),
            }
        }
        upgrade(&mut element, source.version);
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
        let name = element.require("filename")?;
        let path = self.folders.resolve(&source.file, name);
        self.includes += 1;
        if self.includes > MAX_INCLUDES {
            return Err(element.error(format!("more than {MAX_INCLUDES} files included")));
        }
        if path.canonicalize().is_ok_and(|c| self.stack.contains(&c)) {
            return Err(element.error(format!("{} includes itself", path.display())));
        }
        self.file(&path).map_err(|e| match e {
            LoadError::File(error) if error.line.is_none() => {
                let error = self.folders.advise(&source.file, name, error);
                LoadError::Asset { place: element.place.clone(), error }
            }
            other => other,
        })
    }

    /// Puts the values of parameters in place of `$name`, the longest name that is known first, as Mitsuba does: `$na`
    /// is the value of `n` with an `a` after it where there is no `na`. `\$` is a dollar sign.
    fn substitute(&mut self, value: &str) -> Result<String, String> {
        let mut out = String::new();
        let mut rest = value;
        while let Some(at) = rest.find('$') {
            let (before, after) = (&rest[..at], &rest[at + 1..]);
            if let Some(before) = before.strip_suffix('\\') {
                out += before;
                out.push('$');
                rest = after;
                continue;
            }
            out += before;
            let known = self.values.iter_mut().filter(|(name, _)| !name.is_empty() && after.starts_with(name.as_str()));
            let Some((name, parameter)) = known.max_by_key(|(name, _)| name.len()) else {
                let end = after.find(|c: char| !(c.is_alphanumeric() || c == '_')).unwrap_or(after.len());
                let name = brief(&after[..end]);
                return Err(format!("the parameter ${name} has no value: add a <default> or give -D {name}=…"));
            };
            parameter.used = true;
            out += &parameter.value;
            rest = &after[name.len()..];
            if out.len() > MAX_VALUE {
                return Err(format!("the value grows beyond {MAX_VALUE} bytes"));
            }
        }
        out += rest;
        if rest.len() < value.len() {
            self.substituted += out.len();
        }
        if self.substituted > MAX_SUBSTITUTED {
            return Err(format!("the values of all parameters grow beyond {MAX_SUBSTITUTED} bytes"));
        }
        Ok(out)
    }
}

/// The version that names tell: of elements that were renamed with 0.4, or camelCase, which version 2 gave up.
fn spelling(root: roxmltree::Node) -> Version {
    let elements = || root.descendants().filter(roxmltree::Node::is_element);
    let camel = |name: &str| name.as_bytes().windows(2).any(|w| w[0].is_ascii_lowercase() && w[1].is_ascii_uppercase());
    if elements().any(|e| matches!(e.tag_name().name(), "camera" | "luminaire")) {
        (0, 3)
    } else if elements().any(|e| camel(e.tag_name().name()) || e.attribute("name").is_some_and(camel)) {
        (0, 6)
    } else {
        (3, 0)
    }
}

struct Source<'a> {
    file: Arc<Path>,
    text: &'a str,
    lines: Vec<usize>,
    version: Version,
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
                element += &format!(" {name}=\"{}\"", brief(value.chars().take(80).collect::<String>()));
            }
        }
        element.push('>');
        Place { file: self.file.clone(), line: line as u32, column: column as u32, element: element.into() }
    }
}
