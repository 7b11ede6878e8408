//! The path tracer's readable twin: what it computes is plain to see, and the tests hold the real one to it.

use super::media::Media;
use super::{Integrator, Radiance};
use crate::light::{LightSampleContext, Target};
use crate::ray::Ray;
use crate::sampler::Sampler;
use crate::scene::Rgb;
use crate::world::{Queries, World};

/// Path tracing by the rendering equation alone: one light, all being equally likely, at every surface that is not
/// perfectly specular; one direction from the BSDF; emitters met by chance count only where light sampling cannot find
/// them. No multiple importance sampling, no roulette, no layers: all light is in `Radiance::emission`.
#[derive(Clone, Copy, Debug)]
pub struct SimplePathTracer {
    /// Largest number of path segments.
    pub max_depth: u32,
}

impl Integrator for SimplePathTracer {
    fn radiance(&self, world: &World, ray: Ray, sampler: &mut Sampler, queries: &mut Queries) -> Radiance {
        let (lights, textures) = (&world.lights, &world.scene.textures[..]);
        let (mut radiance, mut throughput) = (Rgb::ZERO, Rgb::ONE);
        let mut ray = ray;
        let mut specular = true;
        let mut media = Media::NONE;
        for depth in 1..=self.max_depth {
            // Intersect the ray with the scene; add the environment where it leaves.
            let hit = queries.intersect(world, &ray);
            if !hit.exists() {
                if specular {
                    radiance += throughput * lights.environment(ray.direction);
                }
                break;
            }
            let at = world.interaction(&ray, &hit);

            // Add emission that the last surface could not sample.
            if let Some(emitter) = at.emitter
                && specular
                && at.normal.dot(at.wo) > 0.0
            {
                radiance += throughput * media.left(at.distance) * lights.emitted(textures, emitter, &at.coordinates);
            }
            if depth == self.max_depth {
                break;
            }
            let bsdf = world.bsdf(&at);

            // Absorb what the glass around takes on the way here.
            throughput *= media.left_before(world, &at, &bsdf);

            // Sample direct light from one of all lights.
            specular = bsdf.is_delta();
            let choice = sampler.next_2d();
            let u = sampler.next_2d();
            let receiver = LightSampleContext { p: at.p, normal: bsdf.normal(), one_sided: bsdf.only_reflects() };
            let (index, probability) = ((choice.x * lights.count() as f32) as usize, 1.0 / lights.count() as f32);
            if !specular
                && !lights.is_empty()
                && let Some(light) = lights.sample_one(textures, &receiver, index, probability, u)
            {
                let shadow = match light.target {
                    Target::Point { p, clearance } => at.spawn_to(p, clearance),
                    Target::Direction(d) => at.spawn(d),
                };
                if !queries.occluded(world, &shadow) {
                    let f = bsdf.eval(light.wi).f.sum() * bsdf.abs_cos(light.wi);
                    let length = (shadow.t_max * shadow.direction.length()).min(f32::MAX);
                    let left = media.left_beyond(world, &at, &bsdf, light.wi, length);
                    radiance += throughput * f * left * light.radiance / light.pdf;
                }
            }

            // Sample the BSDF for the next direction.
            let Some(sample) = bsdf.sample(choice.y, sampler.next_2d()) else { break };
            specular = sample.is_delta();
            throughput *= sample.weight.sum();
            media.pass(world, &at, &bsdf, sample.wi);
            ray = at.spawn(sample.wi);
        }
        Radiance { emission: radiance, ..Radiance::default() }
    }
}
