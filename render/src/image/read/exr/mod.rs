//! OpenEXR: the layer that is the picture, its channels alone, in the display window.

mod blocks;
mod chroma;
mod layers;

use super::compact::compact;
use super::primaries::{self, Primaries, REC_709};
use super::{Pixels, Window, Windows, check_size, filled, one_line};
use crate::image::layers::SPP;
use blocks::Blocks;
use chroma::Plane;
use exr::math::Vec2;
use exr::meta::MetaData;
use exr::meta::attribute::{AttributeValue, IntegerBounds, Text};
use layers::{Colour, Layer};
use std::io::Cursor;

/// How a file begins.
pub(super) const MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];

/// Display windows up to this size may be empty but for a few pixels …
const MAX_EMPTY: usize = 1 << 25;

/// … larger ones are refused if they have more than so many times the pixels of the data window.
const MAX_EMPTINESS: usize = 16;

/// An opened file.
struct File<'a> {
    bytes: &'a [u8],
    meta: MetaData,
    /// Where the tables of blocks begin.
    tables: usize,
}

/// The picture.
pub(super) fn decode(bytes: &[u8]) -> Result<Pixels, String> {
    let file = File::open(bytes)?;
    let (layer, warning) = layers::choose(&file.meta.headers)?;
    let mut pixels = file.pixels(&layer)?;
    pixels.warnings.extend(warning);
    Ok(pixels)
}

/// The layer `variance` of an EXR by `render image`, and its samples per pixel.
pub(super) fn variance(bytes: &[u8]) -> Result<Option<(Pixels, u32)>, String> {
    let file = File::open(bytes)?;
    let layers = layers::layers(&file.meta.headers);
    let Some(layer) = layers.iter().find(|l| l.name == "variance") else { return Ok(None) };
    match file.meta.headers[layer.part].own_attributes.other.get(&Text::from(SPP)) {
        Some(&AttributeValue::I32(spp)) => Ok(Some((file.pixels(layer)?, spp.try_into().unwrap_or(0)))),
        _ => Ok(None),
    }
}

/// A window, if it has pixels whose indices fit.
fn window(bounds: IntegerBounds) -> Result<Window, String> {
    bounds.validate(None).map_err(|e| one_line(&e.to_string()))?;
    let Vec2(width, height) = bounds.size;
    check_size(width as u64, height as u64)?;
    if width == 0 || height == 0 {
        return Err("an image without pixels".into());
    }
    Ok(Window { min: [bounds.position.x(), bounds.position.y()], size: [width as u32, height as u32] })
}

impl<'a> File<'a> {
    fn open(bytes: &'a [u8]) -> Result<Self, String> {
        let mut cursor = Cursor::new(bytes);
        let meta = MetaData::read_from_buffered(&mut cursor, false).map_err(|e| one_line(&e.to_string()))?;
        Ok(Self { bytes, meta, tables: cursor.position() as usize })
    }

