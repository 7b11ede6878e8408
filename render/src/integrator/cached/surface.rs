//! The surfaces of a pixel: samples that show the same one are shaded together.

use super::points::Point;
use super::policy::Finish;
use crate::bsdf::{Bsdf, Parts};
use crate::frame::Frame;
use glam::Vec3A;

/// Cosine between normals that are shaded as one (2.6°): a bump that turns more has its own highlight.
const SAME_NORMAL: f32 = 0.999;

/// Cosine between views that are shaded as one without a lens (8°): a pixel of an ordinary camera never spans more, its
/// mirrors may.
const SAME_VIEW: f32 = 0.99;

/// Distance between samples that are shaded as one, in widths of a pixel: seen at a grazing angle, a pixel is long.
const SAME_PLACE: f32 = 6.0;

/// Samples from which on the distances that they met are believed.
const ENOUGH: f32 = 4.0;

/// Records whose zones are as many times wider than the (harmonic) mean distance of what a surface sees are not believed there.
/// Those of the fill are at most 0.5 to 1 times as wide, in the last pixel before a corner up to 8 times.
const HIDDEN: f32 = 8.0;

/// A surface in a pixel: what its samples have in common is shaded once.
#[derive(Clone, Copy)]
pub struct Surface {
    pub(super) point: Point,
    pub(super) samples: f32,
    /// Sums over the samples.
    pub(super) position: Vec3A,
    pub(super) normal: Vec3A,
    pub(super) wo: Vec3A,
    pub(super) parts: Parts,
    /// One over the distance of what its scattered rays met.
    pub(super) closeness: f32,
    /// Of the numbers of treatments, which ascend with the width of the lobe where a texture gives it.
    treatments: f32,
}

impl Surface {
    /// What one sample shows; `None` for a model without separate parts.
    pub(super) fn new(point: &Point, bsdf: &Bsdf, closeness: f32) -> Option<Self> {
        let parts = bsdf.parts()?;
        Some(Self {
            point: *point,
            samples: 1.0,
            position: point.at.p,
            normal: bsdf.normal(),
            wo: point.at.wo,
            parts: parts * point.throughput,
            closeness,
            treatments: point.finish.treatment as f32,
        })
    }

    /// How it is treated, with the mean lobe of its samples.
    pub(super) fn finish(&self) -> Finish {
        self.point.finish.with((self.treatments / self.samples).round() as u32)
    }

    /// Where it is read.
    #[inline]
    pub(super) fn mean_position(&self) -> Vec3A {
        self.position / self.samples
    }

    /// The normal with which it is read.
    #[inline]
    pub(super) fn mean_normal(&self) -> Vec3A {
        self.normal.try_normalize().unwrap_or(self.point.frame.normal())
    }

    /// Whether the ray from the eye met it first.
    pub(super) fn is_seen_directly(&self) -> bool {
        self.point.segments == 1
    }

    /// Samples of the pixel that show it.
    pub fn samples(&self) -> u64 {
        self.samples as u64
    }

    /// Whether something stands in front of the surface that records with zones of this radius do not know: their hemispheres see
    /// as far as those of the pixel, or the zones are too wide.
    pub(super) fn is_hidden_from(&self, radius: f32) -> bool {
        self.samples >= ENOUGH && self.closeness * radius > HIDDEN * self.samples
    }

    /// Whether another sample shows the same, up to an angle between the views of the given cosine.
    fn is(&self, other: &Self, views: f32) -> bool {
        let (a, b) = (&self.point, &other.point);
        a.material == b.material
            && (a.component, a.finish.class) == (b.component, b.finish.class)
            && a.segments == b.segments
            && a.frame.normal().dot(other.normal) > SAME_NORMAL
            && a.at.wo.dot(b.at.wo) > views
            && a.at.p.distance_squared(b.at.p) < (SAME_PLACE * b.footprint).powi(2)
    }

    fn add(&mut self, other: &Self) {
        self.samples += other.samples;
        self.position += other.position;
        self.normal += other.normal;
        self.wo += other.wo;
        self.parts += other.parts;
        self.closeness += other.closeness;
        self.treatments += other.treatments;
    }
}

/// How samples of a pixel are put together.
#[derive(Clone, Copy, Debug)]
pub(super) struct Grouping {
    /// Most surfaces of a pixel that are told apart.
    most: usize,
    /// Whether views spread over a lens.
    lens: bool,
}

impl Grouping {
    /// Without a lens a pixel shows few surfaces. Behind one it may show another with every sample, too many to keep.
    pub fn new(lens: bool) -> Self {
        Self { most: if lens { 4 } else { 8 }, lens }
    }

    /// Cosine of the largest angle between views that are shaded as one: those from a lens are kept apart where a lobe of
    /// this width would show it; where there is none, they make no difference.
    fn views(self, lobe_width: Option<f32>) -> f32 {
        match lobe_width {
            _ if !self.lens => SAME_VIEW,
            None => -1.0,
            Some(width) => (0.5 * width).cos().max(SAME_VIEW),
        }
    }

    /// Adds a sample to the surface that it shows; gives it back where there is no room for one more.
    pub fn note(self, sample: Surface, lobe_width: Option<f32>, surfaces: &mut Vec<Surface>) -> Option<Surface> {
        let views = self.views(lobe_width);
        if let Some(same) = surfaces.iter_mut().find(|s| s.is(&sample, views)) {
            same.add(&sample);
        } else if surfaces.len() < self.most {
            // Most pixels show one surface: room for four would cost more to touch than to fill.
            surfaces.reserve_exact(1);
            surfaces.push(sample);
        } else {
            return Some(sample);
        }
        None
    }
}

/// The frame of a point turned to the mean normal of its samples.
pub(super) fn turned(point: &Point, normal: Vec3A) -> Frame {
    let x = point.frame.to_world(Vec3A::X);
    Frame::with_tangent(normal, x)
}
