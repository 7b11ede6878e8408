//! How far the records of a picture reach: by the distance or the curvature of what they see, and less where they disagree.

use super::build::Builder;
use super::points::Point;
use super::policy::Treatment;
use crate::cache::{Cache, RadiusPolicy, Shrink, Weight, disagreeing};
use crate::color::{luminance, mean_radiance};
use crate::record::eas::EasRecord;
use crate::record::harmonics::HarmonicsRecord;
use crate::record::irradiance::{Gathered, IrradianceRecord};
use crate::record::{Hessian, Receiver, Record, Reflector, Scratch, reflect};
use crate::scene::Rgb;
use glam::Vec3A;
use std::cell::RefCell;

thread_local! {
    static SCRATCH: RefCell<Scratch> = RefCell::default();
}

impl Builder<'_> {
    /// Radius of an irradiance record.
    pub(super) fn irradiance_radius(&self, found: &Gathered, policy: RadiusPolicy, footprint: f32) -> f32 {
        if self.quality.spacing.hessian {
            let light = luminance(found.record.irradiance);
            // What is near may be occluded from a little farther, which second derivatives do not know.
            let by_distance = policy.radius(found.harmonic_mean, footprint);
            return policy.bounded(found.hessian.radius(light, self.quality.curvature).min(by_distance), footprint);
        }
        // Where light changes fast, records are dense: but noise must not pass for change.
        let limit = found.record.gradient_limit().max(0.25 * found.harmonic_mean);
        policy.radius(found.harmonic_mean.min(2.0 * limit), footprint)
    }

    /// Radius of an EAS record at `point`, whose nearest neighbour is at `nearest`. The Hessian is that of the reflected
    /// light as the sources themselves foretell it.
    pub(super) fn eas_radius(&self, record: &EasRecord, point: &Point, nearest: f32, policy: RadiusPolicy) -> f32 {
        let radius = policy.radius(nearest, point.footprint);
        if !self.quality.spacing.hessian {
            return radius;
        }
        let step = STEP * radius;
        let reflected = |x: f32, y: f32| {
            let position = point.at.p + point.frame.to_world(Vec3A::new(x, y, 0.0));
            self.eas_light(record, point, position).map_or(0.0, luminance)
        };
        let bound = Hessian::of(step, reflected).radius(reflected(0.0, 0.0), self.quality.curvature);
        policy.bounded(bound.min(nearest), point.footprint)
    }

    /// What an EAS record reflects at `position` to the eye of `point`.
    fn eas_light(&self, record: &EasRecord, point: &Point, position: Vec3A) -> Option<Rgb> {
        let Treatment::Eas { lobe, .. } = self.treatment(point) else { return None };
        let (lobe, parts) = (&self.policy.lobes[lobe], self.world.bsdf(&point.at).parts()?);
        let reflector = Reflector::of(&lobe.table, &parts);
        let at = Receiver { position, frame: point.frame, wo: point.frame.to_local(point.at.wo) };
        let found = SCRATCH
            .with_borrow_mut(|scratch| reflect(record, &at, &reflector, &lobe.albedo, self.quality.estimator, scratch));
        Some(parts.diffuse * mean_radiance(found.irradiance) + found.specular)
    }

    /// EAS records that disagree about pixel `i`.
    pub(super) fn eas_disagreeing(&self, cache: &Cache<EasRecord>, i: usize) -> Vec<Shrink> {
        let policy = self.quality.eas;
        self.disagreeing(cache, i, (self.quality.weight, policy), |point, record| {
            let same = record.material == point.material.0;
            same.then(|| self.eas_light(record, point, point.at.p)).flatten()
        })
    }

    /// Harmonic records that disagree about pixel `i`.
    pub(super) fn harmonics_disagreeing(&self, cache: &Cache<HarmonicsRecord>, i: usize) -> Vec<Shrink> {
        let policy = self.quality.eas;
        self.disagreeing(cache, i, (self.quality.weight, policy), |point, record| {
            let Treatment::Harmonics { brdf } = self.treatment(point) else { return None };
            let parts = self.world.bsdf(&point.at).parts()?;
            let at = Receiver { position: point.at.p, frame: point.frame, wo: point.frame.to_local(point.at.wo) };
            let brdf = &self.policy.harmonics[brdf];
            let found = SCRATCH.with_borrow_mut(|scratch| {
                scratch.harmonics.look(brdf, &at);
                scratch.harmonics.read(record, at.position)
            });
            (record.material == point.material.0)
                .then(|| parts.diffuse * mean_radiance(found.irradiance) + brdf.color(&parts, at.wo) * found.specular)
        })
    }

    /// Irradiance records that disagree about pixel `i`.
    pub(super) fn irradiance_disagreeing(
        &self,
        cache: &Cache<IrradianceRecord>,
        i: usize,
        policy: RadiusPolicy,
    ) -> Vec<Shrink> {
        self.disagreeing(cache, i, (Weight::Smooth, policy), |point, record| {
            Some(record.at(point.at.p, point.hemisphere_normal()))
        })
    }

    fn disagreeing<R: Record>(
        &self,
        cache: &Cache<R>,
        i: usize,
        (weight, policy): (Weight, RadiusPolicy),
        value: impl Fn(&Point, &R) -> Option<Rgb>,
    ) -> Vec<Shrink> {
        let (Some(fraction), Some(point)) = (self.quality.spacing.adaptive, &self.points[i]) else { return Vec::new() };
        let smallest = policy.min_pixels * point.footprint;
        let at = (point.at.p, point.hemisphere_normal());
        disagreeing(cache, at, weight, (fraction, smallest), |record| value(point, record))
    }
}

/// Step of the differences, over the radius by distance.
const STEP: f32 = 0.25;
