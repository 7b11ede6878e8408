//! Texels in the precision of their file, and what is read of them.
//!
//! Integers go through a table of what each of them stands for, so that a look-up gives the very numbers that decoding
//! all of the image would. Textures that read different channels of one image share it.

use super::super::Rgb;
use super::bitmap::Taps;
use crate::color::from_srgb;
use crate::image::{Raster, Samples, half};
use crate::simd::prefetch;
use serde::{Deserialize, Serialize};
use std::sync::{Arc, OnceLock};

/// What is read of an image.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Reading {
    /// Red, green, blue.
    Color,
    /// Red, green, blue or alpha (0 to 3), shown in all three channels; alpha is 1 where the image has none.
    Channel(u8),
    /// Luminance, shown in all three channels; greys stay exactly as they are.
    Luminance,
    /// Red, 1 − green, blue: normals whose green points up the image, while v grows downwards.
    Normal,
    /// 1 where alpha reaches this, 0 elsewhere.
    Step(f32),
}

/// How stored values become linear ones. Alpha always is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Transfer {
    /// They are.
    Linear,
    /// The sRGB curve.
    Srgb,
    /// A power.
    Gamma(f32),
}

impl Transfer {
    /// The linear value.
    pub fn decode(self, value: f32) -> f32 {
        match self {
            Self::Linear => value,
            Self::Srgb => from_srgb(value),
            Self::Gamma(gamma) => value.max(0.0).powf(gamma),
        }
    }

    /// The linear value of every integer from 0 to `most`, which stands for 1.
    fn table(self, most: u16) -> Arc<[f32]> {
        static LINEAR: [OnceLock<Arc<[f32]>>; 2] = [const { OnceLock::new() }; 2];
        static SRGB: [OnceLock<Arc<[f32]>>; 2] = [const { OnceLock::new() }; 2];
        let new = || (0..=most).map(|i| self.decode(f32::from(i) / f32::from(most))).collect();
        let known = match self {
            Self::Linear => &LINEAR,
            Self::Srgb => &SRGB,
            Self::Gamma(_) => return new(),
        };
        known[usize::from(most == u16::MAX)].get_or_init(new).clone()
    }
}

/// An image, and what is read of it.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(from = "Parts", into = "Parts")]
pub struct Stored {
    parts: Parts,
    look_up: LookUp,
    /// What integers stand for; empty for others.
    table: Arc<[f32]>,
}

/// What the others are made of.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Parts {
    raster: Arc<Raster>,
    reading: Reading,
    transfer: Transfer,
}

/// A reading, with the places of the samples in a pixel of this image.
#[derive(Clone, Copy, Debug)]
enum LookUp {
    Color,
    One(usize),
    Luminance,
    Normal([usize; 3]),
    Step(usize, f32),
    Even(f32),
}

impl LookUp {
    /// The colour of a texel whose samples stand for `value` each.
    #[inline(always)]
    fn of<T: Copy>(self, pixel: &[T], value: impl Fn(T) -> f32) -> Rgb {
        let at = |channel: usize| value(pixel[channel]);
        match self {
            Self::Color => Rgb::new(at(0), at(1), at(2)),
            Self::One(channel) => Rgb::splat(at(channel)),
            Self::Luminance => Rgb::splat(luminance(Rgb::new(at(0), at(1), at(2)))),
            Self::Normal([r, g, b]) => Rgb::new(at(r), 1.0 - at(g), at(b)),
            Self::Step(channel, threshold) => Rgb::splat(step(at(channel), threshold)),
            Self::Even(value) => Rgb::splat(value),
        }
    }
}

fn step(alpha: f32, threshold: f32) -> f32 {
    if alpha >= threshold { 1.0 } else { 0.0 }
}

/// Luminance that leaves greys exactly as they are.
pub fn luminance(rgb: Rgb) -> f32 {
    if rgb.x == rgb.y && rgb.y == rgb.z { rgb.x } else { rgb.dot(Rgb::new(0.212671, 0.715160, 0.072169)) }
}

impl From<Parts> for Stored {
    fn from(parts: Parts) -> Self {
        let Parts { raster, reading, transfer } = &parts;
        let (color, alpha) = (raster.channels.color(), raster.channels.alpha());
        let is_gray = color[0] == color[2];
        let look_up = match *reading {
            Reading::Color | Reading::Luminance if is_gray => LookUp::One(color[0]),
            Reading::Color => LookUp::Color,
            Reading::Luminance => LookUp::Luminance,
            Reading::Channel(channel) if channel < 3 => LookUp::One(color[usize::from(channel)]),
            Reading::Channel(_) => alpha.map_or(LookUp::Even(1.0), LookUp::One),
            Reading::Normal => LookUp::Normal(color),
            Reading::Step(threshold) => {
                alpha.map_or(LookUp::Even(step(1.0, threshold)), |at| LookUp::Step(at, threshold))
            }
        };
        let table = match raster.samples {
            Samples::U8(_) => transfer.table(u8::MAX.into()),
            Samples::U16(_) => transfer.table(u16::MAX),
            Samples::Half(_) | Samples::F32(_) => [].into(),
        };
        Self { parts, look_up, table }
    }
}

