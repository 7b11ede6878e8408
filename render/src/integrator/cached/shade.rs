//! From caches to pixels (eas-2015, Algorithm 1, second stage, eq. 17): direct light by many rays per pixel, indirect light
//! once per surface that the pixel shows.

use super::caches::Caches;
use super::diffuse::{Interpolated, interpolated};
use super::incident::{IncidentTracer, sample_light};
use super::indirect::Indirect;
use super::kind::{Found, Shaded};
use super::kinds::{Listed, Scratches, WithKind};
use super::points::{PixelCone, Point, Seen, Walk, see};
use super::policy::{LobeWidth, Policy, Treatment};
use super::reading::{Paths, Reading};
use super::settings::Quality;
use super::split::LightSplit;
use super::surface::{Grouping, Surface, turned};
use crate::bsdf::{Bsdf, Parts, Split};
use crate::cache::Lookup;
use crate::color::mean_radiance;
use crate::integrator::direct::{Left, emission, environment, receiver};
use crate::integrator::guides;
use crate::light::Lights;
use crate::picture::{Radiance, first_half};
use crate::ray::Ray;
use crate::record::Receiver;
use crate::record::irradiance::IrradianceRecord;
use crate::sampler::Sampler;
use crate::scene::{Environment, Rgb};
use crate::world::{Interaction, Queries, World};
use core::ops::Range;
use glam::Vec2;

/// Shades with filled caches, which it only reads.
pub struct Shader<'a> {
    /// The scene.
    pub world: &'a World,
    /// Treatment of the materials.
    pub policy: &'a Policy,
    /// Records.
    pub caches: &'a Caches,
    /// Light that records hold on their own, and the lights without it.
    pub split: &'a LightSplit,
    /// Estimator and weights.
    pub quality: Quality,
    /// Whether light that is scattered less than twice is left out.
    pub indirect_only: bool,
    /// Opening angle of a pixel.
    pub cone: PixelCone,
    /// Which samples of a pixel are shaded as one.
    pub(super) grouping: Grouping,
    /// Which pixels read records.
    pub(super) reading: Reading,
    /// Paths of what records do not hold.
    pub(super) paths: Paths,
}

