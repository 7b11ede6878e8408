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
use crate::bvh::Lanes;
use crate::light::{Begun, LightSampleContext};
use crate::ray::Ray;
use crate::sampler::Samplers;
use crate::simd::widest;
use crate::world::{Interaction, Queries, World};
use columns::{Light, Scattered, Surfaces, get, split};
use fearless_simd::{Level, dispatch};
use glam::{Vec2, Vec3A};
use lanes::LANES;

/// A path of a block.
struct Lane {
    path: Path,
    /// Index of its start; `None` where the lane is idle.
    index: Option<usize>,
    receiver: LightSampleContext,
}

/// A ray that is not followed.
const NO_RAY: Ray = Ray { origin: Vec3A::ZERO, direction: Vec3A::Z, t_min: 0.0, t_max: 0.0, from_camera: false };

impl Lane {
    const IDLE: Self = Self {
        path: Path::START,
        index: None,
        receiver: LightSampleContext { p: Vec3A::ZERO, normal: Vec3A::Z, one_sided: true },
    };

    /// Writes what the path found, and makes room for another.
    #[inline(always)]
    fn end(&mut self, out: &mut [Radiance]) {
        if let Some(index) = self.index.take() {
            out[index] = self.path.out;
        }
    }
}

/// Sixteen paths.
struct Block<'w> {
    lanes: [Lane; LANES],
    rays: [Ray; LANES],
    samplers: Samplers,
    /// Where the rays end.
    met: [Interaction; LANES],
    surfaces: Surfaces<'w>,
    light: Light,
    scattered: Scattered,
}

/// [`super::Integrator::radiances`] of the path tracer.
pub(super) fn radiances(
    tracer: &PathTracer,
    world: &World,
    starts: &[Start],
    queries: &mut Queries,
    out: &mut Vec<Radiance>,
) {
    let level = Level::new();
    widest(
        level,
        #[inline(always)]
        || radiances_by(level, tracer, world, starts, queries, out),
    );
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
        rays: [NO_RAY; LANES],
        samplers: Samplers::default(),
        met: [Interaction::NOWHERE; LANES],
        surfaces: Surfaces::default(),
        light: Light::default(),
        scattered: Scattered::default(),
    };
    let mut waiting = starts.iter().enumerate();
    loop {
        // Idle lanes take the next paths.
        let mut active = 0;
        for (i, lane) in block.lanes.iter_mut().enumerate() {
            if lane.index.is_none()
                && let Some((index, start)) = waiting.next()
            {
                *lane = Lane { index: Some(index), ..Lane::IDLE };
                block.rays[i] = start.ray;
                block.samplers.set(i, &start.sampler);
            }
            active |= u32::from(lane.index.is_some()) << i;
        }
        if active == 0 {
            return;
        }
        step(tracer, world, level, &mut block, active, queries, out);
    }
}

/// One more segment of every path; those that end write what they found to `out`. Each kind of work is done for all paths before the
/// next: what one of them waits for in memory, the others wait for at the same time.
#[inline(always)]
fn step<'w>(
    tracer: &PathTracer,
    world: &'w World,
    level: Level,
    block: &mut Block<'w>,
    active: u32,
    queries: &mut Queries,
    out: &mut [Radiance],
) {
    let Block { lanes, rays, samplers, met, surfaces, light, scattered } = block;
    let hits = queries.intersect_all(world, rays, active);
    let points = dispatch!(level, simd => samplers.next_4x2d(simd));
    let point = |pair: usize, i: usize| Vec2::new(points[pair][i], points[4 + pair][i]);

    let arrived = hits.iter().enumerate().fold(0, |bits, (i, hit)| bits | u32::from(hit.exists()) << i) & active;
    for i in Lanes(arrived) {
        met[i] = world.interaction(&rays[i], &hits[i]);
        world.fetch_texels(&met[i]);
    }
    for i in Lanes(active & !arrived) {
        tracer.escape(world, &mut lanes[i].path, &rays[i]);
        lanes[i].end(out);
    }
    // What the lanes know waits in columns, by bit in `wide`; the rest goes on at once.
    let mut wide = 0u32;
    surfaces.clear();
    light.clear();
    for i in Lanes(arrived) {
        let (lane, at) = (&mut lanes[i], &met[i]);
        let path = &mut lane.path;
        let Some(bsdf) = tracer.meet(world, path, hits[i].t, at) else {
            lane.end(out);
            continue;
        };
        match bsdf.in_lanes() {
            Some(model) if path.media.is_none() => {
                surfaces.set(i, at, &bsdf, &model);
                lane.receiver = direct::receiver(at, &bsdf);
                wide |= 1 << i;
            }
            _ => {
                let points = core::array::from_fn(|pair| point(pair, i));
                match tracer.leave(world, path, (at, &bsdf), points, queries) {
                    Some(ray) => rays[i] = ray,
                    None => lane.end(out),
                }
            }
        }
    }
    if wide == 0 {
        return;
    }
    let (mut choices, mut begun) = ([None; LANES], [Begun::default(); LANES]);
    for i in Lanes(wide).filter(|&i| tracer.wants_light(&lanes[i].path)) {
        choices[i] = world.lights.choose(&lanes[i].receiver, points[0][i]);
        if let Some(choice) = &choices[i] {
            begun[i] = world.lights.begin(choice, point(1, i));
        }
    }
    for i in Lanes(wide) {
        let (receiver, Some(choice)) = (&lanes[i].receiver, choices[i]) else { continue };
        if !(choice.local && light.set_lamp(i, choice.index, choice.probability, || world.lights.flat(&choice)))
            && let Some(sample) = world.lights.sample_chosen(&world.scene.textures, receiver, choice, &begun[i])
        {
            light.set_sample(i, &sample);
        }
    }
    dispatch!(level, simd => scatter::scatter(simd, surfaces, light, &points, scattered));
    let lit = (light.lamps | light.samples) & scattered.lit;
    let reflected = |i: usize, path: &Path| split(&scattered.reflected, i) * path.throughput;
    let (mut shadows, mut asked) = ([NO_RAY; LANES], 0);
    for i in Lanes(lit).filter(|&i| reflected(i, &lanes[i].path).sum().max_element() > 0.0) {
        asked |= 1 << i;
        let shadow = Ray::new(get(&scattered.shadow_origin, i), get(&scattered.shadow_direction, i));
        shadows[i] = Ray { t_max: scattered.shadow_end[i], ..shadow };
    }
    let in_sight = asked & !queries.occluded_all(world, &shadows, asked);
    for i in Lanes(wide) {
        let lane = &mut lanes[i];
        let path = &mut lane.path;
        if in_sight >> i & 1 != 0 {
            path.add_reflected(reflected(i, path));
        }
        let sample =
            Sample { wi: get(&scattered.wi, i), weight: split(&scattered.weight, i), pdf: scattered.pdf[i], eta: 1.0 };
        if scattered.sampled >> i & 1 != 0 && tracer.goes_on(path, &sample, lane.receiver, points[3][i]) {
            rays[i] = Ray::new(get(&scattered.origin, i), sample.wi);
        } else {
            lane.end(out);
        }
    }
}
