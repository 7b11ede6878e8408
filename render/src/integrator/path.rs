//! The path tracer: the truth the caches are judged by, and their rival. The rays that fill them are those of [`super::cached::IncidentTracer`].

use super::direct::{Emitter, Left, emission, environment, receiver};
use super::media::Media;
use super::{Integrator, Radiance, Start, guides, wave};
use crate::bsdf::{Bsdf, Sample, Split};
use crate::light::LightSampleContext;
use crate::ray::{Hit, Ray};
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
pub(super) struct Path {
    pub out: Radiance,
    pub throughput: Rgb,
    /// Part of the throughput that the first surface's diffuse part has.
    diffuse_share: Rgb,
    /// Product of the factors of the index of refraction.
    eta: f32,
    /// `None` from the eye or a perfectly specular surface: emitters count fully.
    left: Option<Left>,
    /// The glasses around it.
    pub media: Media,
    /// Whether all surfaces so far are perfectly specular: the pixel shows what comes next.
    straight: bool,
    /// Segments so far.
    pub segments: u32,
}

impl Path {
    /// At the eye.
    pub const START: Self = Self {
        out: Radiance::NONE,
        throughput: Rgb::ONE,
        diffuse_share: Rgb::ZERO,
        eta: 1.0,
        left: None,
        media: Media::NONE,
        straight: true,
        segments: 0,
    };

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

    /// Adds light of an emitter that the surface at its end reflects, already times the throughput.
    #[inline(always)]
    pub fn add_reflected(&mut self, reflected: Split) {
        if self.segments == 1 {
            self.out.direct = self.out.direct + reflected;
        } else {
            self.add(self.segments + 1, reflected.sum());
        }
    }
}

impl PathTracer {
    /// Follows a ray to what it met, and adds what shines there; the surface, where the path may go on.
    #[inline(always)]
    fn arrive<'w>(&self, world: &'w World, path: &mut Path, ray: &Ray, hit: &Hit) -> Option<(Interaction, Bsdf<'w>)> {
        if !hit.exists() {
            self.escape(world, path, ray);
            return None;
        }
        let at = world.interaction(ray, hit);
        self.meet(world, path, hit.t, &at).map(|bsdf| (at, bsdf))
    }

    /// Whether what the next segment ends at counts, if it shines.
    #[inline(always)]
    fn counts(&self, segment: u32) -> bool {
        !(segment == 1 && self.settings.hide_emitters) && (segment > 2 || !self.indirect_only)
    }

    /// Ends a path whose ray meets nothing, and adds what shines at infinity.
    #[inline(always)]
    pub(super) fn escape(&self, world: &World, path: &mut Path, ray: &Ray) {
        path.segments += 1;
        let first = path.segments == 1;
        if self.counts(path.segments) && !(first && self.settings.hide_environment) {
            let (light, weight) = environment(&world.lights, ray.direction, path.left.as_ref());
            let light = light * path.throughput * weight;
            path.add(path.segments, light);
            if path.straight && !first {
                guides::show_light(&mut path.out, light);
            }
        }
    }

    /// Adds what shines where a ray ends, at a distance along it; how the surface scatters, where the path may go on.
    #[inline(always)]
    pub(super) fn meet<'w>(
        &self,
        world: &'w World,
        path: &mut Path,
        distance: f32,
        at: &Interaction,
    ) -> Option<Bsdf<'w>> {
        path.segments += 1;
        let bsdf = world.bsdf(at);
        if path.segments == 1 {
            path.out.distance = distance;
        }
        if path.straight {
            guides::show(&mut path.out, at, &bsdf, path.throughput);
            path.straight = bsdf.is_delta();
        }
        if at.emitter.is_some() && self.counts(path.segments) {
            let (light, weight) = emission(world, &world.lights, at, path.left.as_ref());
            path.add(path.segments, light * path.throughput * weight * path.media.left(at.distance));
        }
        if path.segments == self.settings.max_depth {
            return None;
        }
        path.throughput *= path.media.left_before(world, at, &bsdf);
        Some(bsdf)
    }

    /// Whether light that the surface at the end of a path reflects is asked for.
    #[inline(always)]
    pub(super) fn wants_light(&self, path: &Path) -> bool {
        path.segments > 1 || !self.indirect_only
    }

    /// Scatters a path at the surface where it arrived, by the next points of its sampler; the ray on which it goes on.
    #[inline(always)]
    pub(super) fn leave(
        &self,
        world: &World,
        path: &mut Path,
        (at, bsdf): (&Interaction, &Bsdf),
        points: [Vec2; 4],
        queries: &mut Queries,
    ) -> Option<Ray> {
        let [choice, u_light, u_scattering, u_roulette] = points;
        let receiver = receiver(at, bsdf);
        if !bsdf.is_delta() && self.wants_light(path) {
            sample_lights(world, at, bsdf, &receiver, choice.x, u_light, path, queries);
        }
        let sample = bsdf.sample(choice.y, u_scattering)?;
        path.media.pass(world, at, bsdf, sample.wi);
        self.goes_on(path, &sample, receiver, u_roulette.x).then(|| at.spawn(sample.wi))
    }

    /// Whether a path goes on in a sampled direction from `receiver`, decided by Russian roulette on what it can still carry.
    #[inline(always)]
    pub(super) fn goes_on(&self, path: &mut Path, sample: &Sample, receiver: LightSampleContext, u: f32) -> bool {
        let weight = sample.weight.sum();
        if path.segments == 1 {
            path.diffuse_share = (sample.weight.diffuse / weight.max(Rgb::splat(f32::MIN_POSITIVE))).min(Rgb::ONE);
        }
        path.throughput *= weight;
        path.eta *= sample.eta;
        path.left = (!sample.is_delta()).then_some(Left { receiver, pdf: sample.pdf });
        let mut survival = path.throughput.max_element();
        if path.segments >= self.settings.rr_depth {
            survival = (survival * path.eta * path.eta).min(0.95);
            if u >= survival {
                return false;
            }
            path.throughput /= survival;
        }
        survival > 0.0
    }
}

