//! Outlines: pixels in which what is seen changes take more camera rays.
//!
//! With few samples the share of a pixel that a thing covers is a guess, and no denoiser mends it. A lamp is tens to thousands of
//! times as bright as what is beside it, and is not denoised; from frame to frame such outlines flicker more than all the rest of
//! a picture. And denoisers take albedo and normals for the truth: where those are sharp and have no noise, so is what comes out. A
//! ray that asks only what is seen costs a tenth of a path, and in most pictures few pixels need it.

use crate::camera::RayGenerator;
use crate::integrator::PathTracer;
use crate::picture::{Picture, Radiance};
use crate::sampler::Sampler;
use crate::scene::{Camera, Crop, Rgb};
use crate::simd::widest;
use crate::world::{Counts, Queries, World};
use fearless_simd::Level;
use rayon::prelude::*;
use std::time::Instant;

/// Camera rays of a pixel at an outline of emission.
const EMISSION_RAYS: u32 = 64;
/// Camera rays of a pixel where albedo or normals change. With 2 samples of a path and guides of 10, 18 and 128 rays a wooden staircase
/// has .43, .38 and .33 of the error that it has with guides of the samples alone; at 8 samples, with 8, 16 and 24 rays, .52, .44 and .41.
pub const GUIDE_RAYS: u32 = 16;

/// Difference of the emission of neighbouring pixels that makes an outline, over the larger one.
const EMISSION_STEP: f32 = 0.3;
/// Difference in albedo that does, and in the unit normal (3 degrees).
const ALBEDO_STEP: f32 = 0.02;
const NORMAL_STEP: f32 = 0.05;

/// Outlines of what.
#[derive(Clone, Copy, Debug)]
pub struct Of {
    /// Of emission that is seen directly.
    pub emission: bool,
    /// Of albedo and normals, for a denoiser.
    pub guides: bool,
}

/// Of what a single picture is denoised with: its emission stays that of its samples.
pub const GUIDES: Of = Of { emission: false, guides: true };

/// What a pixel shows.
#[derive(Clone, Copy)]
struct Seen {
    emission: Rgb,
    albedo: Rgb,
    normal: Rgb,
}

impl Seen {
    /// Of sums over so many rays.
    fn new(sum: &Radiance, rays: f32) -> Self {
        Self { emission: sum.emission / rays, albedo: sum.albedo / rays, normal: sum.normal / rays }
    }

    fn emits_unlike(&self, other: &Self) -> bool {
        let (a, b) = (self.emission, other.emission);
        (a - b).abs().max_element() > EMISSION_STEP * a.max(b).max_element()
    }

    fn looks_unlike(&self, other: &Self) -> bool {
        (self.albedo.min(Rgb::ONE) - other.albedo.min(Rgb::ONE)).abs().max_element() > ALBEDO_STEP
            || self.normal.distance_squared(other.normal) > NORMAL_STEP * NORMAL_STEP
    }

    /// Camera rays that a pixel takes for the sake of what a neighbour shows.
    fn rays(&self, neighbour: &Self, of: Of) -> u32 {
        if of.emission && self.emits_unlike(neighbour) {
            EMISSION_RAYS
        } else if of.guides && self.looks_unlike(neighbour) {
            GUIDE_RAYS
        } else {
            0
        }
    }
}

/// How camera rays see.
struct Eye<'a> {
    world: &'a World,
    tracer: PathTracer,
    camera: RayGenerator,
    seed: u64,
}

