//! Sampling of emitters: which light, then where on it.

mod area;
mod environment;
mod sphere;
mod split;
mod tree;
mod wide;

use crate::frame::{cosine_hemisphere, uniform_sphere};
use crate::scene::{self, Coordinates, Environment, Falloff, Geometry, Opacity, Rgb, Scene, Texture};
pub(crate) use area::FlatLamp;
use area::Surface;
use core::f32::consts::{FRAC_1_PI, PI};
use environment::{MapSampler, Place};
use glam::{Vec2, Vec3A};
use tree::LightBounds;
use wide::LightTree;

/// The point that receives light, as sampling of lights sees it.
#[derive(Clone, Copy, Debug)]
pub struct LightSampleContext {
    /// Position.
    pub p: Vec3A,
    /// Unit shading normal.
    pub normal: Vec3A,
    /// Whether only light from the side of `normal` counts.
    pub one_sided: bool,
}

/// Where a shadow ray ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Target {
    /// At a point, which rounding may have put as far as `clearance` behind the lamp's own surface.
    Point { p: Vec3A, clearance: f32 },
    /// At infinity, in this unit direction.
    Direction(Vec3A),
}

/// A sampled direction towards a light.
#[derive(Clone, Copy, Debug)]
pub struct LightSample {
    /// Unit direction to the light.
    pub wi: Vec3A,
    /// Where the shadow ray ends.
    pub target: Target,
    /// Incident radiance, visibility aside; for a delta light the irradiance facing it.
    pub radiance: Rgb,
    /// Density in sr⁻¹, choice of the light included; for a delta light the probability of the choice.
    pub pdf: f32,
    /// Whether the light is met by no other way of sampling.
    pub delta: bool,
}

/// Weight of a sample of density `a` when density `b` could have found it too (Veach 1997).
#[inline]
pub fn power_heuristic(a: f32, b: f32) -> f32 {
    let (a2, b2) = (a * a, b * b);
    let sum = a2 + b2;
    // Where squares overflow or vanish, the larger takes all.
    if sum > 0.0 && a2 < f32::INFINITY { a2 / sum } else { f32::from(u8::from(a >= b)) }
}

/// Emitters of a shape: one for all of it, or one per triangle.
#[derive(Clone, Copy, Debug)]
pub struct FirstEmitter {
    base: u32,
    per_triangle: bool,
}

impl FirstEmitter {
    /// The emitter that triangle `index` of the shape belongs to.
    #[inline]
    pub fn of_triangle(self, index: u32) -> u32 {
        if self.per_triangle { self.base + index } else { self.base }
    }
}

/// A light chosen for a receiver.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Choice {
    /// Number among those with a place, or among those at infinity.
    pub index: usize,
    /// Whether the light has a place.
    pub local: bool,
    /// Probability of the choice.
    pub probability: f32,
}

/// Where on a chosen light, as far as that is known before the memory answers.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Begun {
    u: Vec2,
    /// Of a map of the environment.
    place: Place,
}

/// A light with a place.
#[derive(Clone, Debug)]
enum Local {
    Surface(Surface),
    Point { position: Vec3A, intensity: Rgb },
    Spot { position: Vec3A, direction: Vec3A, intensity: Rgb, beam: f32, cutoff: f32, falloff: Falloff },
}

/// All lights of a scene.
#[derive(Clone, Debug)]
pub struct Lights {
    local: Vec<Local>,
    tree: LightTree,
    /// Directional lights: unit direction of travel, irradiance.
    directional: Vec<(Vec3A, Rgb)>,
    environment: Option<(Environment, Option<MapSampler>)>,
}

