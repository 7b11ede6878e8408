//! Points of sixteen samples at once: the same numbers, bit by bit.

use super::Sampler;
use fearless_simd::prelude::*;
use fearless_simd::{f32x16, u32x16};

const LANES: usize = 16;

/// Sixteen samplers.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Samplers {
    reversed_index: [u32; LANES],
    low: [u32; LANES],
    high: [u32; LANES],
    pair: [u32; LANES],
}

impl Samplers {
    /// Puts one in its lane.
    #[inline(always)]
    pub fn set(&mut self, lane: usize, sampler: &Sampler) {
        self.reversed_index[lane] = sampler.reversed_index;
        (self.low[lane], self.high[lane]) = (sampler.key as u32, (sampler.key >> 32) as u32);
        self.pair[lane] = sampler.pair;
    }

    /// [`Sampler::next_4x2d`] of all: first coordinates of the pairs, then second ones.
    #[inline(always)]
    pub fn next_4x2d<S: Simd>(&mut self, simd: S) -> [[f32; LANES]; 8] {
        let load = |column: &[u32; LANES]| u32x16::load_array_ref(simd, column);
        let (reversed_index, low, high) = (load(&self.reversed_index), load(&self.low), load(&self.high));
        let first = load(&self.pair);
        let mut points = [[0.0; LANES]; 8];
        for i in 0..4 {
            let shuffle = hash(low ^ hash(((first + i) * 0x9e37_79b9) ^ high));
            let index = reverse_bits(owen(reversed_index, shuffle));
            let x = owen(index, hash(shuffle ^ (high + 0x2545_f491)));
            let y = owen(pascal(index), hash(shuffle ^ (high + 0x85eb_ca6b)));
            to_unit(x).store_array(&mut points[i as usize]);
            to_unit(y).store_array(&mut points[4 + i as usize]);
        }
        (first + 4).store_array(&mut self.pair);
        points
    }
}

/// [`super::hash`].
#[inline(always)]
fn hash<S: Simd>(x: u32x16<S>) -> u32x16<S> {
    let x = (x ^ (x >> 16)) * 0x7feb_352d;
    let x = (x ^ (x >> 15)) * 0x846c_a68b;
    x ^ (x >> 16)
}

/// [`super::owen`].
#[inline(always)]
fn owen<S: Simd>(x: u32x16<S>, seed: u32x16<S>) -> u32x16<S> {
    let x = x ^ (x * 0x3d20_adea);
    let x = (x + seed) * ((seed >> 16) | 1);
    let x = x ^ (x * 0x0552_6c56);
    x ^ (x * 0x53a2_2864)
}

/// [`super::pascal`].
#[inline(always)]
fn pascal<S: Simd>(x: u32x16<S>) -> u32x16<S> {
    let x = x ^ ((x >> 16) & 0x0000_ffff);
    let x = x ^ ((x >> 8) & 0x00ff_00ff);
    let x = x ^ ((x >> 4) & 0x0f0f_0f0f);
    let x = x ^ ((x >> 2) & 0x3333_3333);
    x ^ ((x >> 1) & 0x5555_5555)
}

/// [`super::to_unit`].
#[inline(always)]
fn to_unit<S: Simd>(reversed: u32x16<S>) -> f32x16<S> {
    let unit: f32x16<S> = (reverse_bits(reversed) >> 8).to_float();
    unit * (1.0 / (1 << 24) as f32)
}

#[inline(always)]
fn reverse_bits<S: Simd>(x: u32x16<S>) -> u32x16<S> {
    let x = ((x >> 1) & 0x5555_5555) | ((x & 0x5555_5555) << 1);
    let x = ((x >> 2) & 0x3333_3333) | ((x & 0x3333_3333) << 2);
    let x = ((x >> 4) & 0x0f0f_0f0f) | ((x & 0x0f0f_0f0f) << 4);
    let x = ((x >> 8) & 0x00ff_00ff) | ((x & 0x00ff_00ff) << 8);
    (x >> 16) | (x << 16)
}

#[cfg(test)]
mod tests {
    use super::super::Scrambles;
    use super::*;
    use fearless_simd::{Level, dispatch};

    #[test]
    fn sixteen_samplers_make_the_points_of_each() {
        let mut samplers = Samplers::default();
        let mut singles: Vec<_> = (0..LANES as u32).map(|i| Sampler::new(7, (i / 3, 9), 5 * i)).collect();
        let mut scrambles = Scrambles::default();
        singles.iter_mut().skip(4).for_each(|s| s.pair = 1);
        singles.iter().enumerate().for_each(|(i, s)| samplers.set(i, s));
        for _ in 0..3 {
            let points = dispatch!(Level::new(), simd => samplers.next_4x2d(simd));
            for (lane, single) in singles.iter_mut().enumerate() {
                for (pair, p) in single.next_4x2d(&mut scrambles).into_iter().enumerate() {
                    assert_eq!([points[pair][lane], points[4 + pair][lane]], p.to_array());
                }
            }
        }
    }
}