    /// A layer in the display window.
    fn pixels(&self, layer: &Layer) -> Result<Pixels, String> {
        let header = &self.meta.headers[layer.part];
        let display = window(header.shared_attributes.display_window)?;
        let placed = header.own_attributes.other.contains_key(&Text::from(SPP));
        let windows = Windows { display, data: window(header.data_window())?, placed };
        let [width, height] = display.size;
        let (count, held) = ((width * height) as usize, header.layer_size.area());
        if count > MAX_EMPTY && count / MAX_EMPTINESS > held {
            return Err(format!("a display window of {width} × {height} pixels, of which the file holds {held}"));
        }
        let blocks = Blocks::find(self.bytes, &self.meta, layer.part, self.tables)?;
        let alpha = if layer.alpha.is_some() { 0.0 } else { 1.0 };
        let mut rgba = filled(count, [0.0, 0.0, 0.0, alpha])?;
        let primaries = header.shared_attributes.chromaticities.map_or(REC_709, |c| {
            let [red, green, blue, white] = [c.red, c.green, c.blue, c.white].map(|p| [p.x().into(), p.y().into()]);
            Primaries { red, green, blue, white }
        });
        let mut picture = Picture { windows, rgba: &mut rgba };
        match layer.colour {
            Colour::Rgb(rgb) => picture.fill(&blocks, &rgb, layer.alpha)?,
            Colour::Grey(y) => picture.fill(&blocks, &[y; 3], layer.alpha)?,
            Colour::Chroma(channels) => {
                let weights = primaries.to_xyz().ok_or("its primaries are no colours")?.row(1);
                let sampling = channels.map(|c| header.channels.list[c].sampling);
                let mut planes = Vec::new();
                for Vec2(x, y) in sampling {
                    planes.push(Plane::new(header.layer_size.x() / x, header.layer_size.y() / y)?);
                }
                picture.fill_chroma(&blocks, channels, planes, weights)?;
                if let Some(alpha) = layer.alpha {
                    picture.fill(&blocks, &[], Some(alpha))?;
                }
            }
        }
        // Grey is grey under every white.
        let matrix = if matches!(layer.colour, Colour::Grey(_)) { None } else { primaries.to_rec_709()? };
        if let Some(matrix) = matrix {
            primaries::transform(&mut rgba, matrix);
        }
        Ok(Pixels { raster: compact(width, height, rgba), windows: Some(windows), ..Pixels::default() })
    }
}

/// The display window, filled from the data window.
struct Picture<'a> {
    windows: Windows,
    rgba: &'a mut [[f32; 4]],
}

impl Picture<'_> {
    /// Where a line of the data window lies in the picture: the first index, and which of its samples are inside.
    fn place(&self, [x, y]: [usize; 2], count: usize) -> Option<(usize, std::ops::Range<usize>)> {
        let Windows { display, data, .. } = self.windows;
        let [left, top] = [0, 1].map(|i| i64::from(data.min[i]) - i64::from(display.min[i]));
        let [width, height] = display.size.map(i64::from);
        let (left, row) = (left + x as i64, top + y as i64);
        let (first, last) = (left.clamp(0, width), (left + count as i64).clamp(0, width));
        let inside = (0..height).contains(&row) && first < last;
        inside.then(|| ((row * width + first) as usize, (first - left) as usize..(last - left) as usize))
    }

    fn fill(&mut self, blocks: &Blocks, colour: &[usize], alpha: Option<usize>) -> Result<(), String> {
        let wanted: Vec<usize> = colour.iter().copied().chain(alpha).collect();
        blocks.lines(&wanted, |line| {
            let Some((start, inside)) = self.place(line.at, line.samples.len()) else { return };
            let to = if line.channel == colour.len() { 3 } else { line.channel };
            for (pixel, value) in self.rgba[start..].iter_mut().zip(&line.samples[inside]) {
                pixel[to] = *value;
            }
        })
    }

    fn fill_chroma(
        &mut self,
        blocks: &Blocks,
        channels: [usize; 3],
        mut planes: Vec<Plane>,
        weights: glam::DVec3,
    ) -> Result<(), String> {
        blocks.lines(&channels, |line| {
            let plane = &mut planes[line.channel];
            let start = line.at[1] * plane.width + line.at[0];
            plane.samples[start..start + line.samples.len()].copy_from_slice(line.samples);
        })?;
        let [width, height] = self.windows.data.size.map(|n| n as usize);
        let full: Vec<_> = planes.into_iter().map(|p| p.full(width, height)).collect::<Result<_, _>>()?;
        for row in 0..height {
            let Some((start, inside)) = self.place([0, row], width) else { continue };
            for (pixel, x) in self.rgba[start..].iter_mut().zip(inside) {
                let at = row * width + x;
                let sample = |plane: usize| full[plane].samples[at];
                pixel[..3].copy_from_slice(&chroma::rgb([sample(0), sample(1), sample(2)], weights));
            }
        }
        Ok(())
    }
}
