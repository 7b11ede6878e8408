//! The surfaces of a picture on the card, some bands of tiles at a time.

use super::batch::{Batch, Part};
use super::programs::Programs;
use super::{eas, harmonics, irradiance};
use crate::cache::Near;
use crate::gpu::GpuError;
use crate::integrator::cached::kind::Found;
use crate::integrator::cached::kinds::eas::Held;
use crate::integrator::cached::kinds::harmonics::Held as Mapped;
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
    harmonics: harmonics::Records,
}

/// The surfaces of a tile of pixels, in the order of the pixels.
#[derive(Default)]
struct TileWork<'a> {
    /// What is known, and what the card is to find.
    slots: Vec<Slot<'a>>,
    irradiance: Part<irradiance::SurfaceRows>,
    eas: Part<eas::SurfaceRows>,
    harmonics: Part<harmonics::SurfaceRows>,
}

/// A surface.
enum Slot<'a> {
    Known(Found),
    Irradiance(&'a Surface),
    Eas(&'a Surface, Held),
    Harmonics(&'a Surface, Mapped),
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
        let harmonics = harmonics::Records::new(programs.device, &caches.glossy.harmonics, &kinds.harmonics)?;
        Ok(Self { shader, programs, irradiance, eas, harmonics })
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
            work.slots.push(match shader.policy.treatment(s.finish()) {
                Treatment::Irradiance => {
                    work.irradiance.surfaces.push(irradiance::surface(s));
                    Slot::Irradiance(s)
                }
                Treatment::Glossy(Glossy::Eas(held)) if self.eas.has(held) => {
                    work.eas.surfaces.push(eas::surface(&kinds.eas, held, &Shader::shaded(s, &s.parts)));
                    Slot::Eas(s, held)
                }
                Treatment::Glossy(Glossy::Harmonics(held)) => {
                    let shaded = Shader::shaded(s, &s.parts);
                    work.harmonics.surfaces.push(self.harmonics.surface(&kinds.harmonics, held, &shaded));
                    Slot::Harmonics(s, held)
                }
                Treatment::Traced => Slot::Known(Found::NOTHING),
                Treatment::Glossy(_) => Slot::Known(shader.found(s, &s.parts, scratch)),
            });
        }
        let listed = |any: bool, near: &Near| if any { near.records().to_vec() } else { Vec::new() };
        work.irradiance.near = listed(!work.irradiance.surfaces.is_empty(), &tile.irradiance);
        work.eas.near = listed(!work.eas.surfaces.is_empty(), &tile.glossy.eas);
        work.harmonics.near = listed(!work.harmonics.surfaces.is_empty(), &tile.glossy.harmonics);
        work
    }

    /// Runs the card on some tiles.
    fn run(&self, work: Vec<TileWork>) -> Result<Vec<Vec<Found>>, GpuError> {
        let Programs { device, irradiance, eas, harmonics } = self.programs;
        let batch = Batch::new(work.iter().map(|w| &w.irradiance));
        let mut diffuse = batch.sums(device, irradiance, &self.irradiance, &[])?.into_iter();
        let eas::Records { records, sources, lobes, tables, .. } = &self.eas;
        let batch = Batch::new(work.iter().map(|w| &w.eas));
        let mut glossy = batch.sums(device, eas, records, &[sources, lobes, tables])?.into_iter();
        let harmonics::Records { records, numbers, lobes, constants, .. } = &self.harmonics;
        let batch = Batch::new(work.iter().map(|w| &w.harmonics));
        let mut turned = batch.sums(device, harmonics, records, &[numbers, lobes, constants])?.into_iter();
        let kind = &self.shader.policy.kinds.harmonics;
        let mut of = |slot: &Slot| match slot {
            Slot::Known(found) => *found,
            Slot::Irradiance(s) => Shader::diffuse_found(s, &s.parts, diffuse.next().and_then(irradiance::found)),
            Slot::Eas(s, held) => glossy.next().map_or(Found::NOTHING, |rows| eas::sum(rows).found(*held, &s.parts)),
            Slot::Harmonics(s, held) => turned
                .next()
                .map_or(Found::NOTHING, |rows| harmonics::found(kind, *held, &Shader::shaded(s, &s.parts), rows)),
        };
        Ok(work.iter().map(|w| w.slots.iter().map(&mut of).collect()).collect())
    }
}
