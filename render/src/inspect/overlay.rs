//! Where records are, drawn over a rendering.

use crate::camera::RayGenerator;
use crate::frame::Frame;
use crate::image::Image;
use crate::integrator::cached::kinds::{self, GlossyCaches};
use crate::integrator::cached::{Caches, EachKind, Listed};
use crate::ray::Ray;
use crate::record::Record;
use crate::world::World;
use core::convert::Infallible;
use core::f32::consts::TAU;
use glam::{Vec2, Vec3A};

/// Colours of the kinds, linear: EAS or harmonics, irradiance, coarse irradiance.
const GLOSSY: [f32; 3] = [1.0, 0.15, 0.05];
const IRRADIANCE: [f32; 3] = [0.05, 0.9, 0.1];
const COARSE: [f32; 3] = [0.1, 0.3, 1.0];

/// Share of a pixel that a ring covers; a dot covers all of it.
const RING: f32 = 0.35;

/// A rendering with a dot for every record the camera sees, and the circle of its zone of influence on its tangent plane,
/// at least one pixel wide: EAS or harmonic records red, irradiance green, coarse irradiance blue. Records and parts of circles that something hides, and
/// those of surfaces seen in mirrors only, are left out.
pub fn show_records(image: &Image, world: &World, caches: &Caches) -> Image {
    let mut out = Overlay { image: image.clone(), camera: RayGenerator::new(&world.scene.camera), world };
    caches.coarse.records().iter().for_each(|r| out.record(r, COARSE));
    caches.irradiance.records().iter().for_each(|r| out.record(r, IRRADIANCE));
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
        K::cache(self.caches).records().iter().for_each(|r| self.out.record(r, GLOSSY));
        Ok(())
    }
}

struct Overlay<'a> {
    image: Image,
    camera: RayGenerator,
    world: &'a World,
}

impl Overlay<'_> {
    fn record(&mut self, record: &impl Record, color: [f32; 3]) {
        let (position, radius) = (record.position(), record.radius());
        let Some(dot) = self.project(position) else { return };
        if self.hidden(position) {
            return;
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
        let mut covered = Vec::new();
        for k in 0..steps {
            let on_ring = on_ring(k, steps);
            if let Some(p) = self.project(on_ring).filter(|_| !self.hidden(on_ring)) {
                let away = p - dot;
                let p = if away.length() < 1.0 { dot + away.try_normalize().unwrap_or(Vec2::X) } else { p };
                covered.extend(self.pixel(p));
            }
        }
        covered.sort_unstable();
        covered.dedup();
        covered.iter().for_each(|i| self.blend(*i, color, RING));
        if let Some(i) = self.pixel(dot) {
            self.blend(i, color, 1.0);
        }
    }

    /// Pixels of the rendering, which may be a part of the film.
    fn project(&self, p: Vec3A) -> Option<Vec2> {
        let window = self.world.scene.camera.film.window();
        let (x, y) = self.camera.project(p)?;
        Some(Vec2::new(x - window.x as f32, y - window.y as f32))
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
