//! Records found from the other side: not by a point that looks for them, but drawn where they reach, onto tiles of pixels
//! ("Radiance Cache Splatting", 2005, Algorithm 1).

use super::{Cache, Lookup, Weight};
use crate::record::Record;
use fearless_simd::{Level, Simd, dispatch, f32x16, prelude::*};
use glam::Vec3A;

/// Spheres that are tested at once.
const LANES: usize = 16;

/// Relative room for the rounding of a squared distance: the weight decides, the test only rules out.
const ROOM: f32 = 1.0 + 1e-5;

/// The spheres in which the records of a cache count, in the order in which an octree visits them.
#[derive(Clone, Debug, Default)]
pub struct Spheres {
    /// Index of the record, centre and radius.
    all: Vec<(u32, Vec3A, f32)>,
}

impl Spheres {
    /// Those of a cache.
    pub fn of<R: Record>(cache: &Cache<R>) -> Self {
        let mut all: Vec<_> = (0..).zip(&cache.records).map(|(i, r)| (i, r.position(), r.radius())).collect();
        // Records of one level stay in the order of their insertion.
        all.sort_by_cached_key(|&(_, _, radius)| cache.octree.level(radius));
        Self { all }
    }

    /// Number of them.
    pub fn len(&self) -> usize {
        self.all.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.all.is_empty()
    }

    /// Centre and radius of one, in their order.
    #[inline]
    pub fn get(&self, i: usize) -> (Vec3A, f32) {
        let (_, center, radius) = self.all[i];
        (center, radius)
    }
}

/// The spheres near a tile of pixels, in their order: columns of numbers, padded with spheres that hold nothing.
#[derive(Clone, Debug, Default)]
pub struct Near {
    /// Indices of the records.
    records: Vec<u32>,
    /// Coordinates of the centres, and squared radii.
    columns: [Vec<[f32; LANES]>; 4],
}

impl Near {
    /// Forgets them.
    pub fn clear(&mut self) {
        self.records.clear();
        self.columns.iter_mut().for_each(Vec::clear);
    }

    /// Adds a sphere, which comes after those there are.
    #[inline]
    pub fn add(&mut self, spheres: &Spheres, i: usize) {
        let (record, center, radius) = spheres.all[i];
        let lane = self.records.len() % LANES;
        if lane == 0 {
            self.columns.iter_mut().for_each(|column| column.push([f32::NEG_INFINITY; LANES]));
        }
        let numbers = [center.x, center.y, center.z, radius * radius * ROOM];
        for (column, number) in self.columns.iter_mut().zip(numbers) {
            if let Some(last) = column.last_mut() {
                last[lane] = number;
            }
        }
        self.records.push(record);
    }

    /// Number of spheres.
    pub fn len(&self) -> usize {
        self.records.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.records.is_empty()
    }

    /// Indices of the records, in their order.
    #[cfg(feature = "gpu")]
    pub fn records(&self) -> &[u32] {
        &self.records
    }

    /// Calls `found` with the records whose spheres may hold a point.
    #[inline]
    fn visit(&self, p: Vec3A, mut found: impl FnMut(u32)) {
        // Bits of up to 32 blocks at a time: their memory stays on the stack.
        const BLOCKS: usize = 32;
        let mut bits = [0u16; BLOCKS];
        let blocks = self.columns[0].len();
        for first in (0..blocks).step_by(BLOCKS) {
            let count = BLOCKS.min(blocks - first);
            let columns = self.columns.each_ref().map(|column| &column[first..first + count]);
            let bits = &mut bits[..count];
            dispatch!(Level::new(), simd => hold(simd, columns, p, bits));
            for (block, &bits) in (first..).zip(&*bits) {
                let mut left = bits;
                while left != 0 {
                    found(self.records[LANES * block + left.trailing_zeros() as usize]);
                    left &= left - 1;
                }
            }
        }
    }
}

