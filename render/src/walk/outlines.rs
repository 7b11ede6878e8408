//! Outlines of lamps: pixels in which directly seen emission begins or ends take more camera rays.
//!
//! A lamp is tens to thousands of times as bright as what is beside it. With few samples the share of a pixel that it covers is
//! a guess, and no denoiser mends it: lamps are not denoised. From frame to frame such outlines flicker more than all the rest of
//! a picture. A ray that asks only for emission costs little, and few pixels need it.

use crate::camera::RayGenerator;
use crate::integrator::direct::{emission, environment};
use crate::picture::Picture;
use crate::sampler::Sampler;
use crate::scene::Rgb;
use crate::world::{Counts, Queries, World};
use rayon::prelude::*;

/// Camera rays of a pixel at an outline.
const SAMPLES: u32 = 64;
/// Difference of the emission of neighbouring pixels that makes an outline, over the larger one.
const STEP: f32 = 0.3;

/// Takes the emission that pixels at outlines see from more camera rays, the first of which are those that the picture has.
pub(super) fn refine(world: &World, picture: &mut Picture, seed: u64) {
    if picture.spp >= SAMPLES {
        return;
    }
    let (width, height) = (picture.width as usize, picture.height as usize);
    let seen: Vec<Rgb> = picture.pixels.iter().map(|p| p.sum().emission).collect();
    let is_step = |a: Rgb, b: Rgb| (a - b).abs().max_element() > STEP * a.max(b).max_element();
    let at_outline = |i: &usize| {
        let (x, y) = (i % width, i / width);
        let (columns, rows) =
            (x.saturating_sub(1)..=(x + 1).min(width - 1), y.saturating_sub(1)..=(y + 1).min(height - 1));
        rows.flat_map(|y| columns.clone().map(move |x| y * width + x)).any(|j| is_step(seen[*i], seen[j]))
    };
    let outline: Vec<usize> = (0..width * height).into_par_iter().filter(at_outline).collect();
    let camera = RayGenerator::new(&world.scene.camera);
    let [left, top] = picture.corner;
    let refined: Vec<(Rgb, Counts)> = outline
        .par_iter()
        .map(|i| {
            let at = (left + (i % width) as u32, top + (i / width) as u32);
            let mut queries = Queries::default();
            let sum: Rgb = (0..SAMPLES).map(|index| emitted(world, &camera, at, seed, index, &mut queries)).sum();
            (sum / SAMPLES as f32, queries.counts)
        })
        .collect();
    for (i, (mean, counts)) in outline.into_iter().zip(refined) {
        let mut sum = picture.pixels[i].sum();
        sum.emission = mean * picture.spp as f32;
        picture.pixels[i].set_sum(&sum);
        picture.counts += counts;
    }
}

/// Emission that a sample of a pixel sees directly.
fn emitted(world: &World, camera: &RayGenerator, at: (u32, u32), seed: u64, index: u32, queries: &mut Queries) -> Rgb {
    let settings = &world.scene.integrator;
    let mut sampler = Sampler::new(seed, at, index);
    let ray = camera.sample(at.0, at.1, &mut sampler);
    let hit = queries.intersect(world, &ray);
    let light = if settings.hide_emitters {
        Rgb::ZERO
    } else if hit.exists() {
        emission(world, &world.lights, &world.interaction(&ray, &hit), None).0
    } else if settings.hide_environment {
        Rgb::ZERO
    } else {
        environment(&world.lights, ray.direction, None).0
    };
    if light.is_finite() { light } else { Rgb::ZERO }
}
