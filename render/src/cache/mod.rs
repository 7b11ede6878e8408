//! A cache of records of one kind: octree, radius policy, and filling in waves.

mod adapt;
mod fill;
mod lookup;
mod octree;
mod radius;
mod spheres;

use crate::record::Record;
pub use adapt::{Shrink, WEBER_FRACTION, disagreeing};
pub use fill::{BATCH, Course, Density, Filler, Grid, Progress};
use glam::Vec3A;
pub use lookup::Lookup;
pub use octree::Octree;
#[cfg(feature = "gpu")]
pub(crate) use radius::{BEHIND, NORMAL_SPREAD};
pub use radius::{RadiusPolicy, Spacing, Weight, clamp_to_neighbours, insert_clamped};
pub use spheres::{Drawn, Near, Spheres};

/// Sum of weights from which on records count as found.
pub const FOUND: f32 = 1e-3;

/// Records and where they are.
#[derive(Clone, Debug)]
pub struct Cache<R> {
    records: Vec<R>,
    octree: Octree,
}

impl<R: Record> Cache<R> {
    /// An empty cache for a scene with these corners.
    pub fn new(min: Vec3A, max: Vec3A) -> Self {
        Self { records: Vec::new(), octree: Octree::new(min, max) }
    }

    /// All records, in the order of their insertion.
    pub fn records(&self) -> &[R] {
        &self.records
    }

    /// Memory of the records, bytes.
    pub fn bytes(&self) -> usize {
        self.records.iter().map(R::bytes).sum()
    }

    /// Adds a record whose radius is set; what is not finite is turned away here, at the cache's only door.
    pub fn insert(&mut self, record: R) {
        let (position, radius) = (record.position(), record.radius());
        if record.is_finite() && radius.is_finite() && radius > 0.0 {
            self.octree.insert(self.records.len() as u32, position, radius);
            self.records.push(record);
        }
    }

    /// Files all records anew by the radii that they have now: many have shrunk since they came. Sums over records then have
    /// the order that they have in a cache read from a file.
    pub fn refile(&mut self) {
        self.octree.clear();
        for (i, record) in (0..).zip(&self.records) {
            self.octree.insert(i, record.position(), record.radius());
        }
    }

    /// Calls `found` with every record that counts at a point, and its weight.
    #[inline]
    pub fn interpolate(&self, position: Vec3A, normal: Vec3A, weight: Weight, mut found: impl FnMut(&R, f32)) {
        self.visit(position, normal, weight, |_, record, w| found(record, w));
    }

    /// [`Cache::interpolate`] with the index of the record.
    #[inline]
    pub fn visit(&self, position: Vec3A, normal: Vec3A, weight: Weight, mut found: impl FnMut(u32, &R, f32)) {
        self.octree.visit(position, |i| {
            let record = &self.records[i as usize];
            let w = weight.of(record, position, normal);
            if w > 0.0 {
                found(i, record, w);
            }
        });
    }

    /// The record nearest to a point, if there is any.
    pub fn nearest(&self, position: Vec3A) -> Option<&R> {
        let distance = |r: &R| r.position().distance_squared(position);
        self.records.iter().min_by(|a, b| distance(a).total_cmp(&distance(b)))
    }
}
