//! Pixels in the precision of their file.

use serde::{Deserialize, Serialize, Serializer};

/// Which channels a pixel has, in this order.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Channels {
    /// One that stands for red, green and blue.
    Gray,
    /// The same, and alpha.
    GrayAlpha,
    /// Red, green, blue.
    Rgb,
    /// Red, green, blue, alpha.
    #[default]
    Rgba,
}

impl Channels {
    /// Samples of a pixel.
    #[inline]
    pub fn count(self) -> usize {
        match self {
            Self::Gray => 1,
            Self::GrayAlpha => 2,
            Self::Rgb => 3,
            Self::Rgba => 4,
        }
    }

    /// Where red, green and blue stand.
    pub fn color(self) -> [usize; 3] {
        match self {
            Self::Gray | Self::GrayAlpha => [0; 3],
            Self::Rgb | Self::Rgba => [0, 1, 2],
        }
    }

    /// Where alpha stands.
    pub fn alpha(self) -> Option<usize> {
        match self {
            Self::Gray | Self::Rgb => None,
            Self::GrayAlpha => Some(1),
            Self::Rgba => Some(3),
        }
    }
}

/// Numbers as a file stores them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Samples {
    /// 255 stands for 1; values for display.
    U8(#[serde(serialize_with = "as_bytes")] Vec<u8>),
    /// 65535 stands for 1; values for display.
    U16(Vec<u16>),
    /// The bits of finite half-precision numbers (IEEE 754 binary16); linear.
    Half(Vec<u16>),
    /// Single precision; linear.
    F32(Vec<f32>),
}

/// Bytes one by one take fifty times as long to write.
fn as_bytes<S: Serializer>(bytes: &[u8], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_bytes(bytes)
}

impl Default for Samples {
    fn default() -> Self {
        Self::F32(Vec::new())
    }
}

impl Samples {
    /// How many there are.
    pub fn len(&self) -> usize {
        match self {
            Self::U8(s) => s.len(),
            Self::U16(s) | Self::Half(s) => s.len(),
            Self::F32(s) => s.len(),
        }
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Memory that they take.
    pub fn bytes(&self) -> usize {
        match self {
            Self::U8(s) => size_of_val(&s[..]),
            Self::U16(s) | Self::Half(s) => size_of_val(&s[..]),
            Self::F32(s) => size_of_val(&s[..]),
        }
    }

    /// Number `i`; integers from 0 to 1.
    #[inline]
    pub fn get(&self, i: usize) -> f32 {
        match self {
            Self::U8(s) => f32::from(s[i]) / 255.0,
            Self::U16(s) => f32::from(s[i]) / 65535.0,
            Self::Half(s) => half(s[i]),
            Self::F32(s) => s[i],
        }
    }
}

/// The value of a finite half-precision number.
#[inline]
pub fn half(bits: u16) -> f32 {
    const IMPLICIT_BIT: u32 = 0x400;
    const SMALLEST: f32 = 1.0 / 16_777_216.0;
    let magnitude = u32::from(bits & 0x7fff);
    // Exponents are biased by 15 there and by 127 here; numbers without the implicit bit are multiples of the smallest.
    let value = if magnitude < IMPLICIT_BIT {
        magnitude as f32 * SMALLEST
    } else {
        f32::from_bits((magnitude << 13) + (112 << 23))
    };
    f32::from_bits(value.to_bits() | u32::from(bits & 0x8000) << 16)
}

/// An image, row by row from the top, the samples of a pixel side by side.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Raster {
    /// Pixels per row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// What a pixel has.
    pub channels: Channels,
    /// `width · height` times as many numbers as a pixel has channels; colours are finite.
    pub samples: Samples,
}

impl Raster {
    /// Number of pixels.
    pub fn len(&self) -> usize {
        self.samples.len() / self.channels.count()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Whether the format is made for display (8-bit or 16-bit integers under the sRGB curve, but for alpha) rather than for
    /// linear light.
    pub fn is_display_referred(&self) -> bool {
        matches!(self.samples, Samples::U8(_) | Samples::U16(_))
    }

    /// Red, green, blue and alpha of pixel `i` as stored: no transfer function has been undone. Alpha is 1 where the file
    /// has none.
    #[inline]
    pub fn pixel(&self, i: usize) -> [f32; 4] {
        let start = i * self.channels.count();
        let [r, g, b] = self.channels.color().map(|c| self.samples.get(start + c));
        [r, g, b, self.channels.alpha().map_or(1.0, |a| self.samples.get(start + a))]
    }

    /// All pixels.
    pub fn pixels(&self) -> impl Iterator<Item = [f32; 4]> {
        (0..self.len()).map(|i| self.pixel(i))
    }

    /// The first pixel (column, row) whose alpha is not finite.
    pub fn alpha_not_finite(&self) -> Option<(u32, u32)> {
        match self.samples {
            Samples::F32(_) => self.find(|p| !p[3].is_finite()),
            _ => None,
        }
    }

    #[cfg(feature = "formats")]
    /// The first pixel (column, row) with a colour that is not finite.
    pub(super) fn color_not_finite(&self) -> Option<(u32, u32)> {
        match self.samples {
            Samples::F32(_) => self.find(|p| !p[..3].iter().all(|c| c.is_finite())),
            _ => None,
        }
    }

    fn find(&self, wrong: impl Fn(&[f32; 4]) -> bool) -> Option<(u32, u32)> {
        let at = self.pixels().position(|p| wrong(&p))? as u32;
        Some((at % self.width, at / self.width))
    }
}
