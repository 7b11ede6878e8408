//! The surfaces of a picture on the card, some bands of tiles at a time.

use super::programs::{Programs, RUN, groups};
use super::{eas, irradiance};
use crate::cache::Near;
use crate::gpu::GpuError;
use crate::integrator::cached::kind::Found;
use crate::integrator::cached::kinds::eas::Held;
use crate::integrator::cached::kinds::{Glossy, Scratches};
use crate::integrator::cached::policy::Treatment;
use crate::integrator::cached::shade::Shader;
use crate::integrator::cached::splat::{SIDE, Splats, Tile};
use crate::integrator::cached::surface::Surface;
use crate::scene::Crop;
use rayon::prelude::*;
use wgpu::Buffer;

/// Pixels that go to the card at once: their surfaces take some tens of megabytes.
const PIXELS: usize = 1 << 18;

/// The records of a picture, on the card.
pub struct Card<'a> {
    shader: &'a Shader<'a>,
    programs: &'static Programs,
    irradiance: Buffer,
    eas: eas::Records,
}

/// The surfaces of a tile of pixels, in the order of the pixels.
#[derive(Default)]
struct TileWork<'a> {
    /// What is known, and what the card is to find.
    surfaces: Vec<Slot<'a>>,
    irradiance: Vec<irradiance::SurfaceRows>,
    irradiance_near: Vec<u32>,
    eas: Vec<eas::SurfaceRows>,
    eas_near: Vec<u32>,
}

/// A surface.
enum Slot<'a> {
    Known(Found),
    Irradiance(&'a Surface),
    Eas(&'a Surface, Held),
}

impl<'a> Card<'a> {
    /// Brings all records to the card.
    ///
    /// # Errors
    /// There is no card, or they are too many for it.
    pub fn new(shader: &'a Shader<'a>) -> Result<Self, GpuError> {
        let programs = Programs::shared()?;
        let (caches, kinds) = (shader.caches, &shader.policy.kinds);
        let irradiance = irradiance::records(programs.device, &caches.irradiance)?;
        let eas = eas::Records::new(programs.device, &caches.glossy.eas, &kinds.eas)?;
        Ok(Self { shader, programs, irradiance, eas })
    }

    /// What records say of the surfaces of whole rows of pixels whose light counts, tile by tile: bands of [`SIDE`] rows from the
    /// first, each from the left. `place` is the first pixel on the film.
    ///
    /// # Errors
    /// Those of the card.
    pub fn found(
        &self,
        splats: &Splats,
        place: (u32, u32),
        width: usize,
        surfaces: &[Vec<Surface>],
    ) -> Result<Vec<Vec<Found>>, GpuError> {
        let mut found = Vec::new();
        let bands = (PIXELS / (SIDE * width).max(1)).max(1);
        for (i, part) in surfaces.chunks(bands * SIDE * width).enumerate() {
            let first = place.1 + (i * bands * SIDE) as u32;
            let work: Vec<Vec<TileWork>> = (part.par_chunks(SIDE * width).enumerate())
                .map_init(Default::default, |memory, (band, rows)| {
                    self.band(splats, (place.0, first + (band * SIDE) as u32), width, rows, memory)
                })
                .collect();
            found.extend(self.run(work.into_iter().flatten().collect())?);
        }
        Ok(found)
    }

    /// The tiles of a band of rows.
    fn band<'s>(
        &self,
        splats: &Splats,
        place: (u32, u32),
        width: usize,
        surfaces: &'s [Vec<Surface>],
        (tile, scratch): &mut (Tile, Scratches),
    ) -> Vec<TileWork<'s>> {
        let height = surfaces.len() / width;
        splats.enter(place.1..place.1 + height as u32, tile);
        let each = |left: usize| {
            let columns = left..(left + SIDE).min(width);
            let crop =
                Crop { x: place.0 + left as u32, y: place.1, width: columns.len() as u32, height: height as u32 };
            let rows = surfaces.chunks(width).flat_map(|row| &row[columns.clone()]);
            let shown: Vec<&Surface> = rows.flatten().filter(|s| self.shader.has_indirect(s)).collect();
            splats.draw(&crop, &shown, tile);
            self.work(&shown, tile, scratch)
        };
        (0..width).step_by(SIDE).map(each).collect()
    }

    /// What of a tile the card is to find.
    fn work<'s>(&self, shown: &[&'s Surface], tile: &Tile, scratch: &mut Scratches) -> TileWork<'s> {
        let (shader, kinds) = (self.shader, &self.shader.policy.kinds);
        let mut work = TileWork::default();
        for s in shown {
            work.surfaces.push(match shader.policy.treatment(s.finish()) {
                Treatment::Irradiance => {
                    work.irradiance.push(irradiance::surface(s));
                    Slot::Irradiance(s)
                }
                Treatment::Glossy(Glossy::Eas(held)) if self.eas.has(held) => {
                    work.eas.push(eas::surface(&kinds.eas, held, &Shader::shaded(s, &s.parts)));
                    Slot::Eas(s, held)
                }
                Treatment::Traced => Slot::Known(Found::NOTHING),
                Treatment::Glossy(_) => Slot::Known(shader.found(s, &s.parts, scratch)),
            });
        }
        let listed = |surfaces: usize, near: &Near| if surfaces > 0 { near.records().to_vec() } else { Vec::new() };
        work.irradiance_near = listed(work.irradiance.len(), &tile.irradiance);
        work.eas_near = listed(work.eas.len(), &tile.glossy.eas);
        work
    }

    /// Runs the card on some tiles.
    fn run(&self, work: Vec<TileWork>) -> Result<Vec<Vec<Found>>, GpuError> {
        let Programs { device, irradiance: of_irradiance, eas: of_eas } = self.programs;
        let irradiance = Batch::new(work.iter().map(|w| (&w.irradiance[..], &w.irradiance_near[..])));
        let eas = Batch::new(work.iter().map(|w| (&w.eas[..], &w.eas_near[..])));
        let (mut diffuse, mut glossy) = (Vec::new(), Vec::new());
        if !irradiance.surfaces.is_empty() {
            let [tiles, near, surfaces, sums] = irradiance.buffers::<irradiance::SumRows>(device)?;
            for first in irradiance.runs(device)? {
                let bound = [&tiles, &near, &surfaces, &self.irradiance, &sums, &first];
                device.run(of_irradiance, &bound, irradiance.groups());
            }
            diffuse = device.read(&sums)?;
        }
        if !eas.surfaces.is_empty() {
            let [tiles, near, surfaces, sums] = eas.buffers::<eas::SumRows>(device)?;
            let eas::Records { records, sources, lobes, tables, .. } = &self.eas;
            for first in eas.runs(device)? {
                let bound = [&tiles, &near, &surfaces, records, &sums, &first, sources, lobes, tables];
                device.run(of_eas, &bound, eas.groups());
            }
            glossy = device.read(&sums)?;
        }
        let (mut diffuse, mut glossy) = (diffuse.into_iter(), glossy.into_iter());
        let mut of = |slot: &Slot| match slot {
            Slot::Known(found) => *found,
            Slot::Irradiance(s) => Shader::diffuse_found(s, &s.parts, diffuse.next().and_then(irradiance::found)),
            Slot::Eas(s, held) => glossy.next().map_or(Found::NOTHING, |rows| eas::sum(rows).found(*held, &s.parts)),
        };
        Ok(work.iter().map(|w| w.surfaces.iter().map(&mut of).collect()).collect())
    }
}

