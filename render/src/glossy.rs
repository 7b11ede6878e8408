//! The front door: the glossy cache in another renderer, which fills and reads it with closures (eas-2015, Algorithm 1). It needs
//! none of our scenes, and none of the crate's features.
//!
//! The renderer says what a pixel shows (a [`Spot`]) and what light comes along a ray ([`Incident`]); the cache puts records where
//! the picture needs them and tells the light that a spot reflects. `examples/cache_library.rs` is the whole of it.

use crate::cache::{BATCH, Cache, Course, Density, FOUND, Filler, Grid, RadiusPolicy, Spacing, insert_clamped};
use crate::color::{luminance, mean_radiance};
use crate::frame::Frame;
use crate::hemisphere::{Guide, Incident, View, gather_cells, nearest, view_directions};
use crate::integrator::cached::Quality;
use crate::record::eas::{EasRecord, Estimator};
use crate::record::{Albedo, Receiver, Record, Reflected, Reflector, Scratch, Tree, cut, reflect};
use crate::sampler::Sampler;
use crate::scene::Rgb;
use brdf_tables::table::Table;
use glam::Vec3A;
use rayon::prelude::*;

/// A point of a surface as an eye sees it.
#[derive(Clone, Copy, Debug)]
pub struct Spot {
    /// Position, world space.
    pub position: Vec3A,
    /// Local frame: z is the normal on the side of the eye, x the tangent of an anisotropic material.
    pub frame: Frame,
    /// Unit direction to the eye, world space.
    pub wo: Vec3A,
    /// Which of the tables the cache was made with.
    pub material: usize,
    /// Albedo of the Lambertian part, 0 … 1: textures are free to change it from spot to spot.
    pub diffuse: Rgb,
    /// Strength of the specular part that the table holds at unit strength.
    pub specular: Rgb,
    /// Width of a pixel at the spot, in the unit of the scene.
    pub footprint: f32,
}

/// What a spot reflects.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// Radiance towards the eye, W·m⁻²·sr⁻¹, of all the light that the gathers met.
    pub radiance: Rgb,
    /// 1 where the records tell the specular part well, falling to 0 where they say little of this spot: a renderer mixes that
    /// share with rays of its own.
    pub trust: f32,
}

/// Why there is no cache.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum GlossyError {
    /// The table of this index holds no specular part.
    #[error("table {0} is of a diffuse material")]
    Diffuse(usize),
    /// The tolerance is none.
    #[error("a tolerance of {0}, expected a number from 0.0001 to 1")]
    Tolerance(f32),
}

/// A cache of equivalent area light sources.
#[derive(Clone, Debug)]
pub struct GlossyCache {
    lobes: Vec<Lobe>,
    quality: Quality,
    records: Cache<EasRecord>,
}

#[derive(Clone, Debug)]
struct Lobe {
    table: Table,
    albedo: Albedo,
    /// Radian.
    width: f32,
}

/// Weight that counts as covered.
const COVERED: f32 = 0.2;
/// Pixels about a spot whose views a record is made for, in halves of its reach.
const NEIGHBOURS: [(i32, i32); 8] = [(-2, 0), (2, 0), (0, -2), (0, 2), (-1, -1), (1, -1), (-1, 1), (1, 1)];

impl GlossyCache {
    /// An empty cache for surfaces between two corners, the materials of these tables, and the quality τ (0.02 is that of the
    /// paper; half of it takes about four times as long to fill).
    ///
    /// # Errors
    /// A table without a specular part; a tolerance that is none.
    pub fn new((min, max): (Vec3A, Vec3A), tables: Vec<Table>, tolerance: f32) -> Result<Self, GlossyError> {
        if !(1e-4..=1.0).contains(&tolerance) {
            return Err(GlossyError::Tolerance(tolerance));
        }
        let lobe = |(i, table): (usize, Table)| {
            let width = table.specular().ok_or(GlossyError::Diffuse(i))?.lobe_width() as f32;
            Ok(Lobe { albedo: Albedo::new(&table), table, width })
        };
        let lobes = tables.into_iter().enumerate().map(lobe).collect::<Result<_, _>>()?;
        let quality = Quality::new(tolerance, Estimator::Improved, Spacing::default());
        Ok(Self { lobes, quality, records: Cache::new(min, max) })
    }

    /// Adds the records that a picture needs. `spot` tells what a pixel shows, counted row by row, `None` where nothing of these
    /// materials is. `light` tells what arrives at a spot from a unit direction of world space; it may trace whole paths, drawing
    /// their random numbers from the sampler. Both are called from many threads; the records do not depend on how many.
    pub fn fill(
        &mut self,
        grid: Grid,
        seed: u64,
        spot: impl Fn(usize) -> Option<Spot> + Sync,
        light: impl Fn(&Spot, Vec3A, &mut Sampler) -> Incident + Sync,
    ) {
        let known = |s: &Spot| s.material < self.lobes.len() && s.frame.to_local(s.wo).z > 0.0;
        let count = grid.width as usize * grid.height as usize;
        let spots: Vec<Option<Spot>> = (0..count).into_par_iter().map(|i| spot(i).filter(known)).collect();
        let mut records = self.records.clone();
        let covered = |records: &Cache<EasRecord>, i: usize| {
            spots[i].as_ref().is_none_or(|s| {
                let mut best = 0f32;
                self.about(records, s, |_, w| best = best.max(w));
                best > COVERED
            })
        };
        let make = |_: &Cache<EasRecord>, i: usize| {
            let s = spots[i].as_ref()?;
            let mut views = vec![View { normal: s.frame.normal(), wo: s.wo }];
            views.extend(self.neighbours(&spots, grid, i).map(|s| View { normal: s.frame.normal(), wo: s.wo }));
            let place = |number| Sampler::new(seed, (i as u32, 0), number).next_2d();
            let incident = |direction: Vec3A, number: u32| {
                let mut sampler = Sampler::new(seed, (i as u32, 0), number);
                // The first point is the place in the cell.
                sampler.next_2d();
                light(s, direction, &mut sampler)
            };
            Some((self.record(s, &views, place, incident), self.quality.glossy.min_pixels * s.footprint))
        };
        let density = Density::Every;
        let filler = Filler { grid, density, refile: true, batch: BATCH, deadline: None, progress: &|_| () };
        filler.fill(&mut Course::new(grid, density), &mut records, |_, _| Vec::new(), covered, make, insert_clamped);
        self.records = records;
    }

