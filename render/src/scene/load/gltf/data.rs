//! Bytes of a glTF file: buffers, accessors, images. Read here rather than by the `gltf` crate, which trusts offsets
//! and counts.

use super::uri;
use crate::image::Pixels;
use crate::scene::load::error::FileError;
use crate::scene::load::image;
use gltf::accessor::sparse::IndexType;
use gltf::accessor::{DataType, Dimensions};
use gltf::{Accessor, Document, buffer, image as gltf_image};
use std::borrow::Cow;
use std::path::{Path, PathBuf};

/// Larger buffers are refused.
const MAX_FILE: u64 = 1 << 33;

/// An element without data: the largest has 16 numbers of 4 bytes.
const ZEROS: [u8; 64] = [0; 64];

/// So many elements without data any file may have, however few bytes it has.
const FREE_ZEROS: usize = 1 << 16;

/// A glTF file with its buffers.
pub struct Data<'a> {
    pub path: &'a Path,
    buffers: Vec<Cow<'a, [u8]>>,
}

impl<'a> Data<'a> {
    /// Reads all buffers; `blob` is the binary chunk of a GLB file.
    pub fn new(path: &'a Path, document: &Document, mut blob: Option<&'a [u8]>) -> Result<Self, FileError> {
        let mut buffers = Vec::new();
        for buffer in document.buffers() {
            let error = |what: String| FileError::new(path, format_args!("buffer {}: {what}", buffer.index()));
            let bytes: Cow<[u8]> = match buffer.source() {
                buffer::Source::Bin => {
                    let chunk = blob.take().ok_or_else(|| error("the binary chunk is missing".into()))?;
                    chunk.into()
                }
                buffer::Source::Uri(uri) => match uri::data(uri) {
                    Some(bytes) => bytes.map_err(error)?.into(),
                    None => uri::file(path, uri, MAX_FILE)?.into(),
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
            // A file of few data has no use for many elements that are zero: no more than it has bytes.
            None if count == 0 || count > self.buffers.iter().map(|b| b.len()).sum::<usize>().max(FREE_ZEROS) => {
                return Err(self.error(name(&format!("{count} elements without data"))));
            }
            None => vec![&ZEROS[..size]; count],
        };
        if let Some(sparse) = accessor.sparse().filter(|s| s.count() > 0) {
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

    /// The elements of an accessor of `N` numbers each, read by `number`.
    fn numbers<T, const N: usize>(
        &self,
        accessor: &Accessor,
        number: Option<fn(&[u8]) -> T>,
    ) -> Result<Vec<[T; N]>, FileError> {
        let fits = match accessor.dimensions() {
            Dimensions::Scalar => N == 1,
            Dimensions::Vec2 => N == 2,
            Dimensions::Vec3 => N == 3,
            Dimensions::Vec4 => N == 4,
            Dimensions::Mat4 => N == 16,
            Dimensions::Mat2 | Dimensions::Mat3 => false,
        };
        let Some(number) = number.filter(|_| fits) else {
            let found = (accessor.dimensions(), accessor.data_type());
            let what = format_args!("accessor {}: {N} numbers per element are needed, not {found:?}", accessor.index());
            return Err(self.error(what));
        };
        let width = accessor.data_type().size();
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

    /// Vectors of `N` numbers. Normalised integers become numbers up to 1, others stay as they are
    /// (`KHR_mesh_quantization`).
    pub fn vectors<const N: usize>(&self, accessor: &Accessor) -> Result<Vec<[f32; N]>, FileError> {
        let number: Option<fn(&[u8]) -> f32> = match (accessor.data_type(), accessor.normalized()) {
            (DataType::F32, _) => Some(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])),
            (DataType::U8, true) => Some(|b| f32::from(b[0]) / 255.0),
            (DataType::U8, false) => Some(|b| b[0].into()),
            (DataType::I8, true) => Some(|b| (f32::from(b[0] as i8) / 127.0).max(-1.0)),
            (DataType::I8, false) => Some(|b| (b[0] as i8).into()),
            (DataType::U16, true) => Some(|b| f32::from(u16::from_le_bytes([b[0], b[1]])) / 65535.0),
            (DataType::U16, false) => Some(|b| u16::from_le_bytes([b[0], b[1]]).into()),
            (DataType::I16, true) => Some(|b| (f32::from(i16::from_le_bytes([b[0], b[1]])) / 32767.0).max(-1.0)),
            (DataType::I16, false) => Some(|b| i16::from_le_bytes([b[0], b[1]]).into()),
            (DataType::U32, _) => None,
        };
        self.numbers(accessor, number)
    }

    /// Vectors of `N` indices.
    pub fn integers<const N: usize>(&self, accessor: &Accessor) -> Result<Vec<[u32; N]>, FileError> {
        let number: Option<fn(&[u8]) -> u32> = match accessor.data_type() {
            DataType::U8 => Some(|b| b[0].into()),
            DataType::U16 => Some(|b| u16::from_le_bytes([b[0], b[1]]).into()),
            DataType::U32 => Some(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])),
            DataType::I8 | DataType::I16 | DataType::F32 => None,
        };
        self.numbers(accessor, number)
    }

    /// The files of buffers and images beside the scene.
    pub fn files<'d>(
        &self,
        document: &'d Document,
        images: impl Iterator<Item = gltf_image::Image<'d>>,
    ) -> Vec<PathBuf> {
        let buffers = document.buffers().filter_map(|buffer| match buffer.source() {
            buffer::Source::Uri(uri) => Some(uri),
            buffer::Source::Bin => None,
        });
        let images = images.filter_map(|image| match image.source() {
            gltf_image::Source::Uri { uri, .. } => Some(uri),
            gltf_image::Source::View { .. } => None,
        });
        let outside = buffers.chain(images).filter(|uri| !uri::is_data(uri));
        outside.filter_map(|uri| uri::path_of(self.path, uri).ok()).collect()
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