/// Which spheres hold a point: a bit for each.
#[inline(always)]
fn hold<S: Simd>(simd: S, columns: [&[[f32; LANES]]; 4], p: Vec3A, bits: &mut [u16]) {
    let [x, y, z] = p.to_array().map(|x| f32x16::splat(simd, x));
    let [xs, ys, zs, squares] = columns;
    for ((((cx, cy), cz), square), bits) in xs.iter().zip(ys).zip(zs).zip(squares).zip(bits) {
        let [cx, cy, cz, square] = [cx, cy, cz, square].map(|lanes| f32x16::load_array_ref(simd, lanes));
        let (dx, dy, dz) = (cx - x, cy - y, cz - z);
        *bits = (dx * dx + dy * dy + dz * dz).simd_lt(square).to_bitmask() as u16;
    }
}

/// The records of a cache that are drawn onto a tile.
pub struct Drawn<'a, R> {
    /// All of the cache.
    pub cache: &'a Cache<R>,
    /// Those that may reach what the tile shows.
    pub near: &'a Near,
}

impl<'a, R> Drawn<'a, R> {
    /// All of the tile, in the order in which [`Lookup::interpolate`] calls them.
    pub fn records(&self) -> impl Iterator<Item = &'a R> {
        let Self { cache, near } = *self;
        near.records.iter().map(|&i| &cache.records[i as usize])
    }
}

impl<R: Record> Lookup<R> for Drawn<'_, R> {
    #[inline]
    fn interpolate(&self, position: Vec3A, normal: Vec3A, weight: Weight, mut found: impl FnMut(&R, f32)) {
        self.near.visit(position, |i| {
            let record = &self.cache.records[i as usize];
            let w = weight.of(record, position, normal);
            if w > 0.0 {
                found(record, w);
            }
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::{Frame, uniform_sphere};
    use crate::hemisphere::Incident;
    use crate::record::irradiance::{IrradianceRecord, Strata};
    use crate::scene::Rgb;
    use glam::Vec2;

    fn number(i: u32, k: u32) -> f32 {
        (i.wrapping_mul(2_654_435_761).wrapping_add(k.wrapping_mul(0x9e37_79b9)) >> 8) as f32 / (1 << 24) as f32
    }

    /// A tile that has all records finds those of the octree with the same weights, in the same order.
    #[test]
    fn order_and_weights_are_those_of_the_octree() {
        let mut cache = Cache::new(Vec3A::ZERO, Vec3A::ONE);
        for i in 0..700 {
            let dark = |_: Vec3A, _: u32| Incident { radiance: Rgb::ONE, distance: 1.0, normal: Vec3A::ZERO };
            let position = Vec3A::new(number(i, 1), number(i, 2), 0.05 * number(i, 3));
            let frame = Frame::from_normal(Vec3A::Z);
            let gathered = IrradianceRecord::gather(position, &frame, Strata::about(8), |_| Vec2::splat(0.5), dark);
            let mut record = gathered.record;
            record.set_radius(0.3 * number(i, 4).powi(3) + 1e-6);
            cache.insert(record);
        }
        let spheres = Spheres::of(&cache);
        let mut near = Near::default();
        (0..spheres.len()).for_each(|i| near.add(&spheres, i));
        assert_eq!((near.len(), near.is_empty()), (700, false));
        let drawn = Drawn { cache: &cache, near: &near };
        let mut all = 0;
        for i in 0..400 {
            let p = Vec3A::new(number(i, 5), number(i, 6), 0.05 * number(i, 7));
            let turned = (Vec3A::Z + 0.1 * uniform_sphere(Vec2::new(number(i, 8), number(i, 9)))).normalize();
            for weight in [Weight::Smooth, Weight::Ward] {
                let (mut a, mut b) = (Vec::new(), Vec::new());
                cache.interpolate(p, turned, weight, |r, w| a.push((r.position(), w)));
                drawn.interpolate(p, turned, weight, |r, w| b.push((r.position(), w)));
                assert_eq!(a, b, "{i}");
                all += a.len();
            }
        }
        assert!(all > 2000, "{all}");
    }
}
