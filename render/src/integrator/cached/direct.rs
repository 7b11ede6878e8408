//! Light that is scattered once, by light sampling and BSDF sampling combined; both the pixels and the paths of the gather
//! use it.

use crate::bsdf::{Bsdf, Split};
use crate::light::{Lights, Receiver, Target, power_heuristic};
use crate::scene::Rgb;
use crate::world::{Interaction, Queries, World};
use glam::{Vec2, Vec3A};

/// The surface a path left, for the weight of an emitter that it meets.
#[derive(Clone, Copy, Debug)]
pub struct Left {
    /// The surface.
    pub receiver: Receiver,
    /// Density of the direction in sr⁻¹; `None` for a perfectly specular one, which light sampling cannot find.
    pub pdf: Option<f32>,
}

/// The surface as the lights see it.
pub fn receiver(at: &Interaction, bsdf: &Bsdf) -> Receiver {
    Receiver { p: at.p, normal: bsdf.normal(), one_sided: bsdf.only_reflects() }
}

/// Light of one sampled emitter, reflected; traces one shadow ray. `lights` may be a part of the world's. `choice` and `u`
/// choose the light and the place on it. With `diffuse_alone` no BSDF sample will look for the light that the Lambertian part
/// reflects.
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
    let Some(light) = lights.sample(&world.scene.textures, &receiver(at, bsdf), choice, u) else {
        return Split::ZERO;
    };
    let value = bsdf.eval(light.wi);
    let mis = if light.delta { 1.0 } else { power_heuristic(light.pdf, value.pdf) };
    let weighted = |f: Rgb, mis: f32| f * light.radiance * (bsdf.abs_cos(light.wi) * mis / light.pdf);
    let diffuse = weighted(value.f.diffuse, if diffuse_alone { 1.0 } else { mis });
    let reflected = Split { diffuse, glossy: weighted(value.f.glossy, mis) };
    if reflected.sum().max_element() <= 0.0 {
        return Split::ZERO;
    }
    let shadow = match light.target {
        Target::Point { p, clearance } => at.spawn_to(p, clearance),
        Target::Direction(d) => at.spawn(d),
    };
    if queries.occluded(world, &shadow) { Split::ZERO } else { reflected }
}

/// Emission of a surface that a path meets, weighted.
#[inline]
pub fn emission(world: &World, lights: &Lights, at: &Interaction, left: Option<&Left>) -> Rgb {
    let Some(emitter) = at.emitter else { return Rgb::ZERO };
    let cos = at.normal.dot(at.wo);
    if cos <= 0.0 {
        return Rgb::ZERO;
    }
    let light = lights.emitted(&world.scene.textures, emitter, &at.coordinates);
    match left.and_then(|l| l.pdf.map(|pdf| (l, pdf))) {
        Some((left, pdf)) => {
            let distance = (at.p - left.receiver.p).length();
            light * power_heuristic(pdf, lights.pdf(&left.receiver, emitter, distance, cos))
        }
        None => light,
    }
}

/// Light from infinity along a direction that meets nothing, weighted.
#[inline]
pub fn environment(lights: &Lights, direction: Vec3A, left: Option<&Left>) -> Rgb {
    match left.and_then(|l| l.pdf.map(|pdf| (l, pdf))) {
        Some((left, pdf)) => {
            let (light, light_pdf) = lights.environment_with_pdf(&left.receiver, direction);
            light * power_heuristic(pdf, light_pdf)
        }
        None => lights.environment(direction),
    }
}
