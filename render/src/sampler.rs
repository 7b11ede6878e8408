//! Sample points as a pure function of (seed, pixel, sample, dimension): the picture does not depend on the number of
//! threads, on the tile order or on where a rendering was interrupted.

mod lanes;

use glam::Vec2;
pub(crate) use lanes::Samplers;

/// Owen-scrambled Sobol points in independent pairs of dimensions, padded by shuffling the index (Burley 2020,
/// "Practical hash-based Owen scrambling").
#[derive(Clone, Copy, Debug)]
pub struct Sampler {
    /// The sample's index with its bits reversed, in which the nested shuffle works.
    reversed_index: u32,
    key: u64,
    pair: u32,
}

impl Sampler {
    /// Points of sample `index` of a pixel.
    #[inline]
    pub fn new(seed: u64, pixel: (u32, u32), index: u32) -> Self {
        let pixel = u64::from(pixel.1) << 32 | u64::from(pixel.0);
        Self { reversed_index: index.reverse_bits(), key: mix(mix(seed) ^ pixel), pair: 0 }
    }

    /// Points of another sample of the same pixel.
    #[inline]
    pub fn with_index(self, index: u32) -> Self {
        Self { reversed_index: index.reverse_bits(), pair: 0, ..self }
    }

    /// The next two dimensions: a (0,2)-sequence over the samples of a pixel.
    #[inline]
    pub fn next_2d(&mut self) -> Vec2 {
        let pair = self.pair;
        self.pair += 1;
        let coordinate = |y| {
            let (shuffle, scramble) = seeds(self.key, pair, y);
            self.coordinate(shuffle, scramble, y)
        };
        Vec2::new(coordinate(false), coordinate(true))
    }

    /// The same as four calls of [`Sampler::next_2d`], computed side by side: what one scattering needs. What the samples of a
    /// pixel have in common stays in `scrambles`.
    #[inline(always)]
    pub fn next_4x2d(&mut self, scrambles: &mut Scrambles) -> [Vec2; 4] {
        let Scramble { shuffle, scramble } = scrambles.get(self.key, self.pair);
        self.pair += 4;
        // One loop of eight equal steps, which the compiler turns into vector instructions.
        let mut coordinates = [0.0; 8];
        for (i, coordinate) in coordinates.iter_mut().enumerate() {
            *coordinate = self.coordinate(shuffle[i], scramble[i], i >= 4);
        }
        core::array::from_fn(|i| Vec2::new(coordinates[i], coordinates[i + 4]))
    }

    /// One coordinate of a pair. No branches and no 64-bit arithmetic, which vector instructions lack.
    #[inline(always)]
    fn coordinate(&self, shuffle: u32, scramble: u32, y: bool) -> f32 {
        let index = owen(self.reversed_index, shuffle).reverse_bits();
        to_unit(owen(if y { pascal(index) } else { index }, scramble))
    }

    /// The next dimension, from a pair of its own.
    #[inline]
    pub fn next_1d(&mut self) -> f32 {
        self.next_2d().x
    }
}

/// What scrambles four pairs of dimensions, the same for all samples of a pixel.
#[derive(Clone, Copy, Debug)]
struct Scramble {
    /// First coordinates of the pairs, then second ones.
    shuffle: [u32; 8],
    scramble: [u32; 8],
}

impl Scramble {
    #[inline(always)]
    fn new(key: u64, pair: u32) -> Self {
        let mut this = Self { shuffle: [0; 8], scramble: [0; 8] };
        for i in 0..8 {
            (this.shuffle[i], this.scramble[i]) = seeds(key, pair + (i as u32 & 3), i >= 4);
        }
        this
    }
}

/// The scrambles of a pixel, in the order in which they were asked for.
#[derive(Clone, Debug, Default)]
pub struct Scrambles {
    key: u64,
    /// By first pair.
    known: Vec<(u32, Scramble)>,
}

impl Scrambles {
    /// What the pairs from `pair` on are scrambled by.
    #[inline(always)]
    fn get(&mut self, key: u64, pair: u32) -> Scramble {
        if self.key != key {
            self.key = key;
            self.known.clear();
        }
        let place = (pair / 4) as usize;
        match self.known.get(place) {
            Some(&(of, known)) if of == pair => known,
            _ => self.learn(pair),
        }
    }

    /// Paths ask for one scramble after the other, so that each finds its place.
    #[inline(never)]
    fn learn(&mut self, pair: u32) -> Scramble {
        let new = Scramble::new(self.key, pair);
        let place = (pair / 4) as usize;
        self.known.truncate(place);
        if self.known.len() == place {
            self.known.push((pair, new));
        }
        new
    }
}

/// Seeds of the nested shuffle of a pair's index, and of the scrambling of one of its coordinates.
#[inline(always)]
fn seeds(key: u64, pair: u32, y: bool) -> (u32, u32) {
    let (low, high) = (key as u32, (key >> 32) as u32);
    let shuffle = hash(low ^ hash(pair.wrapping_mul(0x9e37_79b9) ^ high));
    (shuffle, hash(shuffle ^ high.wrapping_add(if y { 0x85eb_ca6b } else { 0x2545_f491 })))
}

