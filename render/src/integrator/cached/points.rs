//! The surfaces that pixels show: where records are made and read.

use super::policy::{Finish, Policy};
use crate::bsdf::{Bsdf, Component, Sample};
use crate::camera::RayGenerator;
use crate::frame::Frame;
use crate::hemisphere::View;
use crate::integrator::media::Media;
use crate::ray::Ray;
use crate::sampler::Sampler;
use crate::scene::{Camera, Crop, MaterialId, Projection, Rgb};
use crate::world::{Interaction, Queries, World};
use glam::{Vec2, Vec3A};
use std::sync::OnceLock;

/// A surface seen directly or through perfectly specular ones.
#[derive(Clone, Copy, Debug)]
pub struct Point {
    /// The surface.
    pub at: Interaction,
    /// Local frame, bent where a texture bends it.
    pub frame: Frame,
    /// Material behind all wrappers.
    pub material: MaterialId,
    /// The index of a component, where the surface has some that are treated apart; 0 where it is taken as one.
    pub component: u8,
    /// How it is treated there.
    pub finish: Finish,
    /// Width of a pixel there, in the unit of the scene: it grows with the length of the path, through mirrors too.
    pub footprint: f32,
    /// Segments from the eye.
    pub segments: u32,
    /// Colour of the mirrors on the way.
    pub throughput: Rgb,
}

impl Point {
    /// Normal on the side of the eye, not bent by textures: the hemisphere of a record, which serves any bent normal.
    pub fn hemisphere_normal(&self) -> Vec3A {
        self.at.shading_normal * 1f32.copysign(self.at.shading_normal.dot(self.frame.normal()))
    }

    /// How it scatters.
    pub fn bsdf<'a>(&self, world: &'a World) -> Bsdf<'a> {
        if self.component == 0 { world.bsdf(&self.at) } else { world.component(&self.at, self.component) }
    }

    /// A component of it.
    pub(super) fn of(&self, component: &Component, finish: Finish) -> Self {
        let Component { index, weight, bsdf } = component;
        let (frame, material) = (*bsdf.frame(), bsdf.material());
        Self { frame, material, component: *index, finish, throughput: self.throughput * *weight, ..*self }
    }

    /// How the eye sees it.
    pub fn view(&self) -> View {
        View { normal: self.frame.normal(), wo: self.at.wo }
    }
}

/// A path from the eye through perfectly specular surfaces.
pub struct Walk {
    ray: Ray,
    throughput: Rgb,
    length: f32,
    media: Media,
    segments: u32,
}

impl Walk {
    /// Before its first segment.
    pub fn new(ray: Ray) -> Self {
        Self { ray, throughput: Rgb::ONE, length: 0.0, media: Media::NONE, segments: 0 }
    }

    /// Goes on from a surface, `factor` times as much light; whether there is any.
    pub fn go_on(&mut self, world: &World, at: &Interaction, bsdf: &Bsdf, sample: &Sample, factor: f32) -> bool {
        self.throughput *= sample.weight.sum() * factor;
        self.media.pass(world, at, bsdf, sample.wi);
        self.ray = at.spawn(sample.wi);
        self.throughput.max_element() > 0.0
    }
}

/// The surface that ends the specular chain of a camera ray; `scatter` is its BSDF.
#[allow(clippy::large_enum_variant)] // lives on the stack, for one call
pub enum Seen<'a> {
    /// Nothing; the direction in which light from infinity is seen, if it counts.
    Nothing { direction: Vec3A, throughput: Rgb, segments: u32 },
    /// A surface that is not perfectly specular.
    Surface { point: Point, bsdf: Bsdf<'a> },
    /// The path ended on the way.
    Ended,
}

