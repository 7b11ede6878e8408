//! A place where a record is made, and the gathers there.

use super::incident::IncidentTracer;
use super::points::Point;
use super::settings::Quality;
use super::views::Pixels;
use crate::bsdf::Parts;
use crate::frame::Frame;
use crate::hemisphere::{
    Cell, GatherSample, Guide, Incident, View, gather_cells, gather_cells_uniform, gather_uniform,
};
use crate::record::Zone;
use crate::record::irradiance::{Gathered, IrradianceRecord, Strata};
use crate::sampler::Sampler;
use crate::scene::Rgb;
use crate::simd::widest;
use crate::world::{Counts, Queries, World};
use fearless_simd::Level;
use glam::{Vec2, Vec3A};

/// What a pixel shows, and what making its record needs.
pub struct Site<'a> {
    /// The scene.
    pub(super) world: &'a World,
    /// Rays, spacing, tolerance.
    pub(super) quality: &'a Quality,
    /// Seed of all sample points.
    pub(super) seed: u64,
    /// Whether the picture is one of many frames.
    pub(super) is_one_of_many: bool,
    /// What other pixels show.
    pub(super) pixels: Pixels<'a>,
    /// Follows paths.
    pub(super) tracer: &'a IncidentTracer<'a>,
    /// The surface.
    pub(super) point: &'a Point,
    /// Index of the pixel.
    pub(super) pixel: usize,
}

impl<'a> Site<'a> {
    /// Rays, spacing, tolerance.
    pub fn quality(&self) -> &'a Quality {
        self.quality
    }

    /// Whether pictures from elsewhere will read the record, as in a walk.
    pub fn is_one_of_many(&self) -> bool {
        self.is_one_of_many
    }

    /// The surface.
    pub fn point(&self) -> &'a Point {
        self.point
    }

    /// Frame of the hemisphere of a record: that of the surface, but for a normal that a texture bent.
    pub fn frame(&self) -> Frame {
        let normal = self.point.hemisphere_normal();
        if normal.dot(self.point.frame.normal()) > 0.9999 { self.point.frame } else { Frame::from_normal(normal) }
    }

    /// Zone of a record in this frame, without radius.
    pub fn zone(&self, frame: &Frame) -> Zone {
        Zone::at(self.point.at.p, frame, self.point.finish.class)
    }

    /// Colours of the material; `None` for a model without separate parts.
    pub fn parts(&self) -> Option<Parts> {
        self.point.bsdf(self.world).parts()
    }

    /// Gathers light with sample points of their own, told apart by `salt`.
    pub fn gather(&self, salt: u64) -> Gather<'a> {
        Gather::new(self.tracer, self.point, self.seed, salt, self.pixel as u32)
    }

    /// The views that will read the record, and how far they reach in pixels.
    pub fn views(&self, lobe_width: f32) -> (Vec<View>, f32) {
        self.pixels.views(self.point, self.pixel, self.quality.glossy, lobe_width)
    }

    /// The hemisphere divided for the views that will read a record, with the rays of each cell.
    pub fn guided_cells(&self, frame: &Frame, views: &[View], lobe_width: f32) -> Vec<(Cell, u32)> {
        let quality = self.quality();
        let guide = Guide::new(frame, views, lobe_width, quality.fineness);
        guide.cells_with_rays(quality.max_cells, quality.rays_per_cell)
    }
}

/// Gathers at one point: every sample has its own sample points, all are well distributed together.
pub struct Gather<'a> {
    tracer: &'a IncidentTracer<'a>,
    point: &'a Point,
    seed: u64,
    key: (u32, u32),
    /// What was traced.
    pub counts: Counts,
}

impl<'a> Gather<'a> {
    fn new(tracer: &'a IncidentTracer<'a>, point: &'a Point, seed: u64, salt: u64, pixel: u32) -> Self {
        let seed = seed.wrapping_add(salt.wrapping_mul(0x9e37_79b9_7f4a_7c15));
        Self { tracer, point, seed, key: (pixel, salt as u32), counts: Counts::default() }
    }

    /// The two closures of a gather: the place of a sample in its stratum, and the light it meets.
    fn run<T>(
        &mut self,
        with: impl FnOnce(&mut dyn FnMut(u32) -> Vec2, &mut dyn FnMut(Vec3A, u32) -> Incident) -> T,
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

    /// An irradiance record.
    pub fn irradiance(&mut self, frame: &Frame, strata: Strata) -> Gathered {
        let position = self.point.at.p;
        self.run(|point, incident| IrradianceRecord::gather(position, frame, strata, point, incident))
    }

    /// Samples uniform in solid angle.
    pub fn uniform(&mut self, frame: &Frame, count: u32) -> Vec<GatherSample> {
        self.run(|point, incident| gather_uniform(frame, count, point, incident))
    }

    /// Samples of cells, each with its own number of them, denser where the cosine is larger.
    pub fn cells(&mut self, frame: &Frame, cells: &[(Cell, u32)]) -> Vec<GatherSample> {
        self.run(|point, incident| gather_cells(frame, cells, point, incident))
    }

    /// The same, uniform in solid angle within a cell.
    pub fn cells_uniform(&mut self, frame: &Frame, cells: &[(Cell, u32)]) -> Vec<GatherSample> {
        self.run(|point, incident| gather_cells_uniform(frame, cells, point, incident))
    }
}
