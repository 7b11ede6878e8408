//! Filling the caches of a picture (eas-2015, Algorithm 1, first stage).

use super::caches::Caches;
use super::gradual::Courses;
use super::incident::IncidentTracer;
use super::irradiance::COVERED;
use super::kinds::{self, EachKind, Listed, Scratches};
use super::points::{Point, Sight};
use super::policy::{Policy, Treatment};
use super::settings::Quality;
use super::site::Site;
use super::views::{Pixels, RIM_VIEWS};
use crate::cache::{
    BATCH, Cache, Course, Density, Filler, Grid, Progress, RadiusPolicy, Shrink, Weight, disagreeing, insert_clamped,
};
use crate::camera::RayGenerator;
use crate::record::irradiance::IrradianceRecord;
use crate::record::{Receiver, Record};
use crate::scene::{Camera, Environment, Rgb};
use crate::world::{Counts, World};
use core::convert::Infallible;
use glam::Vec3A;
use rayon::prelude::*;
use std::cell::RefCell;
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

/// Shares of the progress: coarse irradiance, irradiance, glossy records.
const COARSE_SHARE: f64 = 0.1;
const DIFFUSE_SHARE: f64 = 0.3;
const GLOSSY_SHARE: f64 = 0.6;

/// Mirrors in a row that are looked through for records.
const MAX_CHAIN: u32 = 16;

thread_local! {
    static SCRATCHES: RefCell<Scratches> = RefCell::default();
}

/// What making records needs.
pub struct Builder<'a> {
    pub(super) world: &'a World,
    pub(super) policy: &'a Policy,
    pub(super) environment: Option<&'a Environment>,
    pub(super) quality: Quality,
    pub(super) seed: u64,
    /// What the middle of every pixel shows.
    pub(super) sight: Sight<'a>,
    pub(super) grid: Grid,
    /// Which pixels are looked at.
    density: Density,
    /// Whether records are filed anew at the end of a fill.
    refile: bool,
    /// Records that are made at once.
    batch: usize,
    counts: Mutex<Counts>,
    /// Points of the rim of the lens.
    pub(super) rim: Vec<Vec3A>,
}

impl<'a> Builder<'a> {
    /// Looks through a camera, which may have fewer pixels than that of the picture. Records will hold `environment` besides what is
    /// reflected.
    pub fn new(
        world: &'a World,
        camera: &Camera,
        policy: &'a Policy,
        environment: Option<&'a Environment>,
        quality: Quality,
        seed: u64,
    ) -> Self {
        let generator = RayGenerator::new(camera);
        let window = camera.film.window();
        let max = world.scene.integrator.max_depth.min(MAX_CHAIN);
        let sight = Sight::new(world, camera, policy, seed, max);
        let grid = Grid { width: window.width, height: window.height };
        let rim = generator.rim(RIM_VIEWS).collect();
        let (density, refile, batch, counts) = (Density::Every, true, BATCH, Mutex::default());
        Self { world, policy, environment, quality, seed, sight, grid, density, refile, batch, counts, rim }
    }

    /// The same, which looks at fewer pixels and files no record anew: of many frames that are filled one after the other,
    /// the last must.
    ///
    /// Glossy records then know which views they were made for, and others get their own.
    pub(super) fn scouting(self, density: Density) -> Self {
        Self { density, refile: false, ..self }
    }

    /// The same, which looks at the clock after so many records: they are the same.
    pub(super) fn in_batches(self, batch: usize) -> Self {
        Self { batch, ..self }
    }

    /// Fills all caches, beginning with those of an earlier run, until the deadline; `progress` is told the share of the work done.
    pub fn build(&self, kept: Option<Caches>, deadline: Option<Instant>, progress: &(dyn Fn(f64) + Sync)) -> Caches {
        let (min, max) = self.world.bounds();
        let mut caches = kept.unwrap_or_else(|| Caches::new(min, max));
        let mut courses = self.courses();
        self.go_on(&mut courses, &mut caches, deadline, progress);
        if self.refile && !courses.are_done() {
            caches.refile();
        }
        caches
    }

    /// The way that a fill has before it.
    pub(super) fn courses(&self) -> Courses {
        Courses::new(self.grid, self.density)
    }

