//! Paths sixteen at a time: what all surfaces have in common is computed in lanes.
//!
//! A block holds sixteen paths, each at its own bounce; one that ends makes room for the next, so that the lanes stay full. A step
//! follows all rays, finds the surfaces, scatters at those whose model the lanes know (`scatter`), and asks for what is in
//! sight. Glass, mirrors and the like go through the twin's [`PathTracer::leave`]. All that a path does is a function of its own
//! start, so the picture is the same however paths meet.

mod columns;
mod lanes;
mod model;
mod scatter;
#[cfg(all(test, feature = "formats"))]
mod tests;

use super::path::{Path, PathTracer};
use super::{Radiance, Start, direct};
use crate::bsdf::Sample;
use crate::light::LightSampleContext;
use crate::ray::{Hit, Ray};
use crate::sampler::Samplers;
use crate::world::{Queries, World};
use columns::{Light, Scattered, Surfaces, get, split};
use fearless_simd::{Level, dispatch};
use glam::{Vec2, Vec3A};
use lanes::LANES;

/// A path of a block.
struct Lane {
    path: Path,
    ray: Ray,
    /// Index of its start; `None` where the lane is idle.
    index: Option<usize>,
    receiver: LightSampleContext,
}

impl Lane {
    const IDLE: Self = Self {
        path: Path::START,
        ray: Ray { origin: Vec3A::ZERO, direction: Vec3A::Z, t_min: 0.0, t_max: 0.0 },
        index: None,
        receiver: LightSampleContext { p: Vec3A::ZERO, normal: Vec3A::Z, one_sided: true },
    };
}

/// Sixteen paths.
struct Block<'w> {
    lanes: [Lane; LANES],
    samplers: Samplers,
    surfaces: Surfaces<'w>,
    light: Light,
    scattered: Scattered,
}

/// [`super::Integrator::radiances`] of the path tracer.
#[inline(always)]
pub(super) fn radiances(
    tracer: &PathTracer,
    world: &World,
    starts: &[Start],
    queries: &mut Queries,
    out: &mut Vec<Radiance>,
) {
    radiances_by(Level::new(), tracer, world, starts, queries, out);
}

/// The same by instructions of this level.
#[inline(always)]
fn radiances_by(
    level: Level,
    tracer: &PathTracer,
    world: &World,
    starts: &[Start],
    queries: &mut Queries,
    out: &mut Vec<Radiance>,
) {
    out.clear();
    out.resize(starts.len(), Radiance::NONE);
    if tracer.settings.max_depth == 0 {
        return;
    }
    let mut block = Block {
        lanes: [const { Lane::IDLE }; LANES],
        samplers: Samplers::default(),
        surfaces: Surfaces::default(),
        light: Light::default(),
        scattered: Scattered::default(),
    };
    let mut waiting = starts.iter().enumerate();
    loop {
        // Idle lanes take the next paths.
        for (i, lane) in block.lanes.iter_mut().enumerate() {
            if lane.index.is_none()
                && let Some((index, start)) = waiting.next()
            {
                *lane = Lane { ray: start.ray, index: Some(index), ..Lane::IDLE };
                block.samplers.set(i, &start.sampler);
            }
        }
        if block.lanes.iter().all(|lane| lane.index.is_none()) {
            return;
        }
        step(tracer, world, level, &mut block, queries, out);
    }
}

/// One more segment of every path; those that end write what they found to `out`.
#[inline(always)]
fn step<'w>(
    tracer: &PathTracer,
    world: &'w World,
    level: Level,
    block: &mut Block<'w>,
    queries: &mut Queries,
    out: &mut [Radiance],
) {
    let Block { lanes, samplers, surfaces, light, scattered } = block;
    let hits = lanes.each_ref().map(|lane| match lane.index {
        Some(_) => queries.intersect(world, &lane.ray),
        None => Hit::NONE,
    });
    let points = dispatch!(level, simd => samplers.next_4x2d(simd));
    let point = |pair: usize, i: usize| Vec2::new(points[pair][i], points[4 + pair][i]);

    // What the lanes know waits in columns, by bit in `wide`; the rest goes on at once.
    let mut wide = 0u32;
    surfaces.clear();
    light.clear();
    for (i, (lane, hit)) in lanes.iter_mut().zip(&hits).enumerate() {
        let Some(index) = lane.index else { continue };
        let path = &mut lane.path;
        let Some((at, bsdf)) = tracer.arrive(world, path, &lane.ray, hit) else {
            out[index] = path.out;
            lane.index = None;
            continue;
        };
        match bsdf.in_lanes() {
            Some(model) if path.media.is_none() => {
                surfaces.set(i, &at, &bsdf, &model);
                lane.receiver = direct::receiver(&at, &bsdf);
                wide |= 1 << i;
                if tracer.wants_light(path)
                    && let Some(choice) = world.lights.choose(&lane.receiver, points[0][i])
                {
                    let flat = choice.local
                        && light.set_lamp(i, choice.index, choice.probability, || world.lights.flat(&choice));
                    let textures = &world.scene.textures;
                    if !flat
                        && let Some(sample) = world.lights.sample_chosen(textures, &lane.receiver, choice, point(1, i))
                    {
                        light.set_sample(i, &sample);
                    }
                }
            }
            _ => {
                let points = core::array::from_fn(|pair| point(pair, i));
                match tracer.leave(world, path, (&at, &bsdf), points, queries) {
                    Some(ray) => lane.ray = ray,
                    None => {
                        out[index] = path.out;
                        lane.index = None;
                    }
                }
            }
        }
    }
    if wide == 0 {
        return;
    }
    dispatch!(level, simd => scatter::scatter(simd, surfaces, light, &points, scattered));
    let lit = (light.lamps | light.samples) & scattered.lit;
    for (i, lane) in lanes.iter_mut().enumerate() {
        let (Some(index), true) = (lane.index, wide >> i & 1 != 0) else { continue };
        let path = &mut lane.path;
        if lit >> i & 1 != 0 {
            let reflected = split(&scattered.reflected, i) * path.throughput;
            let shadow = Ray {
                origin: get(&scattered.shadow_origin, i),
                direction: get(&scattered.shadow_direction, i),
                t_min: 0.0,
                t_max: scattered.shadow_end[i],
            };
            if reflected.sum().max_element() > 0.0 && !queries.occluded(world, &shadow) {
                path.add_reflected(reflected);
            }
        }
        let sample =
            Sample { wi: get(&scattered.wi, i), weight: split(&scattered.weight, i), pdf: scattered.pdf[i], eta: 1.0 };
        if scattered.sampled >> i & 1 != 0 && tracer.goes_on(path, &sample, lane.receiver, points[3][i]) {
            lane.ray = Ray::new(get(&scattered.origin, i), sample.wi);
        } else {
            out[index] = path.out;
            lane.index = None;
        }
    }
}