impl Shader<'_> {
    /// Direct light of one camera ray; notes the surfaces it ends on in `surfaces`, for [`Shader::indirect`]. Where a pixel shows
    /// too many of them, their indirect light too.
    #[inline(always)]
    pub fn direct(
        &self,
        ray: Ray,
        sampler: &mut Sampler,
        surfaces: &mut Vec<Surface>,
        scratch: &mut Scratches,
        queries: &mut Queries,
    ) -> Radiance {
        let mut out = Radiance::default();
        let mut walk = Walk::new(ray);
        let (mut emitted, mut through_mirrors) = (Rgb::ZERO, Rgb::ZERO);
        let seen = self.seen(&mut walk, sampler, queries, (&mut emitted, &mut through_mirrors), |shown| match shown {
            Shown::Surface { at, throughput, segments } => {
                guides::show(&mut out, at, &self.world.bsdf(at), throughput);
                if segments == 1 {
                    out.distance = (at.p - ray.origin).length();
                }
            }
            Shown::Light(light) => guides::show_light(&mut out, light),
        });
        if let Some((point, bsdf)) = seen {
            let mut ended = Ended { out: &mut out, sampler, surfaces, scratch, queries, closeness: 0.0 };
            if point.component == 0 {
                let sample = ended.sampler.next_4x2d(&mut ended.queries.scrambles);
                self.light(&point, &bsdf, sample, &mut ended);
                self.scattered(&point, &bsdf, sample, &mut ended);
            } else {
                through_mirrors += self.all_components(point, walk, &mut ended);
            }
        }
        // One mirror on the way makes emission direct light, more make it indirect: Mitsuba counts segments.
        if !self.indirect_only {
            out.emission = emitted;
            out.direct.glossy += through_mirrors;
        }
        out
    }

    /// The surface that ends a walk, if any whose light counts. Adds what shines on the way: seen at once, and through mirrors.
    #[inline(always)]
    pub(super) fn seen(
        &self,
        walk: &mut Walk,
        sampler: &mut Sampler,
        queries: &mut Queries,
        (emitted, through_mirrors): (&mut Rgb, &mut Rgb),
        mut show: impl FnMut(Shown),
    ) -> Option<(Point, Bsdf<'_>)> {
        let (world, settings) = (self.world, &self.world.scene.integrator);
        let from = (world, self.policy);
        let seen = see(from, &self.cone, walk, sampler, settings.max_depth, queries, |at, throughput, segments| {
            let light = emission(world, &world.lights, at, None).0 * throughput;
            show(Shown::Surface { at, throughput, segments });
            match segments {
                1 if settings.hide_emitters => (),
                1 => *emitted += light,
                _ => *through_mirrors += light,
            }
        });
        match seen {
            Seen::Nothing { direction, throughput, segments } => {
                let light = environment(&world.lights, direction, None).0 * throughput;
                match segments {
                    1 if settings.hide_emitters || settings.hide_environment => (),
                    1 => *emitted += light,
                    _ => {
                        *through_mirrors += light;
                        show(Shown::Light(light));
                    }
                }
                None
            }
            Seen::Surface { point, bsdf } => (point.segments < settings.max_depth).then_some((point, bsdf)),
            Seen::Ended => None,
        }
    }

    /// Adds the light that comes to a surface straight from emitters.
    #[inline(always)]
    pub(super) fn light(
        &self,
        point: &Point,
        bsdf: &Bsdf,
        [choice, on_light, scattering, _]: Samples,
        ended: &mut Ended,
    ) {
        if self.indirect_only && point.segments == 1 {
            return;
        }
        // Records hold a part of the lights already.
        let treatment = self.policy.treatment(point.finish);
        let lights = if treatment == Treatment::Traced { &self.world.lights } else { &self.split.rest };
        let Ended { out, queries, closeness, .. } = ended;
        let mut direct = sample_light(self.world, lights, &point.at, bsdf, false, choice.x, on_light, queries);
        let (scattered, closer) = self.emitters_by_bsdf(lights, point, bsdf, choice.y, scattering, queries);
        direct = direct + scattered;
        *closeness = closer;
        let direct = direct * point.throughput;
        if point.segments == 1 { out.direct = out.direct + direct } else { out.indirect.glossy += direct.sum() }
    }

    /// Adds a path from a surface that is traced; notes any other for its records.
    #[inline(always)]
    pub(super) fn scattered(&self, point: &Point, bsdf: &Bsdf, [choice, _, scattering, _]: Samples, ended: &mut Ended) {
        let Ended { out, sampler, surfaces, scratch, queries, closeness } = ended;
        let width = match self.policy.treatment(point.finish) {
            Treatment::Traced => {
                out.indirect = out.indirect + self.traced(point, bsdf, None, choice.y, scattering, sampler, queries);
                return;
            }
            Treatment::Glossy(glossy) => Some(glossy.with(&self.policy.kinds, LobeWidth)),
            Treatment::Irradiance => None,
        };
        let sample = Surface::new(point, bsdf, *closeness);
        if let Some(alone) = sample.and_then(|sample| self.grouping.note(sample, width, surfaces))
            && self.has_indirect(&alone)
        {
            let one_path = |_: f32| (1, |_: u32| **sampler);
            out.indirect = out.indirect
                + self.surface(&alone, self.found(&alone, &alone.parts, scratch), &one_path, queries).light;
        }
    }

    /// Emitters that a direction of the BSDF meets, and one over the distance of what it meets.
    #[inline(always)]
    fn emitters_by_bsdf(
        &self,
        lights: &Lights,
        point: &Point,
        bsdf: &Bsdf,
        choice: f32,
        u: Vec2,
        queries: &mut Queries,
    ) -> (Split, f32) {
        let Some(sample) = bsdf.sample(choice, u) else { return (Split::ZERO, 0.0) };
        let left = (!sample.is_delta()).then(|| Left { receiver: receiver(&point.at, bsdf), pdf: sample.pdf });
        let ray = point.at.spawn(sample.wi);
        let hit = queries.intersect(self.world, &ray);
        let (light, weight) = if hit.exists() {
            emission(self.world, lights, &self.world.interaction(&ray, &hit), left.as_ref())
        } else {
            environment(lights, sample.wi, left.as_ref())
        };
        (sample.weight * (light * weight), hit.t.max(f32::MIN_POSITIVE).recip())
    }

    /// Indirect light by one path, and what of the environment was left to the records.
    #[inline(always)]
    #[allow(clippy::too_many_arguments)]
    pub(super) fn traced(
        &self,
        point: &Point,
        bsdf: &Bsdf,
        environment: Option<&Environment>,
        choice: f32,
        u: Vec2,
        sampler: &mut Sampler,
        queries: &mut Queries,
    ) -> Split {
        let settings = &self.world.scene.integrator;
        let Some(max_segments) =
            settings.max_depth.checked_sub(point.segments).filter(|&n| n > 1 || environment.is_some())
        else {
            return Split::ZERO;
        };
        let Some(sample) = bsdf.sample(choice, u) else { return Split::ZERO };
        let tracer = IncidentTracer {
            world: self.world,
            irradiance: Some(&self.caches.coarse),
            environment,
            max_segments,
            rr_depth: settings.rr_depth.saturating_sub(1).max(1),
        };
        let light = tracer.incident(point.at.spawn(sample.wi), sampler, queries);
        sample.weight * (light.radiance * point.throughput)
    }

    /// Indirect light of the surfaces of a pixel, summed over their samples. `find` tells what records say of each whose light
    /// counts, `samplers` makes the sample points of a path.
    #[inline(always)]
    pub fn indirect(
        &self,
        surfaces: &[Surface],
        find: &mut impl FnMut(&Surface) -> Found,
        samplers: &impl Fn(u32) -> Sampler,
        queries: &mut Queries,
    ) -> Indirect {
        let mut sum = Indirect::default();
        for s in surfaces.iter().filter(|s| self.has_indirect(s)) {
            // Noise of what a faint mirror shows, or of a component of little weight, is faint too.
            let share = s.point.throughput.max_element().clamp(0.0, 1.0);
            let paths = |doubt: f32| {
                let least = self.paths.least.max(self.paths.doubted * doubt);
                (s.samples.max(share * least).min(self.paths.most) as u32, samplers)
            };
            sum += self.surface(s, find(s), &paths, queries);
        }
        sum
    }

    /// Whether paths are long enough for the light of records.
    pub(super) fn has_indirect(&self, s: &Surface) -> bool {
        // Light of the environment comes by one more segment, other light of records by two; paths may be without end.
        s.point.segments + u32::from(self.split.held.is_none()) < self.world.scene.integrator.max_depth
    }

    /// What records say of a surface with these colours, summed over its samples.
    #[inline(always)]
    pub(super) fn found(&self, s: &Surface, parts: &Parts, scratch: &mut Scratches) -> Found {
        match self.policy.treatment(s.finish()) {
            Treatment::Irradiance => self.diffuse(s, parts, &self.caches.irradiance),
            Treatment::Glossy(glossy) => {
                let surface = Self::shaded(s, parts);
                glossy.with(&self.policy.kinds, Read { shader: self, surface: &surface, scratch })
            }
            Treatment::Traced => Found::NOTHING,
        }
    }

    /// What irradiance records say of a surface.
    #[inline(always)]
    pub(super) fn diffuse(&self, s: &Surface, parts: &Parts, records: &impl Lookup<IrradianceRecord>) -> Found {
        let normal = s.mean_normal();
        let found = interpolated(records, s.mean_position(), s.point.hemisphere_normal(), normal);
        Self::diffuse_found(s, parts, found)
    }

    /// The same of what they add up to.
    #[inline(always)]
    pub(super) fn diffuse_found(s: &Surface, parts: &Parts, found: Option<Interpolated>) -> Found {
        let light = found.map(|e| Split { diffuse: parts.diffuse * mean_radiance(e.irradiance), glossy: Rgb::ZERO });
        let doubt = f32::from(u8::from(found.is_some_and(|e| s.is_hidden_from(e.radius))));
        Found { light, traced: doubt, doubt }
    }

    /// A surface as glossy records are read for it.
    #[inline(always)]
    pub(super) fn shaded<'s>(s: &Surface, parts: &'s Parts) -> Shaded<'s> {
        let frame = turned(&s.point, s.mean_normal());
        let at = Receiver { position: s.mean_position(), frame, wo: frame.to_local(s.wo.normalize()) };
        Shaded { at, hemisphere: s.point.hemisphere_normal(), finish: s.point.finish, parts }
    }

    /// What a surface reflects if its diffuse part is white, where records say all of it; of the specular part for all samples.
    #[inline(always)]
    pub(super) fn held_on_white(&self, s: &Surface, scratch: &mut Scratches) -> Option<Split> {
        let found = self.has_indirect(s).then(|| self.found(s, &Parts { diffuse: Rgb::ONE, ..s.parts }, scratch))?;
        found.light.filter(|_| found.traced <= self.reading.untraced())
    }

    /// Indirect light of a surface of which records say this. `paths` tells how many to trace by the doubt about records, and the sample points of each.
    #[inline(always)]
    fn surface<S: Fn(u32) -> Sampler>(
        &self,
        s: &Surface,
        Found { light: cached, traced, doubt }: Found,
        paths: &impl Fn(f32) -> (u32, S),
        queries: &mut Queries,
    ) -> Indirect {
        let traced = if traced <= self.reading.untraced() { 0.0 } else { traced };
        let (path, half) = match cached {
            Some(_) if traced == 0.0 => (Split::ZERO, Rgb::ZERO),
            // Nothing reaches here: trace instead.
            _ => {
                let bsdf = s.point.bsdf(self.world);
                let (count, samplers) = paths(doubt);
                let held = self.split.held.as_ref();
                let mut sum = |range: Range<u32>| {
                    range.fold(Split::ZERO, |sum, path| {
                        let mut sampler = samplers(path);
                        let (choice, u) = (sampler.next_1d(), sampler.next_2d());
                        sum + self.traced(&s.point, &bsdf, held, choice, u, &mut sampler, queries)
                    })
                };
                let middle = first_half(count);
                let first = sum(0..middle);
                let path = (first + sum(middle..count)) * (s.samples / count as f32);
                (path, first.sum() * (s.samples / middle as f32))
            }
        };
        match cached {
            Some(cached) => Indirect {
                light: cached * (1.0 - traced) + path * traced,
                half: cached.sum() * (1.0 - traced) + half * traced,
            },
            None => Indirect { light: path, half },
        }
    }
}