impl Lights {
    /// Collects the lights of a scene; also returns the emitters of each of its shapes.
    pub fn new(scene: &Scene) -> (Self, Vec<Option<FirstEmitter>>) {
        let (mut local, mut bounds, mut directional) = (Vec::new(), Vec::new(), Vec::new());
        let mut first_emitter = Vec::with_capacity(scene.shapes.len());
        for shape in &scene.shapes {
            let Some(emitter) = &shape.emitter else {
                first_emitter.push(None);
                continue;
            };
            let opacity = Opacity::of(scene, shape.material);
            let surfaces = match &shape.geometry {
                Geometry::Mesh(mesh) => Surface::of_mesh(mesh, emitter, opacity.as_ref(), &scene.textures),
                Geometry::Sphere(s) => vec![Surface::sphere(*s, emitter, opacity.as_ref(), &scene.textures)],
            };
            let per_triangle = matches!(&shape.geometry, Geometry::Mesh(m) if m.triangles.len() == surfaces.len());
            first_emitter
                .push((!surfaces.is_empty()).then_some(FirstEmitter { base: local.len() as u32, per_triangle }));
            bounds.extend(surfaces.iter().map(Surface::bounds));
            local.extend(surfaces.into_iter().map(Local::Surface));
        }
        for light in &scene.lights {
            match *light {
                scene::Light::Directional { direction, irradiance } => directional.push((direction, irradiance)),
                scene::Light::Point { position, intensity } => {
                    bounds.push(LightBounds::at_point(position, 4.0 * PI * mean(intensity), Vec3A::Z, -1.0, 0.0));
                    local.push(Local::Point { position, intensity });
                }
                scene::Light::Spot { position, direction, intensity, beam, cutoff, falloff } => {
                    // The power is bounded as if the whole cone had the full intensity; the cone holds every direction.
                    let power = 2.0 * PI * (1.0 - cutoff.cos()) * mean(intensity);
                    bounds.push(LightBounds::at_point(position, power, direction, 1.0, cutoff.cos()));
                    local.push(Local::Spot { position, direction, intensity, beam, cutoff, falloff });
                }
            }
        }
        let environment = scene.environment.as_ref().map(|e| {
            let sampler = match e {
                Environment::Constant(_) => None,
                Environment::Map(map) => Some(MapSampler::new(map)),
            };
            (e.clone(), sampler)
        });
        (Self { local, tree: LightTree::new(&bounds), directional, environment }, first_emitter)
    }

    /// Whether there is nothing to sample.
    pub fn is_empty(&self) -> bool {
        self.local.is_empty() && self.infinite_count() == 0
    }

    /// Number of lights, the environment counted as one.
    pub fn count(&self) -> usize {
        self.local.len() + self.infinite_count()
    }

    fn infinite_count(&self) -> usize {
        self.directional.len() + usize::from(self.environment.is_some())
    }

    /// Probability of each light at infinity; the tree has the same share as one of them.
    #[inline]
    fn infinite_probability(&self) -> f32 {
        1.0 / (self.infinite_count() + usize::from(!self.local.is_empty())) as f32
    }

    /// Samples the light that reaches `receiver`: `u_choice` chooses the light, `u` the place on it.
    #[inline(always)]
    pub fn sample(
        &self,
        textures: &[Texture],
        receiver: &LightSampleContext,
        u_choice: f32,
        u: Vec2,
    ) -> Option<LightSample> {
        let choice = self.choose(receiver, u_choice)?;
        self.sample_chosen(textures, receiver, choice, &self.begin(&choice, u))
    }

    /// Chooses the light for [`Lights::sample`].
    #[inline(always)]
    pub(crate) fn choose(&self, receiver: &LightSampleContext, u_choice: f32) -> Option<Choice> {
        let mut u_choice = u_choice;
        let mut tree_probability = 1.0;
        let infinite = self.infinite_count();
        if infinite > 0 {
            let each = self.infinite_probability();
            let index = (u_choice / each) as usize;
            if index < infinite {
                return Some(Choice { index, local: false, probability: each });
            }
            tree_probability = each;
            u_choice = ((u_choice - infinite as f32 * each) / each).clamp(0.0, 1.0 - f32::EPSILON);
        }
        let (index, probability) = self.tree.sample(receiver, u_choice)?;
        Some(Choice { index: index as usize, local: true, probability: tree_probability * probability })
    }

    /// Begins to sample a direction to the light that was chosen: whoever has many to sample begins them all, and waits for the memory
    /// once.
    #[inline(always)]
    pub(crate) fn begin(&self, choice: &Choice, u: Vec2) -> Begun {
        let place = match &self.environment {
            Some((Environment::Map(_), Some(map))) if !choice.local && choice.index >= self.directional.len() => {
                map.place(u)
            }
            _ => Place::default(),
        };
        Begun { u, place }
    }

    /// Samples a direction to the light that was chosen.
    #[inline(always)]
    pub(crate) fn sample_chosen(
        &self,
        textures: &[Texture],
        receiver: &LightSampleContext,
        Choice { index, local, probability }: Choice,
        begun: &Begun,
    ) -> Option<LightSample> {
        if local {
            self.sample_local(textures, receiver, index, probability, begun.u)
        } else {
            Some(self.sample_infinite(receiver, index, probability, begun)).filter(|s| s.pdf > 0.0)
        }
    }

    /// The light that was chosen, if it is an even flat lamp.
    #[inline(always)]
    pub(crate) fn flat(&self, choice: &Choice) -> Option<FlatLamp> {
        if !choice.local {
            return None;
        }
        if let Local::Surface(surface) = &self.local[choice.index] { surface.flat() } else { None }
    }

    /// Samples light number `index` (locals first), chosen with `probability`: the plain way, used by the twin of the
    /// path tracer.
    pub fn sample_one(
        &self,
        textures: &[Texture],
        receiver: &LightSampleContext,
        index: usize,
        probability: f32,
        u: Vec2,
    ) -> Option<LightSample> {
        match index.checked_sub(self.local.len()) {
            None => self.sample_local(textures, receiver, index, probability, u),
            Some(infinite) => {
                let choice = Choice { index: infinite, local: false, probability };
                self.sample_chosen(textures, receiver, choice, &self.begin(&choice, u))
            }
        }
    }

