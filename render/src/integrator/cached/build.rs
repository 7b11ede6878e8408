//! Filling the caches of a picture (eas-2015, Algorithm 1, first stage).

use super::caches::Caches;
use super::incident::IncidentTracer;
use super::points::{Point, pixel_point};
use super::policy::{Policy, Treatment};
use super::settings::Quality;
use super::views::RIM_VIEWS;
use crate::cache::{Cache, Filler, Grid, Progress, RadiusPolicy, clamp_to_neighbours};
use crate::camera::RayGenerator;
use crate::frame::Frame;
use crate::hemisphere::{
    Cell, GatherSample, Guide, Incident, View, gather_cells, gather_cells_uniform, gather_uniform,
    hemisphere_directions,
};
use crate::record::eas::{EasRecord, Estimator};
use crate::record::irradiance::{IrradianceRecord, Strata};
use crate::record::{Centroid, Record, Reflector, Tree, cut};
use crate::sampler::Sampler;
use crate::scene::{Environment, Rgb};
use crate::simd::widest;
use crate::world::{Counts, Queries, World};
use fearless_simd::Level;
use glam::Vec3A;
use rayon::prelude::*;
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

/// Weight that counts as covered: less, and the zones would not overlap.
pub(super) const COVERED: f32 = 0.2;

/// What making records needs.
pub struct Builder<'a> {
    pub(super) world: &'a World,
    pub(super) policy: &'a Policy,
    pub(super) environment: Option<&'a Environment>,
    pub(super) quality: Quality,
    pub(super) seed: u64,
    /// What the middle of every pixel shows.
    pub(super) points: Vec<Option<Point>>,
    pub(super) grid: Grid,
    pub(super) counts: Mutex<Counts>,
    /// Points of the rim of the lens.
    pub(super) rim: Vec<Vec3A>,
}

impl<'a> Builder<'a> {
    /// Looks through the camera. Records will hold `environment` besides what is reflected.
    pub fn new(
        world: &'a World,
        policy: &'a Policy,
        environment: Option<&'a Environment>,
        quality: Quality,
        seed: u64,
    ) -> Self {
        let generator = RayGenerator::new(&world.scene.camera);
        let window = world.scene.camera.film.window();
        let max = world.scene.integrator.max_depth.min(MAX_CHAIN);
        let pixel = |i: u32| (window.x + i % window.width, window.y + i / window.width);
        let points = (0..window.width * window.height)
            .into_par_iter()
            .map(|i| pixel_point(world, &generator, pixel(i), seed, max))
            .collect();
        let grid = Grid { width: window.width, height: window.height };
        let rim = generator.rim(RIM_VIEWS).collect();
        Self { world, policy, environment, quality, seed, points, grid, counts: Mutex::default(), rim }
    }

    /// Fills all caches, beginning with those of an earlier run, until the deadline; `progress` is told the share of the work done.
    pub fn build(&self, kept: Option<Caches>, deadline: Option<Instant>, progress: &(dyn Fn(f64) + Sync)) -> Caches {
        let (min, max) = self.world.bounds();
        let depth = self.world.scene.integrator.max_depth;
        let mut caches = kept.unwrap_or_else(|| Caches::new(min, max));
        self.fill_coarse(&mut caches.coarse, deadline, &|x| progress(0.1 * x));
        if depth > 2 || (depth == 2 && self.environment.is_some()) {
            let short = self.tracer(Some(&caches.coarse), self.environment, depth - 1);
            let quality = (self.quality.irradiance_rays, self.quality.irradiance);
            let diffuse = |p: &Point| self.treatment(p) == Treatment::Irradiance;
            let progress_here = |x: f64| progress(0.1 + 0.3 * x);
            self.fill_irradiance(&mut caches.irradiance, &short, quality, 2, diffuse, deadline, &progress_here);
            // A policy has one kind of glossy records: the other fill finds nothing to do.
            self.fill_eas(&mut caches.eas, &short, deadline, &|x| progress(0.4 + 0.6 * x));
            self.fill_harmonics(&mut caches.harmonics, &short, deadline, &|x| progress(0.4 + 0.6 * x));
        }
        caches.counts = self.counts();
        caches
    }

