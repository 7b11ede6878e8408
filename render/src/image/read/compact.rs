//! The least memory that holds the same numbers.

use crate::image::{Channels, Raster, Samples, half};
use exr::prelude::f16;

/// Linear pixels (red, green, blue, alpha) without channels that say nothing, in half precision where no number changes.
pub(super) fn compact(width: u32, height: u32, rgba: Vec<[f32; 4]>) -> Raster {
    let is_gray = rgba.iter().all(|&[r, g, b, _]| r.to_bits() == g.to_bits() && g.to_bits() == b.to_bits());
    let is_opaque = rgba.iter().all(|p| p[3] == 1.0);
    let channels = match (is_gray, is_opaque) {
        (true, true) => Channels::Gray,
        (true, false) => Channels::GrayAlpha,
        (false, true) => Channels::Rgb,
        (false, false) => Channels::Rgba,
    };
    let kept: &[usize] = match channels {
        Channels::Gray => &[0],
        Channels::GrayAlpha => &[0, 3],
        Channels::Rgb => &[0, 1, 2],
        Channels::Rgba => &[0, 1, 2, 3],
    };
    let samples = match gather(&rgba, kept, to_half) {
        Some(bits) => Samples::Half(bits),
        None => Samples::F32(gather(&rgba, kept, Some).unwrap_or_default()),
    };
    Raster { width, height, channels, samples }
}

/// The kept channels of all pixels, each number as `store` has it; `None` where it has one not.
fn gather<T>(rgba: &[[f32; 4]], kept: &[usize], store: impl Fn(f32) -> Option<T>) -> Option<Vec<T>> {
    let mut stored = Vec::with_capacity(rgba.len() * kept.len());
    for pixel in rgba {
        for &channel in kept {
            stored.push(store(pixel[channel])?);
        }
    }
    Some(stored)
}

/// The bits of a finite number that half precision holds exactly.
fn to_half(value: f32) -> Option<u16> {
    const INFINITE: u16 = 0x7c00;
    let bits = f16::from_f32(value).to_bits();
    let exact = bits & INFINITE != INFINITE && half(bits).to_bits() == value.to_bits();
    exact.then_some(bits)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_half_is_what_it_was() {
        let finite = (0..=u16::MAX).filter(|bits| f16::from_bits(*bits).is_finite());
        for bits in finite {
            let value = f16::from_bits(bits).to_f32();
            assert_eq!(half(bits).to_bits(), value.to_bits(), "{bits:#x}");
            assert_eq!(to_half(value), Some(bits));
        }
        for value in [0.1, 65536.0, 1e6, 1e-9, f32::INFINITY, f32::NAN] {
            assert_eq!(to_half(value), None, "{value}");
        }
    }

    #[test]
    fn nothing_is_lost_and_nothing_kept_twice() {
        for (pixels, channels, bytes) in [
            (vec![[0.5, 0.5, 0.5, 1.0], [2.0, 2.0, 2.0, 1.0]], Channels::Gray, 4),
            (vec![[0.5, 0.5, 0.5, 1.0], [2.0, 2.0, 2.0, 0.1]], Channels::GrayAlpha, 16),
            (vec![[0.5, -0.25, 0.0, 1.0], [1.0, 2.0, 3.0, 1.0]], Channels::Rgb, 12),
            (vec![[0.1, -0.25, -0.0, 1.0], [1.0, 2.0, 3.0, 1.0]], Channels::Rgb, 24),
            (vec![[0.5, -0.25, 0.0, 0.5], [1.0, 2.0, 3.0, 1.0]], Channels::Rgba, 16),
            (vec![[0.5, -0.25, 0.0, f32::INFINITY], [1.0, 2.0, 3.0, 1.0]], Channels::Rgba, 32),
        ] {
            let raster = compact(2, 1, pixels.clone());
            assert_eq!((raster.channels, raster.samples.bytes()), (channels, bytes), "{pixels:?}");
            let same = |(a, b): (&[f32; 4], [f32; 4])| a.map(f32::to_bits) == b.map(f32::to_bits);
            assert!(pixels.iter().zip(raster.pixels()).all(same), "{pixels:?}: {raster:?}");
        }
    }
}