/// Sample points for the light of a surface: choices, a light, a direction, and what is left.
pub(super) type Samples = [Vec2; 4];

/// What a walk shows on its way.
pub(super) enum Shown<'a> {
    /// A surface, through mirrors of this colour.
    Surface { at: &'a Interaction, throughput: Rgb, segments: u32 },
    /// Light of infinity in a mirror.
    Light(Rgb),
}

/// What a path from the eye adds to.
pub(super) struct Ended<'a> {
    pub out: &'a mut Radiance,
    pub sampler: &'a mut Sampler,
    pub surfaces: &'a mut Vec<Surface>,
    pub scratch: &'a mut Scratches,
    pub queries: &'a mut Queries,
    /// One over the distance of what the last ray met that looked for emitters.
    pub closeness: f32,
}

/// What the records of its kind reflect at a surface.
struct Read<'a> {
    shader: &'a Shader<'a>,
    surface: &'a Shaded<'a>,
    scratch: &'a mut Scratches,
}

impl WithKind for Read<'_> {
    type Out = Found;

    #[inline(always)]
    fn run<K: Listed>(self, kind: &K, held: K::Held) -> Found {
        let Shader { caches, quality, .. } = self.shader;
        kind.reflect(held, K::cache(&caches.glossy), self.surface, quality, K::scratch(self.scratch))
    }
}
