//! Who finds the records that count at a point.

use super::{Cache, Weight};
use crate::record::Record;
use glam::Vec3A;

/// Something that finds the records which count at a point: an octree, or the list of those drawn onto a tile of pixels.
pub trait Lookup<R> {
    /// Calls `found` with every record that counts at a point, and its weight. The order is that of the octree of a cache that was
    /// filed anew ([`Cache::refile`]), whoever finds them, so that sums over them are the same to the last bit.
    fn interpolate(&self, position: Vec3A, normal: Vec3A, weight: Weight, found: impl FnMut(&R, f32));
}

impl<R: Record> Lookup<R> for Cache<R> {
    #[inline]
    fn interpolate(&self, position: Vec3A, normal: Vec3A, weight: Weight, found: impl FnMut(&R, f32)) {
        Self::interpolate(self, position, normal, weight, found);
    }
}

impl<R, L: Lookup<R>> Lookup<R> for &L {
    #[inline]
    fn interpolate(&self, position: Vec3A, normal: Vec3A, weight: Weight, found: impl FnMut(&R, f32)) {
        (**self).interpolate(position, normal, weight, found);
    }
}