    /// What a spot reflects (eq. 17); `None` where no record reaches, or the material is none of the cache's.
    pub fn light(&self, spot: &Spot, scratch: &mut Scratch) -> Option<Light> {
        let lobe = self.lobes.get(spot.material)?;
        let at = receiver(spot, spot.position);
        let (mut sum, mut weights) = (Reflected::default(), 0.0);
        self.about(&self.records, spot, |record, w| {
            let part = lobe.reflected(record, spot, &at, scratch);
            sum.irradiance += part.irradiance * w;
            sum.specular += part.specular * (w * part.trust);
            sum.trust += w * part.trust;
            weights += w;
        });
        (at.wo.z > 0.0 && weights > FOUND).then(|| Light {
            radiance: spot.diffuse * mean_radiance(sum.irradiance.max(Rgb::ZERO) / weights)
                + sum.specular.max(Rgb::ZERO) / sum.trust.max(f32::MIN_POSITIVE),
            trust: sum.trust / weights,
        })
    }

    /// The records themselves.
    pub fn records(&self) -> &Cache<EasRecord> {
        &self.records
    }

    /// Calls `found` with the records that count at a spot, and their weights.
    fn about(&self, records: &Cache<EasRecord>, spot: &Spot, mut found: impl FnMut(&EasRecord, f32)) {
        records.interpolate(spot.position, spot.frame.normal(), self.quality.weight, |record, w| {
            if record.zone().material as usize == spot.material {
                found(record, w);
            }
        });
    }

    /// Spots of the same surface that will read the record of pixel `i`.
    fn neighbours<'s>(
        &self,
        spots: &'s [Option<Spot>],
        grid: Grid,
        i: usize,
    ) -> impl Iterator<Item = &'s Spot> + use<'s> {
        let RadiusPolicy { max_pixels, .. } = self.quality.glossy;
        let (column, row) = (i as i32 % grid.width as i32, i as i32 / grid.width as i32);
        let step = (0.5 * max_pixels).ceil() as i32;
        let inside = |x: i32, size: u32| u32::try_from(x).ok().filter(|x| *x < size);
        NEIGHBOURS.into_iter().filter_map(move |(x, y)| {
            let x = inside(column + x * step, grid.width)?;
            let y = inside(row + y * step, grid.height)?;
            let (own, other) = (spots[i].as_ref()?, spots[(y * grid.width + x) as usize].as_ref()?);
            let near = own.position.distance(other.position) <= 1.5 * max_pixels * own.footprint;
            (near && own.material == other.material).then_some(other)
        })
    }

    /// Gathers at a spot, builds the tree over the light, cuts it for the views, and keeps the cut.
    fn record(
        &self,
        spot: &Spot,
        views: &[View],
        place: impl FnMut(u32) -> glam::Vec2,
        incident: impl FnMut(Vec3A, u32) -> Incident,
    ) -> EasRecord {
        let (lobe, quality, frame) = (&self.lobes[spot.material], &self.quality, &spot.frame);
        let guide = Guide::new(frame, views, lobe.width, quality.fineness);
        let cells = guide.cells_with_rays(quality.max_cells, quality.rays_per_cell);
        let mut samples = gather_cells(frame, &cells, place, incident);
        let tree = Tree::of_cells(&mut samples, &cells);
        let cut = cut(&tree, &lobe.reflector(spot), &view_directions(frame, views), &quality.cut);
        let mut record = EasRecord::new(spot.position, frame, spot.material as u32, &tree, &cut, Estimator::Improved);
        // As far as what is near and the bending of the reflected light allow.
        let mut scratch = Scratch::default();
        let reflected = |x: f32, y: f32| {
            let position = spot.position + frame.to_world(Vec3A::new(x, y, 0.0));
            let part = lobe.reflected(&record, spot, &receiver(spot, position), &mut scratch);
            luminance(spot.diffuse * mean_radiance(part.irradiance) + part.specular)
        };
        let radius = quality.glossy.by_bending(nearest(&samples), spot.footprint, quality.curvature, reflected);
        record.set_radius(radius);
        record
    }
}

impl Lobe {
    fn reflector(&self, spot: &Spot) -> Reflector<'_> {
        Reflector::new(&self.table, spot.diffuse, spot.specular)
    }

    fn reflected(&self, record: &EasRecord, spot: &Spot, at: &Receiver, scratch: &mut Scratch) -> Reflected {
        reflect(record, at, &self.reflector(spot), &self.albedo, Estimator::Improved, scratch)
    }
}

/// The eye of a spot, looking at another position of its plane.
fn receiver(spot: &Spot, position: Vec3A) -> Receiver {
    Receiver { position, frame: spot.frame, wo: spot.frame.to_local(spot.wo) }
}