/// Follows a path through perfectly specular surfaces. `emitted` is called with every surface on the way that shines, the last
/// included, with the throughput and the number of segments.
#[inline(always)]
pub fn see<'a>(
    (world, policy): (&'a World, &Policy),
    camera: &PixelCone,
    walk: &mut Walk,
    sampler: &mut Sampler,
    max_segments: u32,
    queries: &mut Queries,
    mut emitted: impl FnMut(&Interaction, Rgb, u32),
) -> Seen<'a> {
    while walk.segments < max_segments {
        walk.segments += 1;
        let segments = walk.segments;
        let hit = queries.intersect(world, &walk.ray);
        if !hit.exists() {
            return Seen::Nothing { direction: walk.ray.direction, throughput: walk.throughput, segments };
        }
        let at = world.interaction(&walk.ray, &hit);
        walk.length += hit.t;
        emitted(&at, walk.throughput * walk.media.left(at.distance), segments);
        if let Some((component, finish)) = policy.main_component(world, &at) {
            let bsdf = component.bsdf;
            let throughput = walk.throughput * walk.media.left_before(world, &at, &bsdf);
            walk.throughput = throughput;
            let (frame, material, footprint) = (*bsdf.frame(), bsdf.material(), camera.width_at(walk.length));
            let component = component.index;
            let point = Point { at, frame, material, component, finish, footprint, segments, throughput };
            return Seen::Surface { point, bsdf };
        }
        let bsdf = world.bsdf(&at);
        walk.throughput *= walk.media.left_before(world, &at, &bsdf);
        if !bsdf.is_delta() {
            let footprint = camera.width_at(walk.length);
            let (frame, material, throughput) = (*bsdf.frame(), bsdf.material(), walk.throughput);
            let finish = policy.finish(&world.scene, material, &at.coordinates);
            let point = Point { at, frame, material, component: 0, finish, footprint, segments, throughput };
            return Seen::Surface { point, bsdf };
        }
        let choice = sampler.next_2d();
        let Some(sample) = bsdf.sample(choice.y, sampler.next_2d()) else { return Seen::Ended };
        if !walk.go_on(world, &at, &bsdf, &sample, 1.0) {
            return Seen::Ended;
        }
    }
    Seen::Ended
}

/// What a pixel sees.
#[derive(Clone, Copy, Debug)]
pub struct PixelCone {
    /// Width at the eye; 0 unless rays are parallel.
    start: f32,
    /// Growth of the width with distance.
    tangent: f32,
}

impl PixelCone {
    /// That of a camera.
    pub fn new(camera: &Camera) -> Self {
        let of_film = 2.0 / camera.film.width.max(1) as f32;
        match camera.projection {
            Projection::Perspective { fov_x } => Self { start: 0.0, tangent: of_film * (0.5 * fov_x).tan() },
            Projection::Orthographic { half_width } => Self { start: of_film * half_width, tangent: 0.0 },
        }
    }

    /// Width of a pixel at the end of a path of this length.
    pub fn width_at(&self, length: f32) -> f32 {
        self.start + self.tangent * length
    }
}

/// What the middle of every pixel shows, found where it is asked for.
pub(super) struct Sight<'a> {
    world: &'a World,
    policy: &'a Policy,
    generator: RayGenerator,
    cone: PixelCone,
    window: Crop,
    seed: u64,
    /// Mirrors in a row that are looked through.
    max: u32,
    points: Vec<OnceLock<Option<Box<Point>>>>,
}

impl<'a> Sight<'a> {
    /// Through a camera.
    pub fn new(world: &'a World, camera: &Camera, policy: &'a Policy, seed: u64, max: u32) -> Self {
        let window = camera.film.window();
        let count = window.width as usize * window.height as usize;
        let points = (0..count).map(|_| OnceLock::new()).collect();
        let (generator, cone) = (RayGenerator::new(camera), PixelCone::new(camera));
        Self { world, policy, generator, cone, window, seed, max, points }
    }

    /// What the pixel of an index, row by row, shows.
    pub fn at(&self, i: usize) -> Option<&Point> {
        let Self { window, points, .. } = self;
        let pixel = || {
            let at = (window.x + i as u32 % window.width, window.y + i as u32 / window.width);
            self.pixel_point(at).map(Box::new)
        };
        points[i].get_or_init(pixel).as_deref()
    }

    /// The same without a memory; choices on the way (reflection or refraction) are the sampler's first ones.
    fn pixel_point(&self, pixel: (u32, u32)) -> Option<Point> {
        let Self { world, policy, generator, cone, seed, max, .. } = self;
        let mut sampler = Sampler::new(*seed, pixel, 0);
        let ray = generator.ray(pixel.0, pixel.1, Vec2::splat(0.5));
        let mut walk = Walk::new(ray);
        match see((world, policy), cone, &mut walk, &mut sampler, *max, &mut Queries::default(), |_, _, _| ()) {
            Seen::Surface { point, .. } => Some(point),
            Seen::Nothing { .. } | Seen::Ended => None,
        }
    }
}
