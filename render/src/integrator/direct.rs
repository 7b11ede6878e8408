//! Light that is scattered once, by light sampling and BSDF sampling combined: for the path tracer, for the pixels of the caches
//! and for the paths that fill them. The path tracer's readable twin ([`super::SimplePathTracer`]) alone has its own: it is a
//! check on this.

use crate::bsdf::{Bsdf, Value};
use crate::light::{LightSample, LightSampleContext, Lights, Target, power_heuristic};
use crate::scene::Rgb;
use crate::world::{Interaction, Queries, World};
use glam::{Vec2, Vec3A};

/// The surface as the lights see it.
#[inline(always)]
pub fn receiver(at: &Interaction, bsdf: &Bsdf) -> LightSampleContext {
    LightSampleContext { p: at.p, normal: bsdf.normal(), one_sided: bsdf.only_reflects() }
}

/// A sampled emitter and what a surface makes of its light, whether or not it is in sight.
#[derive(Clone, Copy, Debug)]
pub struct Emitter {
    /// The light.
    pub light: LightSample,
    /// The BSDF for its direction.
    pub value: Value,
    /// Weight of light sampling, where sampling of the BSDF looks for the same light.
    pub mis: f32,
    cos: f32,
}

impl Emitter {
    /// Samples one emitter of `lights`, which may be a part of the world's: `choice` chooses it, `u` the place on it.
    #[inline(always)]
    pub fn sample(
        world: &World,
        lights: &Lights,
        bsdf: &Bsdf,
        receiver: &LightSampleContext,
        choice: f32,
        u: Vec2,
    ) -> Option<Self> {
        let light = lights.sample(&world.scene.textures, receiver, choice, u)?;
        let value = bsdf.eval(light.wi);
        let mis = if light.delta { 1.0 } else { power_heuristic(light.pdf, value.pdf) };
        Some(Self { light, value, mis, cos: bsdf.abs_cos(light.wi) })
    }

    /// Factor on f_r times radiance, for this weight of light sampling.
    #[inline(always)]
    pub fn factor(&self, mis: f32) -> f32 {
        self.cos * mis / self.light.pdf
    }

    /// Distance to the emitter, if what the surface would reflect of it is not nothing and a shadow ray finds it in sight.
    #[inline(always)]
    pub fn in_sight(&self, world: &World, at: &Interaction, reflected: Rgb, queries: &mut Queries) -> Option<f32> {
        if reflected.max_element() <= 0.0 {
            return None;
        }
        let shadow = match self.light.target {
            Target::Point { p, clearance } => at.spawn_to(p, clearance),
            Target::Direction(d) => at.spawn(d),
        };
        let distance = || (shadow.t_max * shadow.direction.length()).min(f32::MAX);
        (!queries.occluded(world, &shadow)).then(distance)
    }
}

/// A surface that a path left in a direction which light sampling could have found.
#[derive(Clone, Copy, Debug)]
pub struct Left {
    /// The surface.
    pub receiver: LightSampleContext,
    /// Density of the direction in sr⁻¹.
    pub pdf: f32,
}

/// Emission of a surface that a path meets, and the weight of the path: 1 from the eye or a mirror, which leave nothing to light
/// sampling.
#[inline(always)]
pub fn emission(world: &World, lights: &Lights, at: &Interaction, left: Option<&Left>) -> (Rgb, f32) {
    let Some(emitter) = at.emitter else { return (Rgb::ZERO, 1.0) };
    let cos = at.normal.dot(at.wo);
    if cos <= 0.0 {
        return (Rgb::ZERO, 1.0);
    }
    let light = lights.emitted(&world.scene.textures, emitter, &at.coordinates);
    let weight = left.map_or(1.0, |left| {
        let distance = (at.p - left.receiver.p).length();
        power_heuristic(left.pdf, lights.pdf(&left.receiver, emitter, distance, cos))
    });
    (light, weight)
}

/// Light from infinity along a direction that meets nothing, and the weight of the path, as for [`emission`].
#[inline(always)]
pub fn environment(lights: &Lights, direction: Vec3A, left: Option<&Left>) -> (Rgb, f32) {
    match left {
        Some(left) => {
            let (light, pdf) = lights.environment_with_pdf(&left.receiver, direction);
            (light, power_heuristic(left.pdf, pdf))
        }
        None => (lights.environment(direction), 1.0),
    }
}
