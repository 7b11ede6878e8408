//! Few samples that are far too bright must not be spread by a denoiser.

use super::layers::{Layer, Layers};
use crate::color::luminance;
use crate::scene::Rgb;
use core::ops::Range;
use rayon::prelude::*;

/// What a denoiser was not shown, of all light that is scattered.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Bounded {
    /// Pixels that were darkened.
    pub pixels: u64,
    /// Share of the light that was left out.
    pub share: f64,
}

/// Pixels each way that a pixel is compared with.
const REACH: usize = 3;

/// How many times brighter than its surroundings a sample may be where only one half of a pixel's samples has seen it, and the
/// pixel. Half as much takes a third of a percent of the light in a glossy box, and buys nothing.
const BRIGHTER_SAMPLE: f32 = 640.0;
const BRIGHTER_PIXEL: [f32; 2] = [16.0, 64.0];

/// What [`bound`] left out of the pixels that are denoised.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Loss {
    pixels: u64,
    lost: f64,
    all: f64,
}

impl core::ops::AddAssign for Loss {
    fn add_assign(&mut self, other: Self) {
        self.pixels += other.pixels;
        self.lost += other.lost;
        self.all += other.all;
    }
}

impl From<Loss> for Bounded {
    fn from(Loss { pixels, lost, all }: Loss) -> Self {
        Self { pixels, share: if all > 0.0 { lost / all } else { 0.0 } }
    }
}

/// Bounds what only one half of a pixel's samples, and none of its neighbours, has seen; and tells it of the `inner` pixels, those that
/// are denoised. The noisy picture keeps it.
pub(super) fn bound(layers: &mut Layers, inner: Range<usize>) -> Loss {
    let size = [layers.width, layers.height];
    let brighter = (BRIGHTER_SAMPLE / layers.spp.max(1) as f32).clamp(BRIGHTER_PIXEL[0], BRIGHTER_PIXEL[1]);
    let mut loss = Loss::default();
    for part in [&mut layers.direct, &mut layers.indirect].into_iter().flatten() {
        loss += layer(part, size, brighter, &inner);
    }
    loss
}

fn layer(layer: &mut Layer, [width, height]: [usize; 2], brighter: f32, inner: &Range<usize>) -> Loss {
    let means: Vec<f32> = layer.mean.iter().map(light).collect();
    let around = surroundings(&means, width, height);
    let mut loss = Loss::default();
    for (i, bright) in means.into_iter().enumerate() {
        // What both halves have seen is there.
        let sure = layer.halves.as_ref().map_or(0.0, |[a, b]| light(&a[i]).min(light(&b[i])));
        let limit = brighter * around[i].max(sure);
        let counts = inner.contains(&i);
        if counts {
            loss.all += f64::from(bright);
        }
        if bright > limit {
            let factor = limit / bright;
            layer.mean[i] = layer.mean[i].map(|x| x * factor);
            for half in layer.halves.iter_mut().flatten() {
                let own = light(&half[i]);
                if own > limit {
                    half[i] = half[i].map(|x| x * limit / own);
                }
            }
            if counts {
                loss.pixels += 1;
                loss.lost += f64::from(bright - limit);
            }
        }
    }
    loss
}

fn light(p: &[f32; 3]) -> f32 {
    luminance(Rgb::from_array(*p)).max(0.0)
}

/// Mean of the pixels around each, without itself and the brightest of them.
fn surroundings(values: &[f32], width: usize, height: usize) -> Vec<f32> {
    let pixel = |i: usize| {
        let (x, y) = (i % width, i / width);
        let (mut sum, mut most, mut count) = (0.0, 0f32, 0.0);
        for y in y.saturating_sub(REACH)..(y + REACH + 1).min(height) {
            for x in x.saturating_sub(REACH)..(x + REACH + 1).min(width) {
                let value = values[y * width + x];
                if y * width + x != i {
                    (sum, most, count) = (sum + value, most.max(value), count + 1.0);
                }
            }
        }
        (sum - most).max(0.0) / (count - 1f32).max(1.0)
    };
    (0..values.len()).into_par_iter().map(pixel).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn layers(halves: [f32; 2]) -> Layers {
        let mut layers = Layers::example(16);
        let even = vec![[1.0; 3]; 256];
        let mut layer = Layer { mean: even.clone(), halves: Some([even.clone(), even]), level: None };
        layer.mean[100] = [0.5 * (halves[0] + halves[1]); 3];
        if let Some(all) = &mut layer.halves {
            (all[0][100], all[1][100]) = ([halves[0]; 3], [halves[1]; 3]);
        }
        (layers.direct, layers.indirect) = (Some(layer), None);
        layers
    }

    #[test]
    fn what_one_half_has_seen_is_bounded_and_told() {
        let mut one = layers([1000.0, 1.0]);
        let bounded = Bounded::from(bound(&mut one, 0..256));
        assert_eq!(bounded.pixels, 1);
        let limit = BRIGHTER_PIXEL[1];
        assert!((bounded.share - f64::from(500.5 - limit) / 755.5).abs() < 1e-3, "{bounded:?}");
        let mean = one.direct.map(|l| l.mean).unwrap_or_default();
        assert!((mean[100][0] - limit).abs() < 1e-4 && mean[99] == [1.0; 3]);
        // Both have seen it: it is there.
        let mut both = layers([1000.0, 900.0]);
        let before = both.clone();
        assert_eq!((Bounded::from(bound(&mut both, 0..256)), both == before), (Bounded::default(), true));
        // Outside of what is denoised it is bounded and does not count.
        let mut outside = layers([1000.0, 1.0]);
        let bounded = Bounded::from(bound(&mut outside, 0..100));
        assert!(bounded == Bounded::default() && outside.direct.is_some_and(|l| (l.mean[100][0] - limit).abs() < 1e-4));
    }
}
