//! The header of a PLY file: which elements follow, and how their numbers are stored.

use crate::scene::load::mesh::text::{number, quote, words};

/// How numbers are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Encoding {
    Ascii,
    LittleEndian,
    BigEndian,
}

/// Type of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Scalar {
    fn parse(name: &[u8]) -> Result<Self, String> {
        Ok(match name {
            b"char" | b"int8" => Self::I8,
            b"uchar" | b"uint8" => Self::U8,
            b"short" | b"int16" => Self::I16,
            b"ushort" | b"uint16" => Self::U16,
            b"int" | b"int32" => Self::I32,
            b"uint" | b"uint32" => Self::U32,
            b"float" | b"float32" => Self::F32,
            b"double" | b"float64" => Self::F64,
            other => return Err(format!("{} is not a type of PLY", quote(other))),
        })
    }

    /// Bytes in a binary file.
    pub fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }
}

/// A number or a list of numbers that each element of a kind has.
#[derive(Debug)]
pub struct Property {
    pub name: Vec<u8>,
    pub scalar: Scalar,
    /// Type of the number of entries, for a list.
    pub count: Option<Scalar>,
}

/// A kind of element: `vertex`, `face`, or anything else.
#[derive(Debug)]
pub struct Element {
    pub name: Vec<u8>,
    pub count: usize,
    pub properties: Vec<Property>,
    /// Offset of its line in the header.
    pub line: usize,
}

impl Element {
    /// Index of the first property of this name, number or list.
    pub fn find(&self, name: &str, list: bool) -> Option<usize> {
        self.properties.iter().position(|p| p.name == name.as_bytes() && p.count.is_some() == list)
    }

    /// The least bytes that an element takes.
    pub fn smallest(&self, encoding: Encoding) -> usize {
        self.properties
            .iter()
            .map(|p| match encoding {
                // A digit and what separates it from the next.
                Encoding::Ascii => 2,
                _ => p.count.unwrap_or(p.scalar).size(),
            })
            .sum()
    }
}

/// What a file says about itself.
#[derive(Debug)]
pub struct Header {
    pub encoding: Encoding,
    pub elements: Vec<Element>,
    /// Where the first element begins.
    pub payload: usize,
}

/// An error, and the offset of the line it stands in.
pub type Misplaced = (usize, String);

/// Parses the header. Lines end as the first one does: LF with or without CR before it, or CR alone.
pub fn parse(bytes: &[u8]) -> Result<Header, Misplaced> {
    let end = match bytes.iter().position(|b| b"\r\n".contains(b)) {
        Some(at) if bytes[at] == b'\r' && bytes.get(at + 1) != Some(&b'\n') => b'\r',
        _ => b'\n',
    };
    let (mut encoding, mut elements) = (None, Vec::new());
    let mut at = 0;
    for line in bytes.split(|&b| b == end) {
        let begin = at;
        at += line.len() + 1;
        let mut words = words(line);
        let word = words.next().unwrap_or_default();
        if begin == 0 && word != b"ply" {
            return Err((0, "not a PLY file: the first line is not `ply`".into()));
        }
        match word {
            b"" | b"ply" | b"comment" | b"obj_info" => {}
            b"end_header" => {
                let encoding = encoding.ok_or_else(|| (begin, "the header names no format".into()))?;
                return Ok(Header { encoding, elements, payload: at.min(bytes.len()) });
            }
            b"format" => {
                let name = words.next().unwrap_or_default();
                encoding = Some(match name {
                    b"ascii" => Encoding::Ascii,
                    b"binary_little_endian" => Encoding::LittleEndian,
                    b"binary_big_endian" => Encoding::BigEndian,
                    other => return Err((begin, format!("{} is not a format of PLY", quote(other)))),
                });
            }
            b"element" => elements.push(element(words, begin, &elements).map_err(|what| (begin, what))?),
            b"property" => {
                let element: &mut Element =
                    elements.last_mut().ok_or_else(|| (begin, "a property of no element".into()))?;
                element.properties.push(property(words).map_err(|what| (begin, what))?);
            }
            other => return Err((begin, format!("{} does not belong into a header", quote(other)))),
        }
    }
    Err((bytes.len(), "the header has no end".into()))
}

fn element<'a>(mut words: impl Iterator<Item = &'a [u8]>, line: usize, known: &[Element]) -> Result<Element, String> {
    let name = words.next().ok_or("an element without a name")?;
    let once = matches!(name, b"vertex" | b"face" | b"tristrips");
    if once && known.iter().any(|e| e.name == name) {
        return Err(format!("a second element {}", quote(name)));
    }
    let count = words.next().unwrap_or_default();
    let count = number(count).ok_or_else(|| format!("{} is not a number of elements", quote(count)))?;
    Ok(Element { name: name.into(), count, properties: Vec::new(), line })
}

fn property<'a>(mut words: impl Iterator<Item = &'a [u8]>) -> Result<Property, String> {
    let mut word = || words.next().ok_or("a property needs a type and a name");
    let first = word()?;
    let (count, scalar) = if first == b"list" {
        let count = Scalar::parse(word()?)?;
        if matches!(count, Scalar::F32 | Scalar::F64) {
            return Err("the number of entries of a list must be an integer".into());
        }
        (Some(count), Scalar::parse(word()?)?)
    } else {
        (None, Scalar::parse(first)?)
    };
    Ok(Property { name: word()?.into(), scalar, count })
}