    /// Goes on with a fill until the deadline.
    pub(super) fn go_on(
        &self,
        courses: &mut Courses,
        caches: &mut Caches,
        deadline: Option<Instant>,
        progress: &(dyn Fn(f64) + Sync),
    ) {
        let Caches { coarse, irradiance, glossy, .. } = caches;
        self.fill_coarse(coarse, &mut courses.coarse, deadline, &|x| progress(COARSE_SHARE * x));
        if self.holds_light() && courses.coarse.is_done() {
            let tracer = self.record_tracer(coarse);
            let progressed = |x: f64| progress(COARSE_SHARE + DIFFUSE_SHARE * x);
            self.fill_diffuse(irradiance, &mut courses.diffuse, &tracer, deadline, &progressed);
            let before = COARSE_SHARE + DIFFUSE_SHARE;
            let progress: Progress = &|x| progress(before + GLOSSY_SHARE * x);
            let courses = courses.glossy.iter_mut();
            let Ok(()) = kinds::each(&mut FillEach {
                builder: self,
                caches: glossy,
                courses,
                tracer: &tracer,
                deadline,
                progress,
            });
        } else if !self.holds_light() {
            courses.end();
        }
        caches.counts = *self.counts.lock().unwrap_or_else(PoisonError::into_inner);
    }

    /// Whether paths are long enough for any light in records.
    pub(super) fn holds_light(&self) -> bool {
        let depth = self.world.scene.integrator.max_depth;
        depth > 2 || (depth == 2 && self.environment.is_some())
    }

    /// Follows the paths of records, which coarse irradiance ends.
    pub(super) fn record_tracer<'c>(&self, coarse: &'c Cache<IrradianceRecord>) -> IncidentTracer<'c>
    where
        'a: 'c,
    {
        self.tracer(Some(coarse), self.environment, self.world.scene.integrator.max_depth - 1)
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

    /// The place of a record, for what the middle of a pixel shows.
    pub(super) fn site<'s>(&'s self, tracer: &'s IncidentTracer<'s>, point: &'s Point, pixel: usize) -> Site<'s> {
        let pixels = Pixels { sight: &self.sight, grid: self.grid, rim: &self.rim };
        Site {
            world: self.world,
            quality: &self.quality,
            seed: self.seed,
            is_one_of_many: !self.refile,
            pixels,
            tracer,
            point,
            pixel,
        }
    }

    pub(super) fn treatment(&self, point: &Point) -> Treatment {
        self.policy.treatment(point.finish)
    }

    pub(super) fn filler<'p>(&self, deadline: Option<Instant>, progress: Progress<'p>) -> Filler<'p> {
        let Self { grid, density, refile, batch, .. } = *self;
        Filler { grid, density, refile, batch, deadline, progress }
    }

    /// Adds what a record took, and drops it where a number in it is not finite.
    pub(super) fn counted<R: Record>(&self, record: R, mut counts: Counts) -> Option<R> {
        let finite = record.is_finite();
        counts.not_finite += u64::from(!finite);
        *self.counts.lock().unwrap_or_else(PoisonError::into_inner) += counts;
        finite.then_some(record)
    }

    /// Records that disagree about pixel `i`; `value` is what one says of it.
    pub(super) fn disagreeing<R: Record>(
        &self,
        cache: &Cache<R>,
        i: usize,
        (weight, policy): (Weight, RadiusPolicy),
        value: impl Fn(&Point, &R) -> Option<Rgb>,
    ) -> Vec<Shrink> {
        let (Some(fraction), Some(point)) = (self.quality.spacing.adaptive, self.sight.at(i)) else {
            return Vec::new();
        };
        let smallest = policy.min_pixels * point.footprint;
        let at = (point.at.p, point.hemisphere_normal());
        disagreeing(cache, at, weight, (fraction, smallest), |record| value(point, record))
    }

    /// How a point is held, if by this kind.
    fn held<K: Listed>(&self, point: &Point) -> Option<K::Held> {
        held_by::<K>(self.treatment(point))
    }

    /// Whether pixel `i` needs no record of a kind besides those that reach it.
    fn has_glossy<K: Listed>(&self, cache: &Cache<K::Record>, i: usize) -> bool {
        let kind = K::of(&self.policy.kinds);
        self.sight.at(i).is_none_or(|p| {
            let Some(held) = self.held::<K>(p) else { return true };
            let mirror = p.view().mirror();
            let trust = |record: &K::Record| kind.trust(held, record, mirror);
            !kind.serves(held, p.frame.to_local(p.at.wo)) || is_covered(cache, p, self.quality.weight, trust)
        })
    }

    /// Median width of a pixel where a lattice of pixels sees a surface; infinite where none does.
    pub(super) fn median_footprint(&self) -> f32 {
        const LATTICE: u32 = 16;
        let Grid { width, height } = self.grid;
        let middle = |i: u32, of: u32| (2 * i + 1) * of / (2 * LATTICE);
        let pixel = |i: u32| middle(i / LATTICE, height) * width + middle(i % LATTICE, width);
        let footprint = |i: u32| self.sight.at(pixel(i) as usize).map(|point| point.footprint);
        let mut all: Vec<f32> = (0..LATTICE * LATTICE).filter_map(footprint).collect();
        all.sort_by(f32::total_cmp);
        all.get(all.len() / 2).copied().unwrap_or(f32::INFINITY)
    }

    /// Number of pixels whose records do not reach them.
    pub(super) fn holes(&self, caches: &Caches) -> usize {
        let pixels = self.grid.width as usize * self.grid.height as usize;
        let mut each = HolesEach { builder: self, caches: &caches.glossy, holes: vec![false; pixels] };
        let diffuse = |(i, hole): (usize, &mut bool)| *hole = !self.has_irradiance(&caches.irradiance, i);
        each.holes.par_iter_mut().enumerate().for_each(diffuse);
        let Ok(()) = kinds::each(&mut each);
        each.holes.into_iter().filter(|hole| *hole).count()
    }

    /// Fills the cache of a kind.
    fn fill<K: Listed>(
        &self,
        (cache, course): (&mut Cache<K::Record>, &mut Course),
        tracer: &IncidentTracer,
        deadline: Option<Instant>,
        progress: Progress,
    ) {
        let (kind, quality) = (K::of(&self.policy.kinds), &self.quality);
        let covered = |cache: &Cache<K::Record>, i: usize| self.has_glossy::<K>(cache, i);
        let make = |_: &Cache<K::Record>, pixel: usize| {
            let point = self.sight.at(pixel)?;
            let held = held_by::<K>(self.policy.maker(point.finish))?;
            let (record, counts) = kind.make(held, &self.site(tracer, point, pixel))?;
            self.counted(record, counts).map(|record| (record, quality.glossy.min_pixels * point.footprint))
        };
        let light = |point: &Point, record: &K::Record| {
            let held = self.held::<K>(point).filter(|_| point.finish.reads(record.zone().material))?;
            let parts = point.bsdf(self.world).parts()?;
            let at = Receiver { position: point.at.p, frame: point.frame, wo: point.frame.to_local(point.at.wo) };
            Some(SCRATCHES.with_borrow_mut(|all| kind.light(held, record, &parts, &at, quality, K::scratch(all))))
        };
        let adapt =
            |cache: &Cache<K::Record>, i: usize| self.disagreeing(cache, i, (quality.weight, quality.glossy), light);
        self.filler(deadline, progress).fill(course, cache, adapt, covered, make, insert_clamped);
    }
}

