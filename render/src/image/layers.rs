//! Renderings as OpenEXR: the picture, and in layers the light by its way and what the first surface is.
//!
//! Channels are made line by line while the file is written, so that a large picture needs no memory for them.

use super::ImageError;
use super::write::{Look, content};
use crate::picture::{Picture, Pixel};
use crate::scene::Rgb;
use core::ops::Range;
use exr::block::lines::LineRefMut;
use exr::image::write::samples::{SamplesWriter, WritableSamples};
use exr::math::RoundingMode;
use exr::meta::attribute::{AttributeValue, LevelMode, SampleType};
use exr::meta::header::Header;
use exr::prelude::{
    AnyChannel, AnyChannels, Blocks, Compression, Encoding, Image, Layer, LayerAttributes, LineOrder, WritableImage,
    f16,
};
use kit::output;
use rayon::prelude::*;
use std::io::{Seek, Write};
use std::path::Path;

/// What an OpenEXR file can hold beside the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// The picture before its noise was taken away, where it was.
    Noisy,
    /// Variance of the (noisy) picture's pixels.
    Variance,
    /// Light that comes straight from emitters.
    Emission,
    /// Light that was scattered once.
    Direct,
    /// Light that was scattered more often.
    Indirect,
    /// Reflectance.
    Albedo,
    /// Shading normal.
    Normal,
    /// Depth along the camera's axis.
    Depth,
}

impl Part {
    /// All of them.
    pub const ALL: [Self; 8] = [
        Self::Noisy,
        Self::Variance,
        Self::Emission,
        Self::Direct,
        Self::Indirect,
        Self::Albedo,
        Self::Normal,
        Self::Depth,
    ];

    /// As typed.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Noisy => "noisy",
            Self::Variance => "variance",
            Self::Emission => "emission",
            Self::Direct => "direct",
            Self::Indirect => "indirect",
            Self::Albedo => "albedo",
            Self::Normal => "normal",
            Self::Depth => "depth",
        }
    }
}

/// Attribute of an EXR: samples per pixel.
pub(super) const SPP: &str = "spp";

const RGB: &[&str] = &["R", "G", "B"];
const XYZ: &[&str] = &["X", "Y", "Z"];

/// A layer, and its value at a pixel.
struct Values<'a> {
    /// In front of the names of its channels.
    prefix: &'static str,
    channels: &'static [&'static str],
    channel: Box<dyn Fn(Range<usize>, usize) -> Vec<f32> + Sync + 'a>,
    /// Whether half precision will do: 11 bits.
    half: bool,
}

/// One channel of a value at some pixels: only what it is made of is computed.
fn channel<'a>(value: impl Fn(usize) -> Rgb + Sync + 'a) -> Box<dyn Fn(Range<usize>, usize) -> Vec<f32> + Sync + 'a> {
    Box::new(move |pixels, channel| match channel {
        0 => pixels.map(|i| value(i).x).collect(),
        1 => pixels.map(|i| value(i).y).collect(),
        _ => pixels.map(|i| value(i).z).collect(),
    })
}

/// Layers of a picture in which half precision does not do: what others measure, and distances.
fn exact<'a>(
    prefix: &'static str,
    channels: &'static [&'static str],
    value: impl Fn(usize) -> Rgb + Sync + 'a,
) -> Values<'a> {
    Values { prefix, channels, channel: channel(value), half: false }
}

/// Largest and smallest brightness of a layer's brightest pixel for half precision, whose largest number is 65504 and whose steps
/// near 0 are 6e-8, 4e-6 of the smaller one.
const HALF: [f32; 2] = [1.0 / 64.0, 65504.0];

fn rounded<'a>(
    picture: &'a Picture,
    prefix: &'static str,
    channels: &'static [&'static str],
    of: impl Fn(&Pixel) -> Rgb + Sync + 'a,
) -> Values<'a> {
    let value = move |i: usize| of(&picture.pixels[i]);
    let largest =
        (0..picture.pixels.len()).into_par_iter().map(|i| value(i).abs().max_element()).reduce(|| 0.0, f32::max);
    let half = largest == 0.0 || (HALF[0]..=HALF[1]).contains(&largest);
    Values { prefix, channels, channel: channel(value), half }
}