impl From<Stored> for Parts {
    fn from(stored: Stored) -> Self {
        stored.parts
    }
}

impl PartialEq for Stored {
    fn eq(&self, other: &Self) -> bool {
        self.parts == other.parts
    }
}

impl Stored {
    /// An image read in a way. Where numbers of single or half precision are not linear, a decoded copy is kept instead.
    pub fn new(raster: Arc<Raster>, reading: Reading, transfer: Transfer) -> Self {
        let of_alpha = matches!(reading, Reading::Channel(3) | Reading::Step(_));
        let transfer = if of_alpha { Transfer::Linear } else { transfer };
        if transfer == Transfer::Linear || raster.is_display_referred() {
            return Parts { raster, reading, transfer }.into();
        }
        let (count, alpha) = (raster.channels.count(), raster.channels.alpha());
        let decode = |i: usize| {
            let value = raster.samples.get(i);
            if Some(i % count) == alpha { value } else { transfer.decode(value) }
        };
        let samples = Samples::F32((0..raster.samples.len()).map(decode).collect());
        let raster =
            Arc::new(Raster { samples, width: raster.width, height: raster.height, channels: raster.channels });
        Parts { raster, reading, transfer: Transfer::Linear }.into()
    }

    /// The image, which others may share.
    pub fn raster(&self) -> &Arc<Raster> {
        &self.parts.raster
    }

    /// Whether every texel is.
    pub fn is_finite(&self) -> bool {
        let integers = self.raster().is_display_referred();
        self.table.iter().all(|x| x.is_finite())
            && (integers || (0..self.raster().len()).all(|i| self.get(i).is_finite()))
    }

    /// Texel `i`.
    #[inline]
    pub fn get(&self, i: usize) -> Rgb {
        let count = self.raster().channels.count();
        let pixel = i * count..(i + 1) * count;
        match &self.raster().samples {
            Samples::U8(s) => self.look_up.of(&s[pixel], |x| self.table[usize::from(x)]),
            Samples::U16(s) => self.look_up.of(&s[pixel], |x| self.table[usize::from(x)]),
            Samples::Half(s) => self.look_up.of(&s[pixel], half),
            Samples::F32(s) => self.look_up.of(&s[pixel], |x| x),
        }
    }

    /// Reads a number of texel `i`, so that it comes to the cache.
    #[inline(always)]
    pub(super) fn touch(&self, i: usize) {
        let at = i * self.raster().channels.count();
        match &self.raster().samples {
            Samples::U8(s) => prefetch(&s[at]),
            Samples::U16(s) => prefetch(&s[at]),
            Samples::Half(s) => prefetch(&s[at]),
            Samples::F32(s) => prefetch(&s[at]),
        }
    }

