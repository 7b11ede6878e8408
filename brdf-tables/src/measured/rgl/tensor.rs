//! Tensor files: the container of RGL's measurements and of Mitsuba. `tensor_file\0`, a version of two bytes (1, 0), the number
//! of fields; each is a name, a shape, a type and the place of its numbers. All little-endian.

use crate::measured::{Place, ReadError};

const MAGIC: &[u8; 12] = b"tensor_file\0";
/// Most fields, and most dimensions of one.
const MOST_FIELDS: u32 = 64;
const MOST_DIMENSIONS: u16 = 8;
/// Tags of the types that are read, and their sizes in bytes.
const BYTE: u8 = 1;
const SINGLE: u8 = 10;
const SIZES: [usize; 12] = [0, 1, 1, 2, 2, 4, 4, 8, 8, 2, 4, 8];

/// A field.
pub struct Field<'a> {
    pub name: &'a str,
    pub shape: Vec<usize>,
    kind: u8,
    bytes: &'a [u8],
}

/// The fields of a file.
pub struct Tensors<'a>(Vec<Field<'a>>);

/// Reads on from a place.
struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Reader<'a> {
    fn take<const N: usize>(&mut self, what: &str) -> Result<[u8; N], ReadError> {
        let end = ReadError::new(Place::Byte(self.at as u64), format!("the file ends within {what}"));
        let bytes = self.bytes.get(self.at..).and_then(|b| b.first_chunk::<N>()).ok_or(end)?;
        self.at += N;
        Ok(*bytes)
    }
}

impl<'a> Tensors<'a> {
    /// Reads the list of fields; numbers stay where they are.
    pub fn new(bytes: &'a [u8]) -> Result<Self, ReadError> {
        if bytes.get(..12) != Some(MAGIC) {
            return Err(ReadError::new(Place::File, "not a tensor file (the first bytes are not tensor_file)"));
        }
        let mut reader = Reader { bytes, at: 12 };
        let version: [u8; 2] = reader.take("the version")?;
        if version != [1, 0] {
            let what = format!("tensor file of version {}.{}, not 1.0", version[0], version[1]);
            return Err(ReadError::new(Place::Byte(12), what));
        }
        let count = u32::from_le_bytes(reader.take("the number of fields")?);
        if count > MOST_FIELDS {
            return Err(ReadError::new(Place::Byte(14), format!("{count} fields, at most {MOST_FIELDS} are read")));
        }
        let mut fields = Vec::new();
        for _ in 0..count {
            let length = usize::from(u16::from_le_bytes(reader.take("the name of a field")?));
            let start = reader.at;
            let name = bytes.get(start..start + length).and_then(|b| core::str::from_utf8(b).ok());
            let name = name.filter(|n| n.chars().all(|c| c.is_ascii_graphic()));
            let name = name.ok_or_else(|| ReadError::new(Place::Byte(start as u64), "the name of a field is none"))?;
            reader.at += length;
            let fail = |what: String| ReadError::new(Place::Field(name.into()), what);
            let dimensions = u16::from_le_bytes(reader.take("a field")?);
            let [kind] = reader.take::<1>("a field")?;
            let offset = u64::from_le_bytes(reader.take("a field")?);
            if dimensions > MOST_DIMENSIONS {
                return Err(fail(format!("{dimensions} dimensions, at most {MOST_DIMENSIONS} are read")));
            }
            let mut shape = Vec::new();
            for _ in 0..dimensions {
                shape.push(usize::try_from(u64::from_le_bytes(reader.take("a shape")?)).unwrap_or(usize::MAX));
            }
            let size = SIZES.get(usize::from(kind)).filter(|s| **s > 0);
            let size = size.ok_or_else(|| fail(format!("type {kind}, which tensor files do not have")))?;
            let total = shape.iter().try_fold(*size, |a, b| a.checked_mul(*b));
            let found = total.and_then(|total| {
                let start = usize::try_from(offset).ok()?;
                bytes.get(start..start.checked_add(total)?)
            });
            let bytes = found.ok_or_else(|| {
                fail(format!("shape {shape:?} at byte {offset} lies outside of the file of {} bytes", bytes.len()))
            })?;
            fields.push(Field { name, shape, kind, bytes });
        }
        Ok(Self(fields))
    }

    fn find(&self, name: &str) -> Option<&Field<'a>> {
        self.0.iter().find(|f| f.name == name)
    }

    /// Shape and numbers of a field in single precision of some number of dimensions; all must be finite.
    pub fn floats(&self, name: &str, dimensions: usize) -> Result<(Vec<usize>, Vec<f32>), ReadError> {
        let fail = |what: String| ReadError::new(Place::Field(name.into()), what);
        let field = self.find(name).ok_or_else(|| fail("missing".into()))?;
        if field.kind != SINGLE || field.shape.len() != dimensions {
            return Err(fail(format!("{dimensions} dimensions of single precision are needed")));
        }
        let (numbers, _) = field.bytes.as_chunks::<4>();
        let numbers: Vec<f32> = numbers.iter().map(|b| f32::from_le_bytes(*b)).collect();
        if let Some(at) = numbers.iter().position(|x| !x.is_finite() || x.abs() > 1e9) {
            return Err(fail(format!("number {at} is {}", numbers[at])));
        }
        Ok((field.shape.clone(), numbers))
    }

    /// Whether there is a field.
    pub fn has(&self, name: &str) -> bool {
        self.find(name).is_some()
    }

    /// The one byte of a field.
    pub fn byte(&self, name: &str) -> Option<u8> {
        self.find(name).filter(|f| f.kind == BYTE).and_then(|f| f.bytes.first().copied())
    }

    /// The text of a field, as far as it can be printed.
    pub fn text(&self, name: &str) -> Option<String> {
        let field = self.find(name).filter(|f| f.kind == BYTE)?;
        let text = String::from_utf8_lossy(&field.bytes[..field.bytes.len().min(400)]);
        Some(text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect::<String>().trim().into())
    }
}
