//! Harmonic records in a picture: where they are made, from the same gathers as EAS, and how they are read.

use super::build::{Builder, COVERED, Gather, insert_clamped, record_frame};
use super::incident::IncidentTracer;
use super::points::Point;
use super::policy::Treatment;
use super::shade::Shader;
use crate::bsdf::{Parts, Split};
use crate::cache::{Cache, RadiusPolicy, Weight};
use crate::color::mean_radiance;
use crate::frame::Frame;
use crate::hemisphere::View;
use crate::record::harmonics::{HarmonicBrdf, HarmonicsRecord};
use crate::record::{Receiver, Reflected, Scratch};
use crate::world::Counts;
use glam::Vec3A;
use std::time::Instant;

impl Builder<'_> {
    /// Fills the cache of incident radiance.
    pub(super) fn fill_harmonics(
        &self,
        cache: &mut Cache<HarmonicsRecord>,
        tracer: &IncidentTracer,
        deadline: Option<Instant>,
        progress: &(dyn Fn(f64) + Sync),
    ) {
        let weight = self.quality.weight;
        let covered = |cache: &Cache<HarmonicsRecord>, i: usize| {
            self.points[i].as_ref().is_none_or(|p| {
                let Treatment::Harmonics { brdf } = self.treatment(p) else { return true };
                // Directions that no order holds are path traced.
                if self.policy.harmonics[brdf].outgoing(p.frame.to_local(p.at.wo)).traced >= 1.0 {
                    return true;
                }
                let mut best = 0f32;
                cache.interpolate(p.at.p, p.hemisphere_normal(), weight, |r, w| {
                    if r.material == p.material.0 {
                        best = best.max(w);
                    }
                });
                best > if weight == Weight::Ward { 0.0 } else { COVERED }
            })
        };
        let make = |_: &Cache<HarmonicsRecord>, i: usize| {
            let point = self.points[i].as_ref()?;
            let (record, counts) = self.harmonics_record(tracer, point, i)?;
            // Radiance near the end of the range of its numbers may have none left for its gradients.
            self.counted(record, counts).map(|record| (record, self.quality.eas.min_pixels * point.footprint))
        };
        let adapt = |cache: &Cache<HarmonicsRecord>, i: usize| self.harmonics_disagreeing(cache, i);
        self.filler(deadline, progress).fill(cache, adapt, covered, make, insert_clamped);
    }

    /// The record of what pixel `i` shows, and what it took.
    fn harmonics_record(&self, tracer: &IncidentTracer, point: &Point, i: usize) -> Option<(HarmonicsRecord, Counts)> {
        let Treatment::Harmonics { brdf } = self.treatment(point) else { return None };
        let brdf = &self.policy.harmonics[brdf];
        let width = brdf.specular.lobe_width() as f32;
        let frame = record_frame(point);
        let (views, reach) = self.views(point, i, width);
        let mut gather = Gather::new(tracer, point, self.seed, 4, i as u32);
        let samples = gather.cells_uniform(&frame, &self.guided_cells(&frame, &views, width));
        let nearest = samples.iter().map(|s| s.inv_distance).fold(0.0, f32::max);
        let policy = RadiusPolicy { max_pixels: reach, ..self.quality.eas };
        let radius = policy.radius(1.0 / nearest, point.footprint);
        let order = order_for(brdf, &frame, &views);
        let settings = self.policy.projection.as_ref()?;
        let record = HarmonicsRecord::new(point.at.p, &frame, radius, point.material.0, &samples, order, settings);
        Some((record, gather.counts))
    }
}

/// Largest order that the views of a record read it with ("equal to the order of the BRDF", §4.2).
fn order_for(brdf: &HarmonicBrdf, frame: &Frame, views: &[View]) -> usize {
    let tangent = frame.to_world(Vec3A::X);
    let local = |v: &View| Frame::with_tangent(v.normal, tangent).to_local(v.wo);
    views.iter().map(|v| brdf.outgoing(local(v)).order).max().unwrap_or(1)
}

impl Shader<'_> {
    /// Eqs. 12 and 13: what the records about a point reflect, as [`Split`] of the two parts with the colours given, and the
    /// share of path tracing. Negative radiance of ringing is left as it is: it belongs to the sum.
    #[inline(always)]
    pub(super) fn harmonics(
        &self,
        brdf: usize,
        material: u32,
        at: &Receiver,
        normal: Vec3A,
        scratch: &mut Scratch,
        parts: &Parts,
    ) -> (Option<Split>, f32) {
        let brdf = &self.policy.harmonics[brdf];
        let reader = &mut scratch.harmonics;
        let outgoing = reader.look(brdf, at);
        if outgoing.traced >= 1.0 {
            return (None, 1.0);
        }
        let (mut sum, mut weights) = (Reflected::default(), 0.0);
        self.caches.harmonics.interpolate(at.position, normal, self.quality.weight, |record, w| {
            if record.material == material {
                let part = reader.read(record, at.position);
                sum.irradiance += part.irradiance * w;
                sum.specular += part.specular * w;
                weights += w;
            }
        });
        let cached = (weights > 1e-3).then(|| Split {
            diffuse: parts.diffuse * mean_radiance(sum.irradiance / weights),
            glossy: brdf.color(parts, at.wo) * (sum.specular / weights),
        });
        (cached, outgoing.traced)
    }
}