    /// Fills the cache that ends the paths of the gather; it stays empty where no path is that long.
    pub(super) fn fill_coarse(
        &self,
        cache: &mut Cache<IrradianceRecord>,
        deadline: Option<Instant>,
        progress: &(dyn Fn(f64) + Sync),
    ) {
        let depth = self.world.scene.integrator.max_depth;
        if depth > 3 {
            let full = self.tracer(None, None, depth - 2);
            let quality = (self.quality.coarse_rays, self.quality.coarse);
            let any = |p: &Point| self.treatment(p) != Treatment::Traced;
            self.fill_irradiance(cache, &full, quality, 1, any, deadline, progress);
        }
    }

    pub(super) fn tracer<'c>(
        &self,
        irradiance: Option<&'c Cache<IrradianceRecord>>,
        environment: Option<&'c Environment>,
        max_segments: u32,
    ) -> IncidentTracer<'c>
    where
        'a: 'c,
    {
        let rr_depth = self.world.scene.integrator.rr_depth;
        IncidentTracer { world: self.world, irradiance, environment, max_segments, rr_depth }
    }

    pub(super) fn treatment(&self, point: &Point) -> Treatment {
        self.policy.treatment(point.material.0)
    }

    pub(super) fn filler<'p>(&self, deadline: Option<Instant>, progress: Progress<'p>) -> Filler<'p> {
        Filler { grid: self.grid, deadline, progress }
    }

    /// What was traced so far.
    fn counts(&self) -> Counts {
        *self.counts.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Adds what a record took, and drops it where a number in it is not finite.
    pub(super) fn counted<R: Record>(&self, record: R, mut counts: Counts) -> Option<R> {
        let finite = record.is_finite();
        counts.not_finite += u64::from(!finite);
        *self.counts.lock().unwrap_or_else(PoisonError::into_inner) += counts;
        finite.then_some(record)
    }

    #[allow(clippy::too_many_arguments)]
    fn fill_irradiance(
        &self,
        cache: &mut Cache<IrradianceRecord>,
        tracer: &IncidentTracer,
        (rays, radius): (u32, RadiusPolicy),
        salt: u64,
        wanted: impl Fn(&Point) -> bool + Sync,
        deadline: Option<Instant>,
        progress: &(dyn Fn(f64) + Sync),
    ) {
        let weight = crate::cache::Weight::Smooth;
        let covered = |cache: &Cache<IrradianceRecord>, i: usize| {
            self.points[i].as_ref().is_none_or(|p| {
                let normal = p.hemisphere_normal();
                !wanted(p) || best_weight(cache, p.at.p, normal, weight) > COVERED
            })
        };
        let make = |_: &Cache<IrradianceRecord>, i: usize| {
            let point = self.points[i].as_ref()?;
            let frame = Frame::from_normal(point.hemisphere_normal());
            let mut gather = Gather::new(tracer, point, self.seed, salt, i as u32);
            let found = gather.irradiance(&frame, Strata::about(rays));
            let mut record = found.record;
            record.set_radius(self.irradiance_radius(&found, radius, point.footprint));
            record.limit_gradient(found.harmonic_mean.max(record.radius()));
            self.counted(record, gather.counts).map(|record| (record, radius.min_pixels * point.footprint))
        };
        let adapt = |cache: &Cache<IrradianceRecord>, i: usize| {
            let unwanted = self.points[i].as_ref().is_none_or(|p| !wanted(p));
            if unwanted { Vec::new() } else { self.irradiance_disagreeing(cache, i, radius) }
        };
        self.filler(deadline, progress).fill(cache, adapt, covered, make, insert_clamped);
    }

    fn fill_eas(
        &self,
        cache: &mut Cache<EasRecord>,
        tracer: &IncidentTracer,
        deadline: Option<Instant>,
        progress: &(dyn Fn(f64) + Sync),
    ) {
        let quality = &self.quality;
        let covered = |cache: &Cache<EasRecord>, i: usize| {
            self.points[i].as_ref().is_none_or(|p| {
                let Treatment::Eas { .. } = self.treatment(p) else { return true };
                let mut best = 0f32;
                cache.interpolate(p.at.p, p.hemisphere_normal(), quality.weight, |r, w| {
                    if r.material == p.material.0 {
                        best = best.max(w);
                    }
                });
                // Ward's weight is 1 where the zone ends.
                best > if quality.weight == crate::cache::Weight::Ward { 0.0 } else { COVERED }
            })
        };
        let make = |_: &Cache<EasRecord>, i: usize| {
            let point = self.points[i].as_ref()?;
            let (record, _, counts) = self.eas_record(tracer, point, i)?;
            self.counted(record, counts).map(|record| (record, quality.eas.min_pixels * point.footprint))
        };
        let adapt = |cache: &Cache<EasRecord>, i: usize| self.eas_disagreeing(cache, i);
        self.filler(deadline, progress).fill(cache, adapt, covered, make, insert_clamped);
    }

    /// The record of what pixel `i` shows, its tree's samples, and what they took.
    pub(super) fn eas_record(
        &self,
        tracer: &IncidentTracer,
        point: &Point,
        i: usize,
    ) -> Option<(EasRecord, Vec<GatherSample>, Counts)> {
        let Treatment::Eas { lobe, .. } = self.treatment(point) else { return None };
        let lobe = &self.policy.lobes[lobe];
        let quality = &self.quality;
        let frame = record_frame(point);
        let parts = self.world.bsdf(&point.at).parts()?;
        let reflector = Reflector::of(&lobe.table, &parts);
        let mut gather = Gather::new(tracer, point, self.seed, 3, i as u32);
        let mut reach = quality.eas.max_pixels;
        let (mut samples, tree, directions) = match quality.estimator {
            Estimator::Paper => {
                let mut samples = gather.uniform(&frame, quality.paper_rays);
                let tree = Tree::new(&mut samples, 1, Centroid::Position);
                (samples, tree, hemisphere_directions(quality.directions))
            }
            Estimator::Improved => {
                let (views, pixels) = self.views(point, i, lobe.width);
                reach = pixels;
                let cells = self.guided_cells(&frame, &views, lobe.width);
                let most = cells.iter().map(|c| c.1).max().unwrap_or(1);
                let mut samples = gather.cells(&frame, &cells);
                let tree = Tree::new(&mut samples, most as usize, Centroid::Direction);
                let local = |v: &View| frame.to_local(v.wo);
                (samples, tree, views.iter().map(local).filter(|d| d.z > 0.02).collect())
            }
        };
        let cut = cut(&tree, &reflector, &directions, &quality.cut);
        let nearest = samples.iter().map(|s| s.inv_distance).fold(0.0, f32::max);
        let mut record = EasRecord::new(point.at.p, &frame, point.material.0, &tree, &cut, quality.estimator);
        let policy = RadiusPolicy { max_pixels: reach, ..quality.eas };
        record.set_radius(self.eas_radius(&record, point, 1.0 / nearest, policy));
        samples.shrink_to_fit();
        Some((record, samples, gather.counts))
    }

    /// The hemisphere divided for the views that will read a record, with the rays of each cell.
    pub(super) fn guided_cells(&self, frame: &Frame, views: &[View], lobe_width: f32) -> Vec<(Cell, u32)> {
        let quality = &self.quality;
        let cells = Guide::new(frame, views, lobe_width, quality.fineness).cells(quality.max_cells);
        let smallest = cells.iter().map(Cell::solid_angle).fold(f32::INFINITY, f32::min);
        let per_cell = |c: &Cell| {
            let larger = (c.solid_angle() / smallest).sqrt().clamp(1.0, 4.0);
            (quality.rays_per_cell as f32 * larger).round() as u32
        };
        cells.into_iter().map(|c| (c, per_cell(&c))).collect()
    }
}

