//! Radiance that arrives at a record: a path whose Lambertian surfaces are answered by the irradiance cache.

use super::diffuse::interpolated;
use crate::bsdf::{Bsdf, Split};
use crate::cache::Cache;
use crate::color::mean_radiance;
use crate::hemisphere::Incident;
use crate::integrator::direct::{Emitter, Left, emission, environment, receiver};
use crate::integrator::media::Media;
use crate::light::Lights;
use crate::ray::Ray;
use crate::record::irradiance::IrradianceRecord;
use crate::sampler::Sampler;
use crate::scene::{Environment, Rgb};
use crate::world::{Interaction, Queries, World};
use glam::{Vec2, Vec3A};

/// Of the radius of the zones that answer, the least length of a ray that they may answer: where the ray comes from is a surface
/// that they may not know (as where a thin thing hangs below a ceiling).
const NEAR: f32 = 0.25;

/// Follows paths from records.
#[derive(Clone, Copy)]
pub struct IncidentTracer<'a> {
    /// The scene.
    pub world: &'a World,
    /// Irradiance that ends paths, if there is any yet. It must hold light of paths two segments shorter than the whole.
    pub irradiance: Option<&'a Cache<IrradianceRecord>>,
    /// Light from infinity that records hold: it counts along the first ray too.
    pub environment: Option<&'a Environment>,
    /// Segments left, the first ray of the path included.
    pub max_segments: u32,
    /// Segments after which Russian roulette may end a path.
    pub rr_depth: u32,
}

impl IncidentTracer<'_> {
    /// Light along a ray that is reflected at least once where the ray ends; what emitters send along the ray itself belongs
    /// to direct light, and so does the environment but for the part that records hold.
    #[inline(always)]
    pub fn incident(&self, ray: Ray, sampler: &mut Sampler, queries: &mut Queries) -> Incident {
        let world = self.world;
        queries.counts.paths += 1;
        let mut found = Incident { radiance: Rgb::ZERO, distance: f32::INFINITY, normal: Vec3A::ZERO };
        let (mut ray, mut throughput, mut eta) = (ray, Rgb::ONE, 1.0);
        let mut left: Option<Left> = None;
        let mut media = Media::NONE;
        // Length of the path while nothing but mirrors turned it: what a mirror shows lies behind it.
        let mut straight = Some(0.0);
        for segment in 1..=self.max_segments {
            let hit = queries.intersect(world, &ray);
            if !hit.exists() {
                if straight.is_some() {
                    found.distance = f32::INFINITY;
                }
                if segment == 1 {
                    found.radiance = self.environment.map_or(Rgb::ZERO, |e| e.radiance(ray.direction));
                } else {
                    let (light, weight) = environment(&world.lights, ray.direction, left.as_ref());
                    found.radiance += throughput * (light * weight);
                }
                break;
            }
            let at = world.interaction(&ray, &hit);
            if let Some(length) = &mut straight {
                *length += hit.t;
                found.distance = *length;
            }
            if segment == 1 {
                found.normal = at.normal * 1f32.copysign(at.normal.dot(at.wo));
            } else {
                let (light, weight) = emission(world, &world.lights, &at, left.as_ref());
                found.radiance += throughput * media.left(at.distance) * (light * weight);
            }
            if segment == self.max_segments {
                break;
            }
            let bsdf = world.bsdf(&at);
            throughput *= media.left_before(world, &at, &bsdf);
            let [choice, on_light, scattering, roulette] = sampler.next_4x2d(&mut queries.scrambles);
            // The Lambertian part is in the cache; only the rest needs another ray.
            let cached = bsdf.parts().and_then(|parts| {
                let found = interpolated(self.irradiance?, at.p, bsdf.normal(), bsdf.normal())?;
                (hit.t > NEAR * found.radius).then_some((parts, found.irradiance))
            });
            found.radiance += throughput
                * sample_light(world, &world.lights, &at, &bsdf, cached.is_some(), choice.x, on_light, queries).sum();
            if let Some((parts, irradiance)) = cached {
                found.radiance += throughput * parts.diffuse * mean_radiance(irradiance);
                if parts.is_diffuse() {
                    break;
                }
            }
            let Some(sample) = bsdf.sample(choice.y, scattering) else { break };
            throughput *= if cached.is_some() { sample.weight.glossy } else { sample.weight.sum() };
            eta *= sample.eta;
            media.pass(world, &at, &bsdf, sample.wi);
            if !sample.is_delta() {
                straight = None;
            }
            left = (!sample.is_delta()).then(|| Left { receiver: receiver(&at, &bsdf), pdf: sample.pdf });
            let mut survival = throughput.max_element();
            if segment + 1 >= self.rr_depth {
                survival = (survival * eta * eta).min(0.95);
                if roulette.x >= survival {
                    break;
                }
                throughput /= survival;
            }
            if survival <= 0.0 {
                break;
            }
            ray = at.spawn(sample.wi);
        }
        if !found.radiance.is_finite() {
            queries.counts.not_finite += 1;
            found.radiance = Rgb::ZERO;
        }
        found
    }
}

/// Light of one sampled emitter of `lights`, reflected. `choice` and `u` choose the emitter and the place on it. With
/// `diffuse_alone` no BSDF sample will look for the light that the Lambertian part reflects.
#[inline]
#[allow(clippy::too_many_arguments)]
pub fn sample_light(
    world: &World,
    lights: &Lights,
    at: &Interaction,
    bsdf: &Bsdf,
    diffuse_alone: bool,
    choice: f32,
    u: Vec2,
    queries: &mut Queries,
) -> Split {
    if bsdf.is_delta() {
        return Split::ZERO;
    }
    let Some(emitter) = Emitter::sample(world, lights, bsdf, &receiver(at, bsdf), choice, u) else {
        return Split::ZERO;
    };
    let weighted = |f: Rgb, mis: f32| f * emitter.light.radiance * emitter.factor(mis);
    let f = emitter.value.f;
    let diffuse = weighted(f.diffuse, if diffuse_alone { 1.0 } else { emitter.mis });
    let reflected = Split { diffuse, glossy: weighted(f.glossy, emitter.mis) };
    emitter.in_sight(world, at, reflected.sum(), queries).map_or(Split::ZERO, |_| reflected)
}