/// Tiles side by side.
struct Batch<S> {
    /// First surface, surfaces, first record and records of each.
    tiles: Vec<[u32; 4]>,
    near: Vec<u32>,
    surfaces: Vec<S>,
}

impl<S: bytemuck::Pod> Batch<S> {
    /// Those that have surfaces.
    fn new<'a>(tiles: impl Iterator<Item = (&'a [S], &'a [u32])>) -> Self {
        let mut batch = Self { tiles: Vec::new(), near: Vec::new(), surfaces: Vec::new() };
        for (surfaces, near) in tiles.filter(|(surfaces, _)| !surfaces.is_empty()) {
            let firsts = [batch.surfaces.len() as u32, batch.near.len() as u32];
            batch.tiles.push([firsts[0], surfaces.len() as u32, firsts[1], near.len() as u32]);
            batch.surfaces.extend(surfaces);
            batch.near.extend(near);
        }
        batch
    }

    /// The first record of every run, until all tiles have had theirs.
    fn runs(&self, device: &crate::gpu::Device) -> Result<Vec<Buffer>, GpuError> {
        let most = self.tiles.iter().map(|tile| tile[3]).max().unwrap_or(0);
        (0..most).step_by(RUN as usize).map(|first| device.upload("the first record of a run", &[first])).collect()
    }

    fn groups(&self) -> [u32; 3] {
        groups(self.tiles.len(), self.tiles.iter().map(|tile| tile[1]).max().unwrap_or(0))
    }

    /// Tiles, records, surfaces, and room for sums of this type.
    fn buffers<Sums>(&self, device: &crate::gpu::Device) -> Result<[Buffer; 4], GpuError> {
        Ok([
            device.upload("the tiles", &self.tiles)?,
            device.upload("the records of tiles", &self.near)?,
            device.upload("the surfaces of tiles", &self.surfaces)?,
            device.room("the sums of surfaces", (self.surfaces.len() * size_of::<Sums>()) as u64)?,
        ])
    }
}
