//! Irradiance records in a picture: on diffuse surfaces, and coarse ones on all, which end the paths of the gathers.

use super::build::Builder;
use super::incident::IncidentTracer;
use super::points::Point;
use super::policy::Treatment;
use crate::cache::{Cache, Course, RadiusPolicy, Weight, insert_clamped};
use crate::color::luminance;
use crate::frame::Frame;
use crate::record::Record;
use crate::record::irradiance::{Gathered, IrradianceRecord, Strata};
use std::time::Instant;

/// Tells the sample points of records from those of other kinds.
const COARSE_SALT: u64 = 1;
const SALT: u64 = 2;

/// Weight that counts as covered: less, and the zones would not overlap.
pub(super) const COVERED: f32 = 0.2;

/// Gradients are not believed to change the light within this share of the mean distance: noise must not pass for change.
const LEAST_CHANGE: f32 = 0.25;

/// Records follow the change of light up to this many times the distance over which it changes by all there is.
const CHANGES: f32 = 2.0;

/// Which irradiance records.
struct Wanted<F> {
    rays: u32,
    radius: RadiusPolicy,
    salt: u64,
    at: F,
}

impl Builder<'_> {
    /// Fills the cache that ends the paths of the gather; it stays empty where no path is that long.
    pub(super) fn fill_coarse(
        &self,
        cache: &mut Cache<IrradianceRecord>,
        course: &mut Course,
        deadline: Option<Instant>,
        progress: &(dyn Fn(f64) + Sync),
    ) {
        let depth = self.world.scene.integrator.max_depth;
        if depth > 3 {
            let full = self.tracer(None, None, depth - 2);
            let (rays, radius) = (self.quality.coarse_rays, self.quality.coarse);
            let at = |p: &Point| self.treatment(p) != Treatment::Traced;
            let wanted = Wanted { rays, radius, salt: COARSE_SALT, at };
            self.fill_irradiance((cache, course), &full, &wanted, deadline, progress);
        } else {
            course.end();
        }
    }

    /// Fills the cache of diffuse surfaces.
    pub(super) fn fill_diffuse(
        &self,
        cache: &mut Cache<IrradianceRecord>,
        course: &mut Course,
        tracer: &IncidentTracer,
        deadline: Option<Instant>,
        progress: &(dyn Fn(f64) + Sync),
    ) {
        let (rays, radius) = (self.quality.irradiance_rays, self.quality.irradiance);
        let at = |p: &Point| self.treatment(p) == Treatment::Irradiance;
        let wanted = Wanted { rays, radius, salt: SALT, at };
        self.fill_irradiance((cache, course), tracer, &wanted, deadline, progress);
    }

    fn fill_irradiance(
        &self,
        (cache, course): (&mut Cache<IrradianceRecord>, &mut Course),
        tracer: &IncidentTracer,
        wanted: &Wanted<impl Fn(&Point) -> bool + Sync>,
        deadline: Option<Instant>,
        progress: &(dyn Fn(f64) + Sync),
    ) {
        let covered = |cache: &Cache<IrradianceRecord>, i: usize| self.reaches(cache, i, &wanted.at);
        let make = |_: &Cache<IrradianceRecord>, pixel: usize| {
            let point = self.sight.at(pixel)?;
            let frame = Frame::from_normal(point.hemisphere_normal());
            let mut gather = self.site(tracer, point, pixel).gather(wanted.salt);
            let found = gather.irradiance(&frame, Strata::about(wanted.rays));
            let mut record = found.record;
            record.set_radius(self.irradiance_radius(&found, wanted.radius, point.footprint));
            record.limit_gradient(found.harmonic_mean.max(record.radius()));
            self.counted(record, gather.counts).map(|record| (record, wanted.radius.min_pixels * point.footprint))
        };
        let adapt = |cache: &Cache<IrradianceRecord>, i: usize| {
            let unwanted = self.sight.at(i).is_none_or(|p| !(wanted.at)(p));
            let light = |p: &Point, r: &IrradianceRecord| Some(r.at(p.at.p, p.hemisphere_normal()));
            if unwanted { Vec::new() } else { self.disagreeing(cache, i, (Weight::Smooth, wanted.radius), light) }
        };
        self.filler(deadline, progress).fill(course, cache, adapt, covered, make, insert_clamped);
    }

    /// Whether a diffuse surface in pixel `i` needs no record besides those that reach it.
    pub(super) fn has_irradiance(&self, cache: &Cache<IrradianceRecord>, i: usize) -> bool {
        self.reaches(cache, i, |p: &Point| self.treatment(p) == Treatment::Irradiance)
    }

    fn reaches(&self, cache: &Cache<IrradianceRecord>, i: usize, wanted: impl Fn(&Point) -> bool) -> bool {
        self.sight.at(i).is_none_or(|p| {
            let mut best = 0f32;
            let best_weight = |_: &IrradianceRecord, w: f32| best = best.max(w);
            !wanted(p) || {
                cache.interpolate(p.at.p, p.hemisphere_normal(), Weight::Smooth, best_weight);
                best > COVERED
            }
        })
    }

    /// Radius of a record.
    fn irradiance_radius(&self, found: &Gathered, policy: RadiusPolicy, footprint: f32) -> f32 {
        if self.quality.spacing.hessian {
            let light = luminance(found.record.irradiance);
            // What is near may be occluded from a little farther, which second derivatives do not know.
            let by_distance = policy.radius(found.harmonic_mean, footprint);
            return policy.bounded(found.hessian.radius(light, self.quality.curvature).min(by_distance), footprint);
        }
        // Where light changes fast, records are dense.
        let limit = found.record.gradient_limit().max(LEAST_CHANGE * found.harmonic_mean);
        policy.radius(found.harmonic_mean.min(CHANGES * limit), footprint)
    }
}