    #[inline(always)]
    fn sample_local(
        &self,
        textures: &[Texture],
        receiver: &LightSampleContext,
        index: usize,
        probability: f32,
        u: Vec2,
    ) -> Option<LightSample> {
        let (position, intensity) = match &self.local[index] {
            Local::Surface(surface) => return surface.sample(textures, receiver.p, probability, u),
            Local::Point { position, intensity } => (*position, *intensity),
            Local::Spot { position, direction, intensity, beam, cutoff, falloff } => {
                let angle = (receiver.p - position).angle_between(*direction);
                (*position, *intensity * falloff.share(angle, *beam, *cutoff))
            }
        };
        let to_light = position - receiver.p;
        let distance2 = to_light.length_squared();
        let radiance = intensity / distance2;
        // At the light itself there is no direction, and so near that the square vanishes there is no number.
        (distance2 >= f32::MIN_POSITIVE && radiance.is_finite() && radiance.max_element() > 0.0).then(|| LightSample {
            wi: to_light / distance2.sqrt(),
            target: Target::Point { p: position, clearance: 0.0 },
            radiance,
            pdf: probability,
            delta: true,
        })
    }

    #[inline(always)]
    fn sample_infinite(
        &self,
        receiver: &LightSampleContext,
        index: usize,
        probability: f32,
        &Begun { u, place }: &Begun,
    ) -> LightSample {
        if let Some(&(direction, irradiance)) = self.directional.get(index) {
            let wi = -direction;
            return LightSample {
                wi,
                target: Target::Direction(wi),
                radiance: irradiance,
                pdf: probability,
                delta: true,
            };
        }
        let (wi, pdf, radiance) = match &self.environment {
            Some((Environment::Map(map), Some(sampler))) => sampler.sample(map, &place),
            Some((Environment::Constant(radiance), _)) if receiver.one_sided => {
                let local = cosine_hemisphere(u);
                (crate::frame::Frame::from_normal(receiver.normal).to_world(local), local.z * FRAC_1_PI, *radiance)
            }
            Some((Environment::Constant(radiance), _)) => (uniform_sphere(u), 0.25 * FRAC_1_PI, *radiance),
            _ => (Vec3A::Z, 0.0, Rgb::ZERO),
        };
        LightSample { wi, target: Target::Direction(wi), radiance, pdf: pdf * probability, delta: false }
    }

    /// Radiance that emitter `emitter` sends from a point to its front.
    #[inline(always)]
    pub fn emitted(&self, textures: &[Texture], emitter: u32, at: &Coordinates) -> Rgb {
        match &self.local[emitter as usize] {
            Local::Surface(surface) => surface.radiance.eval(textures, at),
            Local::Point { .. } | Local::Spot { .. } => Rgb::ZERO,
        }
    }

    /// Density in sr⁻¹ with which [`Lights::sample`] chooses the direction to a point of `emitter` at distance
    /// `distance`, seen under the cosine `cos` from its normal.
    #[inline(always)]
    pub fn pdf(&self, receiver: &LightSampleContext, emitter: u32, distance: f32, cos: f32) -> f32 {
        let Local::Surface(surface) = &self.local[emitter as usize] else { return 0.0 };
        let share = if self.infinite_count() > 0 { self.infinite_probability() } else { 1.0 };
        share * self.tree.probability(receiver, emitter) * surface.pdf(receiver.p, distance, cos)
    }

    /// Radiance from infinity in the unit direction `d`, directional lights aside.
    #[inline(always)]
    pub fn environment(&self, d: Vec3A) -> Rgb {
        self.environment.as_ref().map_or(Rgb::ZERO, |(environment, _)| environment.radiance(d))
    }

    /// [`Lights::environment`], and the density in sr⁻¹ with which [`Lights::sample`] chooses the direction `d` to it.
    #[inline(always)]
    pub fn environment_with_pdf(&self, receiver: &LightSampleContext, d: Vec3A) -> (Rgb, f32) {
        let (radiance, density) = match &self.environment {
            None => return (Rgb::ZERO, 0.0),
            Some((Environment::Map(map), Some(sampler))) => sampler.look_up(map, d),
            Some(_) if receiver.one_sided => (self.environment(d), receiver.normal.dot(d).max(0.0) * FRAC_1_PI),
            Some(_) => (self.environment(d), 0.25 * FRAC_1_PI),
        };
        (radiance, density * self.infinite_probability())
    }
}

fn mean(c: Rgb) -> f32 {
    (c.x + c.y + c.z) / 3.0
}
