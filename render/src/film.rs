//! From an integrator to a picture: passes over all pixels in parallel until a budget is spent.

use crate::camera::RayGenerator;
use crate::integrator::{Integrator, Start};
use crate::picture::{Budget, Picture, Pixel, Radiance, first_half};
use crate::sampler::Sampler;
use crate::scene::{Camera, Rgb};
use crate::simd::widest;
use crate::world::{Counts, Queries, World};
use fearless_simd::Level;
use rayon::prelude::*;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

/// Samples per pixel of one pass, at most: often enough to look at the clock, seldom enough to cost nothing.
const PASS: u32 = 16;

/// No budget buys more samples: the sampler's index would pass the precision of a sum in f32.
const MAX_SPP: u32 = 1 << 22;

/// Samples from which on the variance is trusted.
const MIN_SPP_FOR_ERROR: u32 = 16;

/// Renders the world through its camera. `progress` is told the share of the work done, from several threads.
pub fn render(
    world: &World,
    integrator: &dyn Integrator,
    budget: Budget,
    seed: u64,
    progress: &(dyn Fn(f64) + Sync),
) -> Picture {
    let camera = &world.scene.camera;
    let mut picture = black(camera);
    let start = Instant::now();
    loop {
        let (pass, end) = match next_pass(&picture, budget, start) {
            Some(next) => next,
            None => return picture,
        };
        let (from, height) = (picture.spp, f64::from(picture.height));
        let rows = AtomicU64::new(0);
        let row_done = || {
            let done = rows.fetch_add(1, Ordering::Relaxed) + 1;
            if let Some(end) = end {
                progress((f64::from(from) + done as f64 / height * f64::from(pass)) / end);
            }
        };
        add_samples((world, camera), integrator, &mut picture, (pass, seed), &|| false, &row_done);
        if let Budget::Error(target) = budget {
            // The squared error falls with the number of samples.
            progress(f64::from(target / picture.relative_error()).powi(2).clamp(0.0, 1.0));
        }
    }
}

/// A picture of a camera without any samples.
pub fn black(camera: &Camera) -> Picture {
    let window = camera.film.window();
    let count = window.width as usize * window.height as usize;
    Picture::of(window, vec![Pixel::default(); count], 0, Counts::default(), false)
}

/// Adds a pass of so many samples to every pixel of a picture that a camera takes, with sample points of this seed.
/// Where `halted` becomes true the rows that are left get none, and the picture is of no use. `row_done` is called after every row.
pub fn add_samples(
    (world, camera): (&World, &Camera),
    integrator: &dyn Integrator,
    picture: &mut Picture,
    (pass, seed): (u32, u64),
    halted: &(dyn Fn() -> bool + Sync),
    row_done: &(dyn Fn() + Sync),
) {
    let (camera, window) = (RayGenerator::new(camera), camera.film.window());
    let level = Level::new();
    let (from, to) = (picture.spp, picture.spp + pass);
    let sample_row = |(y, row): (usize, &mut [Pixel])| {
        let (mut queries, mut batch) = (Queries::default(), Batch::default());
        if halted() {
            return queries.counts;
        }
        widest(
            level,
            #[inline(always)]
            || {
                let chunk = BATCH.div_ceil(pass.max(1) as usize);
                for (i, pixels) in row.chunks_mut(chunk).enumerate() {
                    let corner = (window.x + (i * chunk) as u32, window.y + y as u32);
                    sample_pixels(world, integrator, &camera, seed, corner, from..to, pixels, &mut queries, &mut batch);
                }
            },
        );
        row_done();
        queries.counts
    };
    let rows = picture.pixels.par_chunks_mut(window.width as usize).enumerate().map(sample_row);
    picture.counts += rows.sum::<Counts>();
    picture.spp = to;
    picture.passes += 1;
}

/// Paths that are followed together, at least, where a row has so many.
const BATCH: usize = 1024;

/// Memory of [`sample_pixels`], reused from chunk to chunk.
#[derive(Default)]
struct Batch {
    starts: Vec<Start>,
    samples: Vec<Radiance>,
}

/// Adds the samples of the given indices to neighbouring pixels of a row, the first of them at `corner`.
#[inline(always)]
#[allow(clippy::too_many_arguments)]
fn sample_pixels(
    world: &World,
    integrator: &dyn Integrator,
    camera: &RayGenerator,
    seed: u64,
    corner: (u32, u32),
    indices: core::ops::Range<u32>,
    pixels: &mut [Pixel],
    queries: &mut Queries,
    Batch { starts, samples }: &mut Batch,
) {
    starts.clear();
    for i in 0..pixels.len() as u32 {
        let (x, y) = (corner.0 + i, corner.1);
        let of_pixel = Sampler::new(seed, (x, y), 0);
        starts.extend(indices.clone().map(|index| {
            let mut sampler = of_pixel.with_index(index);
            Start { ray: camera.sample(x, y, &mut sampler), sampler }
        }));
    }
    queries.counts.paths += starts.len() as u64;
    integrator.radiances(world, starts, queries, samples);
    let count = indices.len();
    let first_half = (first_half(indices.end) - first_half(indices.start)) as usize;
    for (i, pixel) in pixels.iter_mut().enumerate() {
        let range = i * count..(i + 1) * count;
        let mut pass = Rgb::ZERO;
        for (k, (start, sample)) in starts[range.clone()].iter().zip(&samples[range]).enumerate() {
            let mut sample = sample.finite(queries);
            if sample.distance > 0.0 {
                sample.distance = camera.depth(start.ray.origin + start.ray.direction * sample.distance);
                pixel.surfaces += 1;
            }
            let light = sample.sum();
            pixel.squares += (light.element_sum() * (1.0 / 3.0)).powi(2);
            pass += light;
            pixel.add(sample, k < first_half);
        }
        pixel.add_pass(pass, count as f32);
    }
}

/// Samples of the next pass and, where known, of the whole rendering; `None` when the budget is spent.
fn next_pass(picture: &Picture, budget: Budget, start: Instant) -> Option<(u32, Option<f64>)> {
    let room = PASS.min(MAX_SPP - picture.spp);
    let (pass, end) = match budget {
        Budget::Samples(n) => (room.min(n.saturating_sub(picture.spp)), Some(f64::from(n))),
        Budget::Error(target) => {
            let done = picture.spp >= MIN_SPP_FOR_ERROR && picture.relative_error() <= target;
            (if done { 0 } else { room }, None)
        }
        Budget::Time(_) if picture.spp == 0 => (1, None),
        Budget::Time(limit) => {
            let spent = start.elapsed().as_secs_f64();
            let per_sample = spent / f64::from(picture.spp);
            let left = limit.as_secs_f64() - spent;
            // Half of what seems possible at a time, so that a wrong guess can be mended.
            let affordable = (left / per_sample).floor();
            let pass = if affordable < 2.0 { affordable } else { (affordable / 2.0).ceil() };
            ((pass.max(0.0) as u32).min(room), Some(f64::from(picture.spp) + affordable.max(1.0)))
        }
    };
    (pass > 0).then_some((pass, end))
}