/// The picture and the layers that were asked for.
fn values<'a>(picture: &'a Picture, look: &Look) -> Vec<Values<'a>> {
    let scale = 1.0 / picture.spp.max(1) as f32;
    let pixels = &picture.pixels;
    let whole = move |i: usize| pixels[i].sum().sum() * scale;
    let mut values = match &picture.denoised {
        Some(denoised) => vec![exact("", RGB, |i| Rgb::from_array(denoised[i]))],
        None => vec![exact("", RGB, whole)],
    };
    if look.alpha {
        values.push(exact("", &["A"], |i| Rgb::splat(picture.alpha(&pixels[i]))));
    }
    let denoised = picture.denoised.is_some();
    for part in Part::ALL.into_iter().filter(|part| look.parts.contains(part)) {
        match part {
            // What is denoised is the picture; the rest is noisy, and so is what it says of itself.
            Part::Noisy if denoised => values.push(exact("noisy.", RGB, whole)),
            Part::Noisy => {}
            Part::Variance if picture.passes > 1 => {
                let prefix = if denoised { "noisy.variance." } else { "variance." };
                values.push(exact(prefix, RGB, |i| picture.variance(&pixels[i]).unwrap_or_default()));
            }
            Part::Variance => {}
            Part::Emission => values.push(rounded(picture, "emission.", RGB, move |p| p.sum().emission * scale)),
            Part::Direct => {
                values.push(rounded(picture, "direct.diffuse.", RGB, move |p| p.sum().direct.diffuse * scale));
                values.push(rounded(picture, "direct.glossy.", RGB, move |p| p.sum().direct.glossy * scale));
            }
            Part::Indirect => {
                values.push(rounded(picture, "indirect.diffuse.", RGB, move |p| p.sum().indirect.diffuse * scale));
                values.push(rounded(picture, "indirect.glossy.", RGB, move |p| p.sum().indirect.glossy * scale));
            }
            Part::Albedo => values.push(rounded(picture, "albedo.", RGB, move |p| p.sum().albedo * scale)),
            Part::Normal => {
                values.push(rounded(picture, "normal.", XYZ, |p| p.sum().normal.normalize_or_zero()));
            }
            Part::Depth => {
                // The mean depth of the samples that met a surface.
                let depth =
                    |p: &Pixel| if p.surfaces > 0 { p.sum().distance / p.surfaces as f32 } else { f32::INFINITY };
                values.push(exact("depth.", &["Z"], move |i| Rgb::splat(depth(&pixels[i]))));
            }
        }
    }
    values
}

/// A channel of a layer, made while it is written.
#[derive(Clone, Copy)]
struct Channel<'a> {
    layer: &'a Values<'a>,
    index: usize,
    width: usize,
}

impl<'slf, 'a: 'slf> WritableSamples<'slf> for Channel<'a> {
    type Writer = Self;

    fn sample_type(&self) -> SampleType {
        if self.layer.half { SampleType::F16 } else { SampleType::F32 }
    }

    fn infer_level_modes(&self) -> (LevelMode, RoundingMode) {
        (LevelMode::Singular, RoundingMode::Down)
    }

    fn create_samples_writer(&'slf self, _: &Header) -> Self {
        *self
    }
}

impl SamplesWriter for Channel<'_> {
    fn extract_line(&self, line: LineRefMut<'_>) {
        let at = line.location.position;
        let start = at.y() * self.width + at.x();
        let values = (self.layer.channel)(start..start + line.location.sample_count, self.index);
        let written = match self.layer.half {
            true => line.write_samples(|i| f16::from_f32(values[i])),
            false => line.write_samples(|i| values[i]),
        };
        // A line of memory has the room that the writer itself asked for.
        debug_assert!(written.is_ok());
    }
}

/// Writes a picture with its layers.
///
/// # Errors
/// A file that cannot be written.
pub(super) fn write(path: &Path, picture: &Picture, look: &Look) -> Result<(), ImageError> {
    let values = values(picture, look);
    output::write_with(path, |file| write_to(file, picture, &values, look).map_err(|e| content(path, e)))
}

