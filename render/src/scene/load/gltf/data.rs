//! Bytes of a glTF file: buffers, accessors, images. Read here rather than by the `gltf` crate, which trusts offsets
//! and counts.

use super::uri;
use crate::scene::load::error::FileError;
use crate::scene::load::image::{self, Pixels};
use gltf::accessor::sparse::IndexType;
use gltf::accessor::{DataType, Dimensions};
use gltf::{Accessor, Document, buffer, image as gltf_image};
use std::path::Path;

/// Larger buffers are refused.
const MAX_FILE: u64 = 1 << 33;

/// Longer accessors without data of their own are refused.
const MAX_ZEROS: usize = 1 << 26;

/// An element without data: the largest has 16 numbers of 4 bytes.
const ZEROS: [u8; 64] = [0; 64];

/// A glTF file with its buffers.
pub struct Data<'a> {
    pub path: &'a Path,
    buffers: Vec<Vec<u8>>,
}

impl<'a> Data<'a> {
    /// Reads all buffers; `blob` is the binary chunk of a GLB file.
    pub fn new(path: &'a Path, document: &Document, mut blob: Option<&[u8]>) -> Result<Self, FileError> {
        let mut buffers = Vec::new();
        for buffer in document.buffers() {
            let error = |what: String| FileError::new(path, format_args!("buffer {}: {what}", buffer.index()));
            let bytes = match buffer.source() {
                buffer::Source::Bin => {
                    let chunk = blob.take().ok_or_else(|| error("the binary chunk is missing".into()))?;
                    chunk.to_vec()
                }
                buffer::Source::Uri(uri) => match uri::data(uri) {
                    Some(bytes) => bytes.map_err(error)?,
                    None => uri::file(path, uri, MAX_FILE)?,
                },
            };
            if bytes.len() < buffer.length() {
                return Err(error(format!("{} bytes, but {} are promised", bytes.len(), buffer.length())));
            }
            buffers.push(bytes);
        }
        Ok(Self { path, buffers })
    }

    /// An error about this file.
    pub fn error(&self, what: impl std::fmt::Display) -> FileError {
        FileError::new(self.path, what)
    }

    fn view(&self, view: &buffer::View) -> Result<&[u8], FileError> {
        let end = view.offset().checked_add(view.length());
        let bytes = end.and_then(|end| self.buffers[view.buffer().index()].get(view.offset()..end));
        bytes.ok_or_else(|| self.error(format_args!("buffer view {} leaves its buffer", view.index())))
    }

    /// `count` blocks of `size` bytes in a view, `stride` bytes apart; `what` has them, for the error.
    fn blocks(
        &self,
        view: &buffer::View,
        (start, stride, size, count): (usize, usize, usize, usize),
        what: &str,
    ) -> Result<impl Iterator<Item = &[u8]> + use<'_, 'a>, FileError> {
        let bytes = self.view(view)?;
        let last = count.checked_sub(1).and_then(|n| n.checked_mul(stride));
        let end = last.and_then(|n| n.checked_add(start)?.checked_add(size));
        if stride < size || end.is_none_or(|end| end > bytes.len()) {
            return Err(self.error(format_args!("{what} leave their buffer view")));
        }
        Ok((0..count).map(move |i| &bytes[start + i * stride..][..size]))
    }