impl<'a> Eye<'a> {
    fn new((world, camera): (&'a World, &Camera), seed: u64, indirect_only: bool) -> Self {
        let tracer = PathTracer { settings: world.scene.integrator, indirect_only };
        Self { world, tracer, camera: RayGenerator::new(camera), seed }
    }

    /// What the rays of these indices see of a pixel, summed.
    fn look(&self, (x, y): (u32, u32), indices: core::ops::Range<u32>, queries: &mut Queries) -> Radiance {
        let mut sum = Radiance::NONE;
        widest(
            Level::new(),
            #[inline(always)]
            || {
                for index in indices {
                    let mut sampler = Sampler::new(self.seed, (x, y), index);
                    let ray = self.camera.sample(x, y, &mut sampler);
                    let seen = self.tracer.sight(self.world, ray, &mut sampler, queries).finite(queries);
                    sum.emission += seen.emission;
                    sum.albedo += seen.albedo;
                    sum.normal += seen.normal;
                }
            },
        );
        sum
    }
}

/// Takes what pixels at outlines show from more camera rays than the samples of a picture of this camera that was rendered with this
/// seed. `indirect_only`: light that is scattered less than twice was left out of the picture.
pub fn refine(from: (&World, &Camera), picture: &mut Picture, (seed, indirect_only): (u64, bool), of: Of) {
    let (width, spp) = (picture.width as usize, picture.spp);
    let rays = rays(picture, of);
    let eye = Eye::new(from, seed, indirect_only);
    let [left, top] = picture.corner;
    let counts: Counts = picture
        .pixels
        .par_iter_mut()
        .zip(rays)
        .enumerate()
        .filter(|(_, (_, rays))| *rays > spp)
        .map(|(i, (pixel, rays))| {
            let mut queries = Queries::default();
            let at = (left + (i % width) as u32, top + (i / width) as u32);
            let more = eye.look(at, spp..rays, &mut queries);
            let (mut sum, share) = (pixel.sum(), spp as f32 / rays as f32);
            if of.emission {
                sum.emission = (sum.emission + more.emission) * share;
            }
            sum.albedo = (sum.albedo + more.albedo) * share;
            sum.normal = (sum.normal + more.normal) * share;
            pixel.set_sum(&sum);
            queries.counts
        })
        .sum();
    picture.counts += counts;
    if of.guides {
        picture.outline_rays = GUIDE_RAYS;
    }
}

/// Camera rays that each pixel takes for the sake of its neighbours.
fn rays(picture: &Picture, of: Of) -> Vec<u32> {
    let (width, height) = (picture.width as usize, picture.height as usize);
    let row = |y: usize| -> Vec<Seen> {
        let pixels = &picture.pixels[y * width..(y + 1) * width];
        pixels.iter().map(|p| Seen::new(&p.sum(), picture.spp as f32)).collect()
    };
    (0..height)
        .into_par_iter()
        .flat_map_iter(|y| {
            let rows: Vec<_> = (y.saturating_sub(1)..=(y + 1).min(height - 1)).map(row).collect();
            (0..width).map(move |x| {
                let (here, columns) = (rows[y.min(1)][x], x.saturating_sub(1)..=(x + 1).min(width - 1));
                let neighbours = rows.iter().flat_map(|row| &row[columns.clone()]);
                neighbours.map(|other| here.rays(other, of)).max().unwrap_or(0)
            })
        })
        .collect()
}

/// Side of the blocks of pixels that [`seconds`] looks at, and how many of them there are along each side of the film, at most.
const BLOCK: u32 = 8;
const BLOCKS: u32 = 8;
/// Time of a path, in that of one of these rays, about: 5 in a box, 10 in a staircase.
const PATH: f64 = 8.0;

/// About what [`refine`] with guides takes after path tracing for `time` seconds, by looking at a few blocks of the film.
pub fn seconds(world: &World, time: f64) -> f64 {
    let Crop { x, y, width, height } = world.scene.camera.film.window();
    let eye = Eye::new((world, &world.scene.camera), 0, false);
    let start = Instant::now();
    let corner =
        |size: u32, k: u32| (u64::from(size.saturating_sub(BLOCK)) * u64::from(k) / u64::from(BLOCKS - 1)) as u32;
    let (columns, rows) = (BLOCK.min(width), BLOCK.min(height));
    let unlike: u32 = (0..BLOCKS * BLOCKS)
        .into_par_iter()
        .map(|block| {
            let mut queries = Queries::default();
            let (left, top) = (x + corner(width, block % BLOCKS), y + corner(height, block / BLOCKS));
            let place = |i: u32| (left + i % columns, top + i / columns);
            let seen: Vec<Seen> =
                (0..columns * rows).map(|i| Seen::new(&eye.look(place(i), 0..1, &mut queries), 1.0)).collect();
            let rays = |i: usize, other: Option<&Seen>| other.map_or(0, |other| seen[i].rays(other, GUIDES));
            let columns = columns as usize;
            (0..seen.len()).filter(|&i| rays(i, seen.get(i + 1)).max(rays(i, seen.get(i + columns))) > 0).count() as u32
        })
        .sum();
    let looked_at = f64::from(BLOCKS * BLOCKS * columns * rows);
    let ray = start.elapsed().as_secs_f64() / looked_at;
    let pixels = f64::from(width) * f64::from(height);
    let samples = time / (pixels * PATH * ray);
    // A pixel is at an outline for the sake of eight neighbours, of which two were looked at.
    let share = (2.0 * f64::from(unlike) / looked_at).min(1.0);
    (f64::from(GUIDE_RAYS) - samples).max(0.0) * ray * pixels * share
}