/// Pixels that no record of any kind reaches.
struct HolesEach<'a> {
    builder: &'a Builder<'a>,
    caches: &'a kinds::GlossyCaches,
    holes: Vec<bool>,
}

impl EachKind for HolesEach<'_> {
    type Error = Infallible;

    fn run<K: Listed>(&mut self) -> Result<(), Infallible> {
        let cache = K::cache(self.caches);
        let Self { builder, holes, .. } = self;
        holes.par_iter_mut().enumerate().for_each(|(i, hole)| *hole |= !builder.has_glossy::<K>(cache, i));
        Ok(())
    }
}

/// Fills the caches of the kinds that hold any material, one after the other.
struct FillEach<'a> {
    builder: &'a Builder<'a>,
    caches: &'a mut kinds::GlossyCaches,
    /// Of the kinds that are left.
    courses: core::slice::IterMut<'a, Course>,
    tracer: &'a IncidentTracer<'a>,
    deadline: Option<Instant>,
    progress: Progress<'a>,
}

impl EachKind for FillEach<'_> {
    type Error = Infallible;

    fn run<K: Listed>(&mut self) -> Result<(), Infallible> {
        let Some(course) = self.courses.next() else { return Ok(()) };
        if self.builder.policy.treatments().iter().any(|treatment| held_by::<K>(*treatment).is_some()) {
            let place = (K::cache_mut(self.caches), course);
            self.builder.fill::<K>(place, self.tracer, self.deadline, self.progress);
        } else {
            course.end();
        }
        Ok(())
    }
}

/// How a surface that is treated so is held, if by this kind.
fn held_by<K: Listed>(treatment: Treatment) -> Option<K::Held> {
    match treatment {
        Treatment::Glossy(glossy) => K::held(glossy),
        Treatment::Irradiance | Treatment::Traced => None,
    }
}

/// Whether records that serve a point reach it with enough weight and trust.
fn is_covered<R: Record>(cache: &Cache<R>, p: &Point, weight: Weight, trust: impl Fn(&R) -> f32) -> bool {
    let mut best = 0f32;
    cache.interpolate(p.at.p, p.hemisphere_normal(), weight, |r, w| {
        if p.finish.reads(r.zone().material) {
            best = best.max(w * trust(r));
        }
    });
    // Ward's weight is 1 where the zone ends.
    best > if weight == Weight::Ward { 0.0 } else { COVERED }
}
