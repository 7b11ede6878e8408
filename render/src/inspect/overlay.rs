//! Where records are, drawn over a rendering.

use crate::camera::RayGenerator;
use crate::frame::Frame;
use crate::image::Image;
use crate::integrator::cached::kinds::{self, GlossyCaches};
use crate::integrator::cached::{Caches, EachKind, Listed};
use crate::ray::Ray;
use crate::record::Record;
use crate::scene::{Camera, Crop};
use crate::world::World;
use core::convert::Infallible;
use core::f32::consts::TAU;
use glam::{Vec2, Vec3A};
use rayon::prelude::*;

/// Colours of the kinds, linear: EAS or harmonics, irradiance, coarse irradiance.
const GLOSSY: [f32; 3] = [1.0, 0.15, 0.05];
const IRRADIANCE: [f32; 3] = [0.05, 0.9, 0.1];
const COARSE: [f32; 3] = [0.1, 0.3, 1.0];

/// Share of a pixel that a ring covers; a dot covers all of it.
const RING: f32 = 0.35;

/// What is drawn of records.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Marks {
    /// A dot where each is.
    pub dots: bool,
    /// The circle that it reaches.
    pub zones: bool,
}

impl Marks {
    /// Both.
    pub const ALL: Self = Self { dots: true, zones: true };
}

/// [`show_marks`] of dots and zones.
pub fn show_records(image: &Image, world: &World, caches: &Caches) -> Image {
    show_marks(image, (world, &world.scene.camera), caches, Marks::ALL)
}

/// A rendering with a dot for every record that its camera sees, and the circle of its zone of influence on its tangent plane,
/// at least one pixel wide: EAS or harmonic records red, irradiance green, coarse irradiance blue. Records and parts of circles that something hides, and
/// those of surfaces seen in mirrors only, are left out.
pub fn show_marks(image: &Image, (world, camera): (&World, &Camera), caches: &Caches, marks: Marks) -> Image {
    let (window, camera) = (camera.film.window(), RayGenerator::new(camera));
    let mut out = Overlay { image: image.clone(), camera, window, world, marks };
    out.records(caches.coarse.records(), COARSE);
    out.records(caches.irradiance.records(), IRRADIANCE);
    let Ok(()) = kinds::each(&mut Glossy { out: &mut out, caches: &caches.glossy });
    out.image
}

/// Draws the records of every kind.
struct Glossy<'a, 'b> {
    out: &'a mut Overlay<'b>,
    caches: &'a GlossyCaches,
}

impl EachKind for Glossy<'_, '_> {
    type Error = Infallible;

    fn run<K: Listed>(&mut self) -> Result<(), Infallible> {
        self.out.records(K::cache(self.caches).records(), GLOSSY);
        Ok(())
    }
}

struct Overlay<'a> {
    image: Image,
    camera: RayGenerator,
    window: Crop,
    world: &'a World,
    marks: Marks,
}

/// Pixels that a record covers.
#[derive(Default)]
struct Covered {
    dot: Option<usize>,
    ring: Vec<usize>,
}

impl Overlay<'_> {
    /// Draws records over each other in their order.
    fn records<R: Record + Sync>(&mut self, records: &[R], color: [f32; 3]) {
        let covered: Vec<Covered> = records.par_iter().filter_map(|record| self.covered(record)).collect();
        for Covered { dot, ring } in covered {
            ring.into_iter().for_each(|i| self.blend(i, color, RING));
            dot.into_iter().for_each(|i| self.blend(i, color, 1.0));
        }
    }

    fn covered(&self, record: &impl Record) -> Option<Covered> {
        let (position, radius) = (record.position(), record.radius());
        let dot = self.project(position)?;
        if self.hidden(position) {
            return None;
        }
        let mut covered = Covered { dot: self.pixel(dot).filter(|_| self.marks.dots), ring: Vec::new() };
        if !self.marks.zones {
            return Some(covered);
        }
        let frame = Frame::from_normal(record.normal());
        let on_ring = |k: usize, steps: usize| {
            let (s, c) = (TAU * k as f32 / steps as f32).sin_cos();
            position + radius * frame.to_world(Vec3A::new(c, s, 0.0))
        };
        // Steps of about a pixel along the circle, as wide as it looks.
        const COARSE_STEPS: usize = 16;
        let extent = (0..COARSE_STEPS)
            .filter_map(|k| self.project(on_ring(k, COARSE_STEPS)))
            .map(|p| p.distance(dot))
            .fold(1.0, f32::max);
        let steps = (1.5 * TAU * extent).ceil().clamp(8.0, 20_000.0) as usize;
        // A pixel is blended once, however many steps fall on it.
        for k in 0..steps {
            let on_ring = on_ring(k, steps);
            if let Some(p) = self.project(on_ring).filter(|_| !self.hidden(on_ring)) {
                let away = p - dot;
                let p = if away.length() < 1.0 { dot + away.try_normalize().unwrap_or(Vec2::X) } else { p };
                covered.ring.extend(self.pixel(p));
            }
        }
        covered.ring.sort_unstable();
        covered.ring.dedup();
        Some(covered)
    }

    /// Pixels of the rendering, which may be a part of the film.
    fn project(&self, p: Vec3A) -> Option<Vec2> {
        let (x, y) = self.camera.project(p)?;
        Some(Vec2::new(x - self.window.x as f32, y - self.window.y as f32))
    }

    fn pixel(&self, p: Vec2) -> Option<usize> {
        let (w, h) = (self.image.width, self.image.height);
        let inside = p.x >= 0.0 && p.y >= 0.0 && p.x < w as f32 && p.y < h as f32;
        inside.then(|| p.y as usize * w as usize + p.x as usize)
    }

    fn blend(&mut self, i: usize, color: [f32; 3], share: f32) {
        let pixel = &mut self.image.pixels[i];
        *pixel = core::array::from_fn(|c| pixel[c].min(1.0) * (1.0 - share) + color[c] * share);
    }

    fn hidden(&self, p: Vec3A) -> bool {
        let eye = self.camera.eye(p);
        let ray = Ray { t_max: 1.0 - 1e-3, ..Ray::new(eye, p - eye) };
        self.world.occluded(&ray)
    }
}