/// A permutation of 32 bits that leaves no pattern (Wellons 2018, "lowbias32").
#[inline(always)]
fn hash(x: u32) -> u32 {
    let x = (x ^ (x >> 16)).wrapping_mul(0x7feb_352d);
    let x = (x ^ (x >> 15)).wrapping_mul(0x846c_a68b);
    x ^ (x >> 16)
}

/// SplitMix64's finalizer.
#[inline]
fn mix(x: u64) -> u64 {
    let x = x.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

/// Whether a coin of bias `p` shows heads; equal arguments give equal answers.
pub(crate) fn toss<const N: usize>(p: f32, id: u64, place: [f32; N]) -> bool {
    let key = place.iter().fold(id, |key, x| mix(key ^ u64::from(x.to_bits())));
    p >= 1.0 || ((mix(key) >> 40) as f32 * (1.0 / (1 << 24) as f32)) < p
}

/// Nested uniform scrambling of bit-reversed numbers (Laine and Karras 2011, constants by Vegdahl 2021): every bit is
/// flipped depending on the bits below it only.
#[inline(always)]
fn owen(x: u32, seed: u32) -> u32 {
    let x = x ^ x.wrapping_mul(0x3d20_adea);
    let x = x.wrapping_add(seed).wrapping_mul((seed >> 16) | 1);
    let x = x ^ x.wrapping_mul(0x0552_6c56);
    x ^ x.wrapping_mul(0x53a2_2864)
}

/// Second Sobol dimension with its bits reversed: the Pascal matrix modulo 2, whose entry (k, j) is one where the bits
/// of k are among those of j (Lucas).
#[inline(always)]
fn pascal(x: u32) -> u32 {
    let x = x ^ ((x >> 16) & 0x0000_ffff);
    let x = x ^ ((x >> 8) & 0x00ff_00ff);
    let x = x ^ ((x >> 4) & 0x0f0f_0f0f);
    let x = x ^ ((x >> 2) & 0x3333_3333);
    x ^ ((x >> 1) & 0x5555_5555)
}

/// Bit-reversed fraction to [0, 1).
#[inline(always)]
fn to_unit(reversed: u32) -> f32 {
    (reversed.reverse_bits() >> 8) as f32 * (1.0 / (1 << 24) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(seed: u64, pixel: (u32, u32), pair: usize, n: u32) -> Vec<Vec2> {
        (0..n)
            .map(|i| {
                let mut s = Sampler::new(seed, pixel, i);
                for _ in 0..pair {
                    s.next_2d();
                }
                s.next_2d()
            })
            .collect()
    }

    #[test]
    fn every_elementary_interval_holds_one_point() {
        for (pixel, pair) in [((0, 0), 0), ((3, 7), 1), ((500, 2), 40)] {
            let (m, n) = (8, 256);
            let points = points(5, pixel, pair, n);
            for split in 0..=m {
                let (columns, rows) = ((1u32 << split) as f32, (1u32 << (m - split)) as f32);
                let mut seen = vec![false; n as usize];
                for p in &points {
                    let cell = (p.x * columns) as usize + (p.y * rows) as usize * columns as usize;
                    assert!(!core::mem::replace(&mut seen[cell], true), "split {split}");
                }
            }
        }
    }

    #[test]
    fn four_pairs_at_once_are_the_same() {
        let mut one = Sampler::new(3, (17, 4), 9);
        let mut four = one;
        let mut scrambles = Scrambles::default();
        for _ in 0..3 {
            let expected: [Vec2; 4] = core::array::from_fn(|_| one.next_2d());
            let mut again = four;
            assert_eq!(four.next_4x2d(&mut scrambles), expected);
            // Once more with what the first call left there.
            assert_eq!(again.next_4x2d(&mut scrambles), expected);
        }
    }

    #[test]
    fn pairs_pixels_and_seeds_are_uncorrelated() {
        let n = 4096;
        let sets = [points(1, (0, 0), 0, n), points(1, (0, 0), 1, n), points(1, (1, 0), 0, n), points(2, (0, 0), 0, n)];
        for i in 0..sets.len() {
            for j in 0..i {
                let dot: f32 = sets[i].iter().zip(&sets[j]).map(|(a, b)| (a.x - 0.5) * (b.x - 0.5)).sum();
                // standard deviation of one product of uniform numbers: 1/12
                assert!(dot.abs() < 4.0 * (n as f32).sqrt() / 12.0, "{i} {j}: {dot}");
            }
        }
    }

    #[test]
    fn integrates_better_than_random_points() {
        let n = 1024;
        let mean = |pixel| points(9, pixel, 2, n).iter().map(|p| (p.x * p.y).sqrt()).sum::<f32>() / n as f32;
        let rms = ((0..64).map(|i| (mean((i, 3)) - 4.0 / 9.0f32).powi(2)).sum::<f32>() / 64.0).sqrt();
        assert!(rms < 2e-4, "{rms}"); // independent points: 7e-3
    }
}
