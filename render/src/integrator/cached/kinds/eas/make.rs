//! How an EAS record is made, and how far it reaches.

use super::{Eas, GlossyKind, Held, Memory};
use crate::bsdf::Parts;
use crate::cache::RadiusPolicy;
use crate::color::luminance;
use crate::hemisphere::{GatherSample, View, hemisphere_directions, nearest, view_directions};
use crate::integrator::cached::points::Point;
use crate::integrator::cached::site::Site;
use crate::record::eas::{EasRecord, Estimator, ViewCone};
use crate::record::{Centroid, Receiver, Record, Reflector, Tree, cut};
use crate::world::Counts;
use glam::Vec3A;
use std::cell::RefCell;

thread_local! {
    static MEMORY: RefCell<Memory> = RefCell::default();
}

/// The cone about the mirror direction of the first view that holds those of all.
fn cone(views: &[View]) -> ViewCone {
    let mirrors: Vec<Vec3A> = views.iter().map(View::mirror).collect();
    let Some(axis) = mirrors.first() else { return ViewCone::ALL };
    let cos = mirrors.iter().map(|mirror| mirror.dot(*axis)).fold(1.0, f32::min).clamp(-1.0, 1.0);
    ViewCone { axis: axis.to_array(), half_angle: cos.acos() }
}

impl Eas {
    /// The record of a place, its tree's samples, and what they took.
    pub fn record(&self, held: Held, site: &Site) -> Option<(EasRecord, Vec<GatherSample>, Counts)> {
        let lobe = &self.lobes[held.lobe];
        let quality = site.quality();
        let frame = site.frame();
        let parts = site.parts()?;
        let reflector = Reflector::of(&lobe.table, &parts);
        let mut gather = site.gather(Self::SALT);
        let (mut reach, mut seen) = (quality.glossy.max_pixels, ViewCone::ALL);
        let (mut samples, tree, directions) = match quality.estimator {
            Estimator::Paper => {
                let mut samples = gather.uniform(&frame, quality.paper_rays);
                let tree = Tree::new(&mut samples, 1, Centroid::Position);
                (samples, tree, hemisphere_directions(quality.directions))
            }
            Estimator::Improved => {
                let (views, pixels) = site.views(lobe.width);
                reach = pixels;
                if site.is_one_of_many() {
                    seen = cone(&views);
                }
                let cells = site.guided_cells(&frame, &views, lobe.width);
                let mut samples = gather.cells(&frame, &cells);
                let tree = Tree::of_cells(&mut samples, &cells);
                (samples, tree, view_directions(&frame, &views))
            }
        };
        let cut = cut(&tree, &reflector, &directions, &quality.cut);
        let point = site.point();
        let mut record = EasRecord::new(point.at.p, &frame, point.finish.class, &tree, &cut, quality.estimator);
        record.views = seen;
        let policy = RadiusPolicy { max_pixels: reach, ..quality.glossy };
        record.set_radius(self.radius(held, &record, (site, point, &parts), nearest(&samples), policy));
        samples.shrink_to_fit();
        Some((record, samples, gather.counts))
    }

    /// Radius of a record at a point, whose nearest neighbour is at `nearest`. The Hessian is that of the reflected light as
    /// the sources themselves foretell it.
    fn radius(
        &self,
        held: Held,
        record: &EasRecord,
        (site, point, parts): (&Site, &Point, &Parts),
        nearest: f32,
        policy: RadiusPolicy,
    ) -> f32 {
        let quality = site.quality();
        if !quality.spacing.hessian {
            return policy.radius(nearest, point.footprint);
        }
        let reflected = |x: f32, y: f32| {
            let position = point.at.p + point.frame.to_world(Vec3A::new(x, y, 0.0));
            let at = Receiver { position, frame: point.frame, wo: point.frame.to_local(point.at.wo) };
            luminance(MEMORY.with_borrow_mut(|memory| self.light(held, record, parts, &at, quality, memory)))
        };
        policy.by_bending(nearest, point.footprint, quality.curvature, reflected)
    }
}
