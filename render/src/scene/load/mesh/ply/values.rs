//! The numbers behind the header, one after the other, in each encoding.

use super::header::{Element, Scalar};
use crate::scene::load::mesh::text::{number, quote};

/// Why a number could not be read.
#[derive(Debug)]
pub enum Fault {
    /// The file ends before it.
    End,
    /// Something else stands there.
    Wrong(String),
}

/// A place in the payload.
pub trait Values: Clone {
    /// The next number. Every type of PLY fits a double.
    fn next(&mut self, scalar: Scalar) -> Result<f64, Fault>;

    /// Called behind the last number of an element.
    fn end_element(&mut self) -> Result<(), Fault>;

    /// What is left.
    fn rest(&self) -> &[u8];
}

/// Who receives the numbers of an element.
pub trait Sink {
    /// A number of the property with this index; an entry, where the property is a list.
    fn value(&mut self, property: usize, value: f64);

    /// All numbers of an element were given.
    fn end_element(&mut self) -> Result<(), String>;
}

/// An element that nobody asked for.
pub struct Skip;

impl Sink for Skip {
    fn value(&mut self, _: usize, _: f64) {}

    fn end_element(&mut self) -> Result<(), String> {
        Ok(())
    }
}

/// Reads all elements of a kind.
pub fn read(element: &Element, values: &mut impl Values, sink: &mut impl Sink) -> Result<(), String> {
    let name = || quote(&element.name);
    if element.properties.is_empty() {
        return Ok(());
    }
    for i in 0..element.count {
        read_one(element, values, sink).map_err(|fault| match fault {
            Fault::End => format!("the file ends after {i} of {} elements {}", element.count, name()),
            Fault::Wrong(what) => format!("{} {i}: {what}", name()),
        })?;
    }
    Ok(())
}

fn read_one(element: &Element, values: &mut impl Values, sink: &mut impl Sink) -> Result<(), Fault> {
    for (i, property) in element.properties.iter().enumerate() {
        let Some(count) = property.count else {
            sink.value(i, values.next(property.scalar)?);
            continue;
        };
        let count = values.next(count)?;
        if count < 0.0 || count.fract() != 0.0 {
            return Err(Fault::Wrong(format!("a list of {count} entries")));
        }
        // The file ends long before a count that lies is reached.
        for _ in 0..count as u64 {
            sink.value(i, values.next(property.scalar)?);
        }
    }
    values.end_element()?;
    sink.end_element().map_err(Fault::Wrong)
}

/// Binary numbers, the least significant byte first unless `BIG`.
#[derive(Clone)]
pub struct Binary<'a, const BIG: bool>(pub &'a [u8]);

impl<const BIG: bool> Binary<'_, BIG> {
    fn take<const N: usize>(&mut self) -> Result<[u8; N], Fault> {
        let (bytes, rest) = self.0.split_first_chunk::<N>().ok_or(Fault::End)?;
        self.0 = rest;
        let mut bytes = *bytes;
        if BIG {
            bytes.reverse();
        }
        Ok(bytes)
    }
}

impl<const BIG: bool> Values for Binary<'_, BIG> {
    fn next(&mut self, scalar: Scalar) -> Result<f64, Fault> {
        Ok(match scalar {
            Scalar::I8 => i8::from_le_bytes(self.take()?).into(),
            Scalar::U8 => u8::from_le_bytes(self.take()?).into(),
            Scalar::I16 => i16::from_le_bytes(self.take()?).into(),
            Scalar::U16 => u16::from_le_bytes(self.take()?).into(),
            Scalar::I32 => i32::from_le_bytes(self.take()?).into(),
            Scalar::U32 => u32::from_le_bytes(self.take()?).into(),
            Scalar::F32 => f32::from_le_bytes(self.take()?).into(),
            Scalar::F64 => f64::from_le_bytes(self.take()?),
        })
    }

    fn end_element(&mut self) -> Result<(), Fault> {
        Ok(())
    }

    fn rest(&self) -> &[u8] {
        self.0
    }
}

/// Numbers as text. An element may take several lines, but no line holds numbers of two.
#[derive(Clone)]
pub struct Ascii<'a>(pub &'a [u8]);

impl Values for Ascii<'_> {
    fn next(&mut self, _: Scalar) -> Result<f64, Fault> {
        let text = self.0.trim_ascii_start();
        let end = text.iter().position(u8::is_ascii_whitespace).unwrap_or(text.len());
        let (word, rest) = text.split_at(end);
        if word.is_empty() {
            return Err(Fault::End);
        }
        let value = number(word).ok_or_else(|| Fault::Wrong(format!("{} is not a number", quote(word))));
        self.0 = if value.is_ok() { rest } else { text };
        value
    }

    fn end_element(&mut self) -> Result<(), Fault> {
        let end = self.0.iter().position(|b| !b" \t".contains(b)).unwrap_or(self.0.len());
        match self.0.get(end) {
            None | Some(b'\r' | b'\n') => Ok(()),
            Some(_) => Err(Fault::Wrong("its line holds more numbers than the header says".into())),
        }
    }

    fn rest(&self) -> &[u8] {
        self.0
    }
}