    /// The elements of an accessor, each as its bytes. Without a view they are zero; those that a sparse accessor lists
    /// are replaced.
    fn elements(&self, accessor: &Accessor) -> Result<Vec<&[u8]>, FileError> {
        let name = |what: &str| format!("accessor {}: {what}", accessor.index());
        let (size, count) = (accessor.size(), accessor.count());
        let mut elements: Vec<&[u8]> = match accessor.view() {
            Some(view) => {
                let place = (accessor.offset(), view.stride().unwrap_or(size), size, count);
                self.blocks(&view, place, &name("its elements"))?.collect()
            }
            None if accessor.sparse().is_none() => return Err(self.error(name("an accessor without data"))),
            None if count == 0 || count > MAX_ZEROS => {
                return Err(self.error(name(&format!("{count} elements, all zero but for some"))));
            }
            None => vec![&ZEROS[..size]; count],
        };
        if let Some(sparse) = accessor.sparse() {
            let (indices, values) = (sparse.indices(), sparse.values());
            let width = match indices.index_type() {
                IndexType::U8 => 1,
                IndexType::U16 => 2,
                IndexType::U32 => 4,
            };
            let of_index = (indices.offset(), width, width, sparse.count());
            let of_value = (values.offset(), size, size, sparse.count());
            let indices = self.blocks(&indices.view(), of_index, &name("its sparse indices"))?;
            let values = self.blocks(&values.view(), of_value, &name("its sparse values"))?;
            for (index, value) in indices.zip(values) {
                let index = index.iter().rev().fold(0usize, |sum, &byte| sum << 8 | usize::from(byte));
                let replaced = elements.get_mut(index);
                *replaced.ok_or_else(|| self.error(name(&format!("a sparse index of {index}"))))? = value;
            }
        }
        Ok(elements)
    }

    /// Vectors of `N` numbers; integers are normalised.
    pub fn vectors<const N: usize>(&self, accessor: &Accessor) -> Result<Vec<[f32; N]>, FileError> {
        let error = || self.error(format_args!("accessor {}: {N} numbers per element are needed", accessor.index()));
        let components = match accessor.dimensions() {
            Dimensions::Vec2 => 2,
            Dimensions::Vec3 => 3,
            Dimensions::Vec4 => 4,
            _ => 0,
        };
        let width = accessor.data_type().size();
        let number: fn(&[u8]) -> f32 = match accessor.data_type() {
            DataType::F32 => |b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]),
            DataType::U8 => |b| f32::from(b[0]) / 255.0,
            DataType::U16 => |b| f32::from(u16::from_le_bytes([b[0], b[1]])) / 65535.0,
            _ => return Err(error()),
        };
        if components != N {
            return Err(error());
        }
        let elements = self.elements(accessor)?;
        Ok(elements.into_iter().map(|e| std::array::from_fn(|i| number(&e[i * width..]))).collect())
    }

    /// Colours with opacity, 1 where they have none, brought into [0, 1].
    pub fn colors(&self, accessor: &Accessor) -> Result<Vec<[f32; 4]>, FileError> {
        let colors: Vec<[f32; 4]> = match accessor.dimensions() {
            Dimensions::Vec4 => self.vectors(accessor)?,
            _ => self.vectors::<3>(accessor)?.into_iter().map(|[r, g, b]| [r, g, b, 1.0]).collect(),
        };
        // NaN stays, and is refused with the mesh.
        Ok(colors.into_iter().map(|c| c.map(|x| x.clamp(0.0, 1.0))).collect())
    }

    /// Vertex indices.
    pub fn indices(&self, accessor: &Accessor) -> Result<Vec<u32>, FileError> {
        let index: fn(&[u8]) -> u32 = match (accessor.dimensions(), accessor.data_type()) {
            (Dimensions::Scalar, DataType::U8) => |b| b[0].into(),
            (Dimensions::Scalar, DataType::U16) => |b| u16::from_le_bytes([b[0], b[1]]).into(),
            (Dimensions::Scalar, DataType::U32) => |b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]),
            _ => return Err(self.error(format_args!("accessor {}: no vertex indices", accessor.index()))),
        };
        Ok(self.elements(accessor)?.into_iter().map(index).collect())
    }

    /// Decodes an image.
    pub fn image(&self, image: &gltf_image::Image) -> Result<Pixels, FileError> {
        let name = format!("{} (image {})", self.path.display(), image.index());
        match image.source() {
            gltf_image::Source::View { view, .. } => image::decode(self.view(&view)?, Path::new(&name)),
            gltf_image::Source::Uri { uri, .. } => match uri::data(uri) {
                Some(bytes) => {
                    let bytes = bytes.map_err(|e| self.error(format_args!("image {}: {e}", image.index())))?;
                    image::decode(&bytes, Path::new(&name))
                }
                None => uri::beside(self.path, uri, image::read),
            },
        }
    }
}