/// Adds a record whose radius its neighbours may bound.
pub(super) fn insert_clamped<R: Record>(cache: &mut Cache<R>, (mut record, smallest): (R, f32)) {
    let radius = clamp_to_neighbours(cache, record.position(), record.radius(), smallest);
    record.set_radius(radius);
    cache.insert(record);
}

/// Frame of the hemisphere of a record: that of the surface, but for a normal that a texture bent.
pub(super) fn record_frame(point: &Point) -> Frame {
    let normal = point.hemisphere_normal();
    if normal.dot(point.frame.normal()) > 0.9999 { point.frame } else { Frame::from_normal(normal) }
}

/// Largest weight of a record at a point.
fn best_weight<R: Record>(cache: &Cache<R>, position: Vec3A, normal: Vec3A, weight: crate::cache::Weight) -> f32 {
    let mut best = 0f32;
    cache.interpolate(position, normal, weight, |_, w| best = best.max(w));
    best
}

/// Mirrors in a row that are looked through for records.
const MAX_CHAIN: u32 = 16;

/// Gathers at one point: every sample has its own sample points, all are well distributed together.
pub(super) struct Gather<'a> {
    tracer: &'a IncidentTracer<'a>,
    point: &'a Point,
    seed: u64,
    key: (u32, u32),
    pub(super) counts: Counts,
}

