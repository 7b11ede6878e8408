//! Surfaces of one kind of record, tile by tile, and their sums.

use super::programs::Kernel;
use crate::gpu::{Device, GpuError};
use bytemuck::Pod;
use wgpu::Buffer;

/// What of a tile the card is to find by one kind of record.
pub struct Part<S> {
    pub surfaces: Vec<S>,
    /// Indices of the records drawn onto the tile.
    pub near: Vec<u32>,
}

impl<S> Default for Part<S> {
    fn default() -> Self {
        Self { surfaces: Vec::new(), near: Vec::new() }
    }
}

/// Tiles side by side.
pub struct Batch<S> {
    /// First surface, surfaces, first record and records of each.
    tiles: Vec<[u32; 4]>,
    near: Vec<u32>,
    surfaces: Vec<S>,
}

impl<S: Pod> Batch<S> {
    /// Those that have surfaces.
    pub fn new<'a>(tiles: impl Iterator<Item = &'a Part<S>>) -> Self {
        let mut batch = Self { tiles: Vec::new(), near: Vec::new(), surfaces: Vec::new() };
        for Part { surfaces, near } in tiles.filter(|tile| !tile.surfaces.is_empty()) {
            let firsts = [batch.surfaces.len() as u32, batch.near.len() as u32];
            batch.tiles.push([firsts[0], surfaces.len() as u32, firsts[1], near.len() as u32]);
            batch.surfaces.extend(surfaces);
            batch.near.extend(near);
        }
        batch
    }

    /// The sums of all surfaces over the records of their tiles; `more` is bound after all else.
    ///
    /// # Errors
    /// Those of the card.
    pub fn sums<T: Pod>(
        &self,
        device: &Device,
        kernel: &Kernel,
        records: &Buffer,
        more: &[&Buffer],
    ) -> Result<Vec<T>, GpuError> {
        if self.surfaces.is_empty() {
            return Ok(Vec::new());
        }
        let tiles = device.upload("the tiles", &self.tiles)?;
        let near = device.upload("the records of tiles", &self.near)?;
        let surfaces = device.upload("the surfaces of tiles", &self.surfaces)?;
        let sums = device.room("the sums of surfaces", (self.surfaces.len() * size_of::<T>()) as u64)?;
        let largest = |i: usize| self.tiles.iter().map(|tile| tile[i]).max().unwrap_or(0);
        let groups = kernel.groups(self.tiles.len(), largest(1));
        for first in (0..largest(3)).step_by(kernel.run as usize) {
            let first = device.upload("the first record of a run", &[first])?;
            let bound = [&[&tiles, &near, &surfaces, records, &sums, &first], more].concat();
            device.run(&kernel.program, &bound, groups);
        }
        device.read(&sums)
    }
}