impl PathTracer {
    /// What [`Integrator::radiance`] says of emission that the ray sees directly and of the first surface that is not perfectly
    /// specular, without the light that it scatters.
    #[inline(always)]
    pub fn sight(&self, world: &World, ray: Ray, sampler: &mut Sampler, queries: &mut Queries) -> Radiance {
        let mut path = Path::START;
        let mut next = (self.settings.max_depth > 0).then_some(ray);
        while let Some(ray) = next {
            let hit = queries.intersect(world, &ray);
            let Some((at, bsdf)) = self.arrive(world, &mut path, &ray, &hit).filter(|_| path.straight) else { break };
            let points = sampler.next_4x2d(&mut queries.scrambles);
            next = self.leave(world, &mut path, (&at, &bsdf), points, queries);
        }
        path.out
    }
}

impl Integrator for PathTracer {
    /// One path step by step: the readable twin of [`Integrator::radiances`].
    #[inline(always)]
    fn radiance(&self, world: &World, ray: Ray, sampler: &mut Sampler, queries: &mut Queries) -> Radiance {
        let mut path = Path::START;
        let mut next = (self.settings.max_depth > 0).then_some(ray);
        while let Some(ray) = next {
            let hit = queries.intersect(world, &ray);
            let Some((at, bsdf)) = self.arrive(world, &mut path, &ray, &hit) else { break };
            let points = sampler.next_4x2d(&mut queries.scrambles);
            next = self.leave(world, &mut path, (&at, &bsdf), points, queries);
        }
        path.out
    }

    fn radiances(&self, world: &World, starts: &[Start], queries: &mut Queries, out: &mut Vec<Radiance>) {
        wave::radiances(self, world, starts, queries, out);
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
    choice: f32,
    u: Vec2,
    path: &mut Path,
    queries: &mut Queries,
) {
    let Some(emitter) = Emitter::sample(world, &world.lights, bsdf, receiver, choice, u) else { return };
    let light = &emitter.light;
    let reflected = emitter.value.f * (light.radiance * path.throughput * emitter.factor(emitter.mis));
    let Some(distance) = emitter.in_sight(world, at, reflected.sum(), queries) else { return };
    path.add_reflected(reflected * path.media.left_beyond(world, at, bsdf, light.wi, distance));
}