impl<'a> Gather<'a> {
    pub(super) fn new(tracer: &'a IncidentTracer<'a>, point: &'a Point, seed: u64, salt: u64, pixel: u32) -> Self {
        let seed = seed.wrapping_add(salt.wrapping_mul(0x9e37_79b9_7f4a_7c15));
        Self { tracer, point, seed, key: (pixel, salt as u32), counts: Counts::default() }
    }

    /// The two closures of a gather: the place of a sample in its stratum, and the light it meets.
    fn run<T>(
        &mut self,
        with: impl FnOnce(&mut dyn FnMut(u32) -> glam::Vec2, &mut dyn FnMut(Vec3A, u32) -> Incident) -> T,
    ) -> T {
        let (seed, key, tracer, at) = (self.seed, self.key, self.tracer, &self.point.at);
        let facing = at.normal * 1f32.copysign(at.normal.dot(at.wo));
        let mut queries = Queries::default();
        let level = Level::new();
        let out = with(&mut |number| Sampler::new(seed, key, number).next_2d(), &mut |direction, number| {
            // Below the surface of a smoothed mesh there is nothing to see.
            if direction.dot(facing) <= 0.0 {
                return Incident { radiance: Rgb::ZERO, distance: f32::INFINITY, normal: Vec3A::ZERO };
            }
            let mut sampler = Sampler::new(seed, key, number);
            // The first point is the place in the stratum.
            sampler.next_2d();
            widest(
                level,
                #[inline(always)]
                || tracer.incident(at.spawn(direction), &mut sampler, &mut queries),
            )
        });
        self.counts += queries.counts;
        out
    }

    fn irradiance(&mut self, frame: &Frame, strata: Strata) -> crate::record::irradiance::Gathered {
        let position = self.point.at.p;
        self.run(|point, incident| IrradianceRecord::gather(position, frame, strata, point, incident))
    }

    pub(super) fn uniform(&mut self, frame: &Frame, count: u32) -> Vec<GatherSample> {
        self.run(|point, incident| gather_uniform(frame, count, point, incident))
    }

    fn cells(&mut self, frame: &Frame, cells: &[(Cell, u32)]) -> Vec<GatherSample> {
        self.run(|point, incident| gather_cells(frame, cells, point, incident))
    }

    pub(super) fn cells_uniform(&mut self, frame: &Frame, cells: &[(Cell, u32)]) -> Vec<GatherSample> {
        self.run(|point, incident| gather_cells_uniform(frame, cells, point, incident))
    }
}