fn write_to(file: impl Write + Seek, picture: &Picture, values: &[Values], look: &Look) -> exr::error::UnitResult {
    let width = picture.width as usize;
    let channels = values.iter().flat_map(|layer| {
        let channel = move |(index, name): (usize, &&str)| {
            AnyChannel::new(format!("{}{name}", layer.prefix).as_str(), Channel { layer, index, width })
        };
        layer.channels.iter().enumerate().map(channel)
    });
    let mut attributes = LayerAttributes::default();
    // One attribute of our own: the order of several would change from run to run.
    attributes.other.insert(SPP.into(), AttributeValue::I32(picture.spp as i32));
    attributes.comments = look.note.as_deref().map(Into::into);
    // A part of a film lies where it lies in the whole.
    attributes.layer_position = exr::math::Vec2(picture.corner[0] as i32, picture.corner[1] as i32);
    let size = (width, picture.height as usize);
    // A quarter longer than ZIP on pictures without noise, shorter on those with it, and in half the time.
    let encoding =
        Encoding { compression: Compression::PIZ, blocks: Blocks::ScanLines, line_order: LineOrder::Increasing };
    let layer = Layer::new(size, attributes, encoding, AnyChannels::sort(channels.collect()));
    let image = Image::from_layer(layer);
    image.write().to_buffered(file)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::Split;
    use crate::picture::Radiance;
    use crate::world::Counts;
    use exr::prelude::{FlatSamples, read_all_flat_layers_from_file};

    fn picture(emission: f32, direct: f32) -> Picture {
        let mut pixels = vec![Pixel::default(); 6];
        for (i, pixel) in pixels.iter_mut().enumerate() {
            let light = Split { diffuse: Rgb::splat(direct * (i + 1) as f32), glossy: Rgb::ZERO };
            let sum = Radiance { emission: Rgb::splat(emission), direct: light, distance: 3.0, ..Radiance::default() };
            pixel.set_sum(&sum);
            pixel.surfaces = 1;
        }
        let (counts, denoised, from_records) = (Counts::default(), None, false);
        let (width, height, corner) = (3, 2, [0, 0]);
        Picture { width, height, corner, pixels, spp: 1, passes: 1, outline_rays: 0, counts, from_records, denoised }
    }

    /// Channels of the file by name, and whether they are in half precision.
    fn written(picture: &Picture, parts: &[Part]) -> Vec<(String, bool, Vec<f32>)> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("p.exr");
        write(&path, picture, &Look { parts: parts.to_vec(), ..Look::default() }).unwrap();
        let read = read_all_flat_layers_from_file(&path).unwrap();
        let channels = &read.layer_data[0].channel_data.list;
        let channel = |c: &AnyChannel<FlatSamples>| {
            let half = matches!(c.sample_data, FlatSamples::F16(_));
            (c.name.to_string(), half, c.sample_data.values_as_f32().collect())
        };
        channels.iter().map(channel).collect()
    }

    #[test]
    fn halves_hold_what_fits_into_them() {
        for (emission, direct, halves) in
            [(5.0, 1.0, [true, true]), (1e6, 1e-3, [false, false]), (0.0, 1e4, [true, true])]
        {
            let picture = picture(emission, direct);
            let channels = written(&picture, &Part::ALL);
            let get = |name: &str| channels.iter().find(|c| c.0 == name).unwrap();
            assert_eq!([get("emission.R").1, get("direct.diffuse.G").1], halves);
            assert!(!get("R").1 && !get("depth.Z").1);
            for (i, pixel) in picture.pixels.iter().enumerate() {
                let light = direct * (i + 1) as f32;
                assert_eq!(get("R").2[i], pixel.sum().sum().x);
                assert!((get("direct.diffuse.G").2[i] - light).abs() <= light / 2048.0);
                assert!((get("emission.R").2[i] - emission).abs() <= emission / 2048.0);
            }
        }
    }

    #[test]
    fn a_file_has_the_layers_that_were_asked_for() {
        let picture = picture(1.0, 1.0);
        let names = |parts: &[Part]| written(&picture, parts).into_iter().map(|c| c.0).collect::<Vec<_>>();
        assert_eq!(names(&[]), ["B", "G", "R"]);
        assert_eq!(names(&[Part::Depth, Part::Noisy]), ["B", "G", "R", "depth.Z"]);
        assert_eq!(names(&Part::ALL).len(), 3 + 3 + 6 + 6 + 3 + 3 + 1);
    }
}
