//! How a harmonic record is made, from the same gathers as EAS.

use super::{GlossyKind, Harmonics, Held};
use crate::cache::RadiusPolicy;
use crate::frame::Frame;
use crate::hemisphere::{View, nearest};
use crate::integrator::cached::site::Site;
use crate::record::harmonics::{HarmonicBrdf, HarmonicsRecord};
use crate::world::Counts;
use glam::Vec3A;

impl Harmonics {
    /// The record of a place, and what it took.
    pub(super) fn record(&self, held: Held, site: &Site) -> Option<(HarmonicsRecord, Counts)> {
        let brdf = &self.brdfs[held.brdf];
        let settings = self.projection.as_ref()?;
        let width = brdf.specular.lobe_width() as f32;
        let (point, frame) = (site.point(), site.frame());
        let (views, reach) = site.views(width);
        let mut gather = site.gather(Self::SALT);
        let samples = gather.cells_uniform(&frame, &site.guided_cells(&frame, &views, width));
        let policy = RadiusPolicy { max_pixels: reach, ..site.quality().glossy };
        let radius = policy.radius(nearest(&samples), point.footprint);
        let order = order_for(brdf, &frame, &views);
        let record = HarmonicsRecord::new(point.at.p, &frame, radius, point.finish.class, &samples, order, settings);
        Some((record, gather.counts))
    }
}

/// Largest order that the views of a record read it with ("equal to the order of the BRDF", §4.2).
fn order_for(brdf: &HarmonicBrdf, frame: &Frame, views: &[View]) -> usize {
    let tangent = frame.to_world(Vec3A::X);
    let local = |v: &View| Frame::with_tangent(v.normal, tangent).to_local(v.wo);
    views.iter().map(|v| brdf.outgoing(local(v)).order).max().unwrap_or(1)
}