    /// Texels blended: with its questions asked once for all of them where images are of the most common kinds.
    #[inline(always)]
    pub(super) fn blend(&self, taps: &Taps) -> Rgb {
        let count = self.raster().channels.count();
        let table: Option<&[f32; 256]> = self.table[..].try_into().ok();
        match (&self.raster().samples, self.look_up, table) {
            (Samples::U8(bytes), LookUp::Color, Some(table)) => taps.blend(|i| {
                let pixel = &bytes[i * count..][..3];
                let value = |channel: usize| table[usize::from(pixel[channel])];
                Rgb::new(value(0), value(1), value(2))
            }),
            (Samples::U8(bytes), LookUp::One(channel), Some(table)) => {
                taps.blend(|i| Rgb::splat(table[usize::from(bytes[i * count + channel])]))
            }
            (_, LookUp::Even(value), _) => Rgb::splat(value),
            _ => taps.blend(|i| self.get(i)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::Channels;

    fn stored(channels: Channels, samples: Samples, reading: Reading, transfer: Transfer) -> Stored {
        let width = (samples.len() / channels.count()) as u32;
        Stored::new(Arc::new(Raster { width, height: 1, channels, samples }), reading, transfer)
    }

    /// Every integer, through every curve, as the number that decoding it gives, to the last bit.
    #[test]
    fn integers_are_what_they_decode_to() {
        type Function = fn(f32) -> f32;
        let (linear, gamma): (Function, Function) = (|x| x, |x| x.powf(2.2));
        let curves = [(Transfer::Linear, linear), (Transfer::Srgb, from_srgb), (Transfer::Gamma(2.2), gamma)];
        for (transfer, curve) in curves {
            let eight = stored(Channels::Gray, Samples::U8((0..=255).collect()), Reading::Color, transfer);
            let sixteen = stored(Channels::Gray, Samples::U16((0..=65535).collect()), Reading::Color, transfer);
            for i in 0..=255u8 {
                assert_eq!(eight.get(i.into()).x.to_bits(), curve(f32::from(i) / 255.0).to_bits(), "{transfer:?} {i}");
            }
            for i in 0..=65535u16 {
                let expected = curve(f32::from(i) / 65535.0);
                assert_eq!(sixteen.get(i.into()).x.to_bits(), expected.to_bits(), "{transfer:?} {i}");
            }
        }
    }

    #[test]
    fn what_is_read_of_a_pixel() {
        let (srgb, linear) = (Transfer::Srgb, Transfer::Linear);
        let linear_of = |byte: u8| f32::from(byte) / 255.0;
        let srgb_of = |byte: u8| from_srgb(linear_of(byte));
        let rgba =
            |reading, transfer| stored(Channels::Rgba, Samples::U8(vec![10, 20, 30, 40]), reading, transfer).get(0);
        assert_eq!(rgba(Reading::Color, srgb), Rgb::new(srgb_of(10), srgb_of(20), srgb_of(30)));
        assert_eq!(rgba(Reading::Channel(1), linear), Rgb::splat(linear_of(20)));
        assert_eq!(rgba(Reading::Channel(3), srgb), Rgb::splat(linear_of(40)), "alpha is linear");
        assert_eq!(rgba(Reading::Normal, linear), Rgb::new(linear_of(10), 1.0 - linear_of(20), linear_of(30)));
        let color = Rgb::new(srgb_of(10), srgb_of(20), srgb_of(30));
        assert_eq!(rgba(Reading::Luminance, srgb), Rgb::splat(luminance(color)));
        assert_eq!(rgba(Reading::Step(linear_of(40)), srgb), Rgb::ONE);
        assert_eq!(rgba(Reading::Step(0.2), srgb), Rgb::ZERO);
        // Images of other channels.
        let gray = |reading| stored(Channels::GrayAlpha, Samples::U8(vec![10, 40]), reading, srgb).get(0);
        assert_eq!(gray(Reading::Color), Rgb::splat(srgb_of(10)));
        assert_eq!(gray(Reading::Luminance), gray(Reading::Color));
        assert_eq!(gray(Reading::Channel(2)), gray(Reading::Color));
        assert_eq!(gray(Reading::Channel(3)), Rgb::splat(linear_of(40)));
        let opaque = |reading| stored(Channels::Rgb, Samples::U16(vec![1, 2, 3]), reading, srgb).get(0);
        assert_eq!(opaque(Reading::Channel(3)), Rgb::ONE);
        assert_eq!((opaque(Reading::Step(1.0)), opaque(Reading::Step(1.5))), (Rgb::ONE, Rgb::ZERO));
        assert_eq!(opaque(Reading::Channel(2)), Rgb::splat(from_srgb(3.0 / 65535.0)));
    }

    #[test]
    fn curves_of_single_precision_spare_alpha() {
        let samples = Samples::F32(vec![0.5, -0.25, 4.0, 0.5]);
        let read = |reading, transfer| stored(Channels::Rgba, samples.clone(), reading, transfer).get(0);
        assert_eq!(read(Reading::Color, Transfer::Linear), Rgb::new(0.5, -0.25, 4.0));
        assert_eq!(read(Reading::Color, Transfer::Gamma(2.0)), Rgb::new(0.25, 0.0, 16.0));
        assert_eq!(read(Reading::Channel(3), Transfer::Gamma(2.0)), Rgb::splat(0.5));
    }

    #[test]
    fn readings_of_one_image_share_it() {
        let image = Arc::new(Raster {
            width: 2,
            height: 1,
            channels: Channels::Rgb,
            samples: Samples::U8(vec![1, 2, 3, 4, 5, 6]),
        });
        let green = Stored::new(image.clone(), Reading::Channel(1), Transfer::Linear);
        let blue = Stored::new(image.clone(), Reading::Channel(2), Transfer::Linear);
        assert!(Arc::ptr_eq(green.raster(), blue.raster()));
        assert_eq!((green.get(1).x, blue.get(1).x), (5.0 / 255.0, 6.0 / 255.0));
    }
}
