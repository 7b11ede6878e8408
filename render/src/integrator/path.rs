//! The path tracer: the truth the caches are judged by, and their rival. The rays that fill them are those of [`super::cached::IncidentTracer`].

use super::direct::{Emitter, Left, emission, environment, receiver};
use super::media::Media;
use super::{Integrator, Radiance, guides};
use crate::bsdf::{Bsdf, Split};
use crate::light::LightSampleContext;
use crate::ray::Ray;
use crate::sampler::Sampler;
use crate::scene::{IntegratorSettings, Rgb};
use crate::world::{Interaction, Queries, World};
use glam::Vec2;

/// Unidirectional path tracing with next-event estimation, combined with the sampling of the BSDF by the power heuristic
/// (Veach 1997), and Russian roulette.
#[derive(Clone, Copy, Debug)]
pub struct PathTracer {
    /// Path length and roulette.
    pub settings: IntegratorSettings,
    /// Whether light that is scattered less than twice is left out.
    pub indirect_only: bool,
}

/// A path under construction.
struct Path {
    out: Radiance,
    throughput: Rgb,
    /// Part of the throughput that the first surface's diffuse part has.
    diffuse_share: Rgb,
    /// Product of the factors of the index of refraction.
    eta: f32,
    /// `None` from the eye or a perfectly specular surface: emitters count fully.
    left: Option<Left>,
    /// The glasses around it.
    media: Media,
    /// Whether all surfaces so far are perfectly specular: the pixel shows what comes next.
    straight: bool,
}

impl Path {
    /// Adds light that arrives after `segments` segments, already times the throughput.
    #[inline]
    fn add(&mut self, segments: u32, light: Rgb) {
        let split = Split { diffuse: light * self.diffuse_share, glossy: light * (Rgb::ONE - self.diffuse_share) };
        match segments {
            1 => self.out.emission += light,
            2 => self.out.direct = self.out.direct + split,
            _ => self.out.indirect = self.out.indirect + split,
        }
    }
}

impl Integrator for PathTracer {
    #[inline(always)]
    fn radiance(&self, world: &World, ray: Ray, sampler: &mut Sampler, queries: &mut Queries) -> Radiance {
        let mut path = Path {
            out: Radiance::default(),
            throughput: Rgb::ONE,
            diffuse_share: Rgb::ZERO,
            eta: 1.0,
            left: None,
            media: Media::NONE,
            straight: true,
        };
        let mut ray = ray;
        let mut segments = 0;
        while segments < self.settings.max_depth {
            segments += 1;
            // Follow the ray, and add what it meets that shines.
            let hit = queries.intersect(world, &ray);
            let hidden = segments == 1 && self.settings.hide_emitters;
            let counts = !hidden && (segments > 2 || !self.indirect_only);
            if !hit.exists() {
                if counts && !(segments == 1 && self.settings.hide_environment) {
                    let (light, weight) = environment(&world.lights, ray.direction, path.left.as_ref());
                    let light = light * path.throughput * weight;
                    path.add(segments, light);
                    if path.straight && segments > 1 {
                        guides::show_light(&mut path.out, light);
                    }
                }
                break;
            }
            let at = world.interaction(&ray, &hit);
            let bsdf = world.bsdf(&at);
            if segments == 1 {
                path.out.distance = hit.t;
            }
            if path.straight {
                guides::show(&mut path.out, &at, &bsdf, path.throughput);
                path.straight = bsdf.is_delta();
            }
            if at.emitter.is_some() && counts {
                let (light, weight) = emission(world, &world.lights, &at, path.left.as_ref());
                path.add(segments, light * path.throughput * weight * path.media.left(at.distance));
            }
            if segments == self.settings.max_depth {
                break;
            }
            path.throughput *= path.media.left_before(world, &at, &bsdf);
            // Sample the lights.
            let receiver = receiver(&at, &bsdf);
            let [choice, u_light, u_scattering, u_roulette] = sampler.next_4x2d(&mut queries.scrambles);
            if !bsdf.is_delta() && (segments > 1 || !self.indirect_only) {
                sample_lights(world, &at, &bsdf, &receiver, segments, choice.x, u_light, &mut path, queries);
            }
            // Sample the scattering, and go on.
            let Some(sample) = bsdf.sample(choice.y, u_scattering) else { break };
            let weight = sample.weight.sum();
            if segments == 1 {
                path.diffuse_share = (sample.weight.diffuse / weight.max(Rgb::splat(f32::MIN_POSITIVE))).min(Rgb::ONE);
            }
            path.throughput *= weight;
            path.eta *= sample.eta;
            path.media.pass(world, &at, &bsdf, sample.wi);
            path.left = (!sample.is_delta()).then_some(Left { receiver, pdf: sample.pdf });
            // Russian roulette on what the path can still carry.
            let mut survival = path.throughput.max_element();
            if segments >= self.settings.rr_depth {
                survival = (survival * path.eta * path.eta).min(0.95);
                if u_roulette.x >= survival {
                    break;
                }
                path.throughput /= survival;
            }
            if survival <= 0.0 {
                break;
            }
            ray = at.spawn(sample.wi);
        }
        path.out
    }
}

/// Light of one sampled emitter, if it is in sight.
#[inline(always)]
#[allow(clippy::too_many_arguments)]
fn sample_lights(
    world: &World,
    at: &Interaction,
    bsdf: &Bsdf,
    receiver: &LightSampleContext,
    segments: u32,
    choice: f32,
    u: Vec2,
    path: &mut Path,
    queries: &mut Queries,
) {
    let Some(emitter) = Emitter::sample(world, &world.lights, bsdf, receiver, choice, u) else { return };
    let light = &emitter.light;
    let reflected = emitter.value.f * (light.radiance * path.throughput * emitter.factor(emitter.mis));
    let Some(distance) = emitter.in_sight(world, at, reflected.sum(), queries) else { return };
    let reflected = reflected * path.media.left_beyond(world, at, bsdf, light.wi, distance);
    if segments == 1 {
        path.out.direct = path.out.direct + reflected;
    } else {
        path.add(segments + 1, reflected.sum());
    }
}
