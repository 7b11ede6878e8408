//! Stanford PLY, ascii and binary of either byte order.
//!
//! Our own reader: lines that end with CR alone, marks and bytes of any encoding in comments, faces before vertices and
//! strips are beyond the crates there are, and their errors show the file's content.

mod faces;
mod header;
mod values;
mod vertices;

use super::Parsed;
use super::text::{line_number, quote, skip_mark};
use crate::scene::{Mesh, load::error::FileError};
use faces::{Faces, Strips};
use header::{Element, Encoding, Header};
use std::path::Path;
use values::{Ascii, Binary, Skip, Values, read};
use vertices::Vertices;

/// Parses the bytes of a PLY file; `path` serves error messages only.
///
/// Reads `x y z`, `nx ny nz`, `u v` (also `s t`, `texture_u texture_v`…) of `vertex`, the index list and `texcoord` of
/// `face`, and `tristrips`; everything else is skipped. `turn_v` puts `1 − v` in place of `v`.
///
/// # Errors
/// A damaged header, data that end too early or are no numbers, indices without a vertex; element and line are named.
pub fn parse(bytes: &[u8], path: &Path, turn_v: bool) -> Result<Parsed, FileError> {
    let bytes = skip_mark(bytes, path)?;
    let misplaced = |(offset, what)| FileError::at(path, line_number(bytes, offset), what);
    let header = header::parse(bytes).map_err(misplaced)?;
    let payload = &bytes[header.payload..];
    let mut reader = Reader { header: &header, turn_v, mesh: Mesh::default(), warnings: Vec::new() };
    let (read, rest) = match header.encoding {
        Encoding::LittleEndian => reader.read(Binary::<false>(payload)),
        Encoding::BigEndian => reader.read(Binary::<true>(payload)),
        Encoding::Ascii => reader.read(Ascii(payload)),
    };
    read.map_err(|error| match (error, header.encoding) {
        (Error::Header(element, what), _) => misplaced((element.line, what)),
        (Error::Payload(what), Encoding::Ascii) => misplaced((bytes.len() - rest, what)),
        (Error::Payload(what), _) => FileError::new(path, what),
    })?;
    Ok(Parsed::new(reader.mesh, reader.warnings))
}

/// What is wrong, and where.
enum Error<'a> {
    /// With what the header says of an element.
    Header(&'a Element, String),
    /// Where reading stopped.
    Payload(String),
}

struct Reader<'a> {
    header: &'a Header,
    turn_v: bool,
    mesh: Mesh,
    warnings: Vec<String>,
}

impl<'a> Reader<'a> {
    /// Reads every element; returns also how many bytes were left when it was done or stopped.
    fn read(&mut self, mut values: impl Values) -> (Result<(), Error<'a>>, usize) {
        let read = self.elements(&mut values);
        (read, values.rest().len())
    }

    fn elements(&mut self, values: &mut impl Values) -> Result<(), Error<'a>> {
        // Faces refer to vertices, but may come before them.
        let mut waiting = Vec::new();
        let mut has_vertices = false;
        for element in &self.header.elements {
            let most = values.rest().len().div_ceil(element.smallest(self.header.encoding).max(1));
            if element.count > most {
                let (count, name) = (element.count, quote(&element.name));
                let what = format!("promises {count} elements {name}, but the file has room for at most {most}");
                return Err(Error::Header(element, what));
            }
            match element.name.as_slice() {
                b"vertex" => {
                    let mut vertices =
                        Vertices::new(element, self.turn_v).map_err(|what| Error::Header(element, what))?;
                    read(element, values, &mut vertices).map_err(Error::Payload)?;
                    self.mesh = vertices.mesh;
                    has_vertices = true;
                }
                b"face" | b"tristrips" if has_vertices => self.surface(element, values)?,
                name => {
                    if matches!(name, b"face" | b"tristrips") {
                        waiting.push((element, values.clone()));
                    }
                    read(element, values, &mut Skip).map_err(Error::Payload)?;
                }
            }
        }
        let rest = values.rest().trim_ascii();
        if rest.iter().any(|&b| b != 0) {
            self.warnings.push(format!("{} bytes behind the last element are not read", rest.len()));
        }
        for (element, start) in waiting {
            *values = start;
            self.surface(element, values)?;
        }
        Ok(())
    }

    fn surface(&mut self, element: &'a Element, values: &mut impl Values) -> Result<(), Error<'a>> {
        let unfit = |what| Error::Header(element, what);
        if element.count == 0 {
            return Ok(());
        }
        if element.name == b"tristrips" {
            let mut strips = Strips::new(element, &mut self.mesh).map_err(unfit)?;
            return read(element, values, &mut strips).map_err(Error::Payload);
        }
        let mut faces = Faces::new(element, &mut self.mesh, self.turn_v).map_err(unfit)?;
        read(element, values, &mut faces).map_err(Error::Payload)?;
        self.warnings.extend(faces.warnings());
        Ok(())
    }
}
