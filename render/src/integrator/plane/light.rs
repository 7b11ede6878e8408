//! The light that surfaces reflect once, held for each piece of them.

use super::patch::{Patch, Place};
use crate::integrator::direct::{Emitter, receiver};
use crate::ray::{Hit, NO_INSTANCE, Ray};
use crate::sampler::Sampler;
use crate::scene::Rgb;
use crate::world::{Outline, Queries, World};
use glam::Vec3A;
use rayon::prelude::*;

/// Pieces along an edge, at most.
const MAX_EDGE: f32 = 1024.0;
/// Pieces in all, so that they can be counted on.
const MAX_PIECES: u64 = 1 << 30;
/// Tells the sample points of pieces from others.
const SALT: u64 = 0x11e6_47ed;

/// Why surfaces cannot be held in pieces.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PlaneError {
    /// A rasteriser would draw them whole.
    #[error("surfaces with holes, or that are not there from behind, cannot be drawn onto a plane")]
    Holes,
    /// More than are counted.
    #[error("the surfaces have too many pieces: {0}")]
    Pieces(u64),
}

/// Radiance of every surface that is due to direct light and to its Lambertian part, W·m⁻²·sr⁻¹: the mean over each of its pieces, which
/// are about as large as each other. Its own emission is not in it, as in what records gather.
#[derive(Clone, Debug)]
pub struct SurfaceLight {
    pub(super) patches: Vec<Patch>,
    /// Number of the first patch: of no instance, then of each.
    bases: Vec<u32>,
    /// Radiance of all pieces; number 0 is what is seen where no surface is.
    pub(super) light: Vec<[f32; 3]>,
}

impl SurfaceLight {
    /// About so many pieces, but two for every triangle at least, each by `samples` points and shadow rays.
    ///
    /// # Errors
    /// Surfaces that cannot be held so.
    pub fn new(world: &World, pieces: usize, samples: u32) -> Result<Self, PlaneError> {
        if world.has_holes() {
            return Err(PlaneError::Holes);
        }
        let outlines: Vec<(Hit, Outline)> = world.primitives().collect();
        let (patches, total) = in_pieces(&outlines, pieces as f64)?;
        let mut bases = vec![0; 1 + world.scene.instances.len()];
        for (number, (hit, _)) in (0..).zip(&outlines) {
            if hit.primitive == 0 && hit.instance != NO_INSTANCE {
                bases[1 + hit.instance as usize] = number;
            }
        }
        let of_patch = |(patch, (hit, _)): (&Patch, &(Hit, Outline))| {
            let (patch, hit, count) = (*patch, *hit, patch.pieces());
            let mut queries = Queries::default();
            (0..2 * count).map(move |number| {
                let side = if number < count { 1.0 } else { -1.0 };
                let sampler = |k| Sampler::new(SALT, (patch.first + number, 0), k);
                let sum: Rgb = (0..samples)
                    .map(|k| {
                        reflected(world, hit, |u| (patch.place(number % count, u), side), sampler(k), &mut queries)
                    })
                    .sum();
                (sum / samples.max(1) as f32).to_array()
            })
        };
        let mut light = Vec::with_capacity(total as usize);
        light.push([0.0; 3]);
        let all: Vec<_> = patches.par_iter().zip(&outlines).flat_map_iter(of_patch).collect();
        light.extend(all);
        Ok(Self { patches, bases, light })
    }

    /// Radiance of a piece; black for those that there are not.
    pub fn radiance(&self, piece: u32) -> Rgb {
        self.light.get(piece as usize).map_or(Rgb::ZERO, |light| Rgb::from_array(*light))
    }

    /// Number of pieces, what is seen where no surface is among them.
    pub fn pieces(&self) -> usize {
        self.light.len()
    }

    /// The piece where a ray ends; 0 where it meets nothing.
    pub fn piece(&self, world: &World, ray: &Ray, hit: &Hit) -> u32 {
        if !hit.exists() {
            return 0;
        }
        let base = self.bases[if hit.instance == NO_INSTANCE { 0 } else { 1 + hit.instance as usize }];
        let patch = &self.patches[(base + hit.primitive) as usize];
        let (uv, position) = match patch.outline {
            Outline::Triangle(_) => (glam::Vec2::new(hit.b1, hit.b2), Vec3A::ZERO),
            Outline::Ellipsoid { .. } => {
                let at = world.interaction(ray, hit);
                (at.coordinates.uv[0], at.p)
            }
        };
        patch.piece(uv, position, -ray.direction)
    }
}

/// Patches with about so many pieces, and the number of all that there are.
fn in_pieces(outlines: &[(Hit, Outline)], wanted: f64) -> Result<(Vec<Patch>, u64), PlaneError> {
    let areas: Vec<f32> = outlines
        .iter()
        .map(|(_, outline)| match outline {
            Outline::Triangle([a, b, c]) => 0.5 * (*b - *a).cross(*c - *a).length(),
            Outline::Ellipsoid { .. } => 0.0,
        })
        .collect();
    let edge =
        |area: f32, of_piece: f64| ((f64::from(area) / of_piece).sqrt().ceil() as f32).clamp(1.0, MAX_EDGE) as u32;
    let all = |of_piece: f64| areas.iter().map(|area| 2 * u64::from(edge(*area, of_piece)).pow(2)).sum::<u64>() as f64;
    let whole: f64 = areas.iter().map(|area| f64::from(*area)).sum();
    // The area of a piece between one that is surely too small and one that is surely too large.
    let (mut low, mut high) = (whole / wanted.max(1.0) / 8.0, whole);
    for _ in 0..40 {
        let middle = (low * high).sqrt();
        if all(middle) > wanted { low = middle } else { high = middle }
    }
    let mut first = 1u64;
    let mut patches = Vec::with_capacity(outlines.len());
    for ((_, outline), area) in outlines.iter().zip(&areas) {
        let patch = Patch { outline: *outline, first: first as u32, edge: edge(*area, high) };
        first += 2 * u64::from(patch.pieces());
        if first > MAX_PIECES {
            return Err(PlaneError::Pieces(first));
        }
        patches.push(patch);
    }
    Ok((patches, first))
}

/// Light of one emitter, reflected by the Lambertian part at a point of a piece towards its side.
fn reflected(
    world: &World,
    hit: Hit,
    place: impl Fn(glam::Vec2) -> (Place, f32),
    mut sampler: Sampler,
    queries: &mut Queries,
) -> Rgb {
    let [on_piece, choice, on_light, _] = sampler.next_4x2d(&mut queries.scrambles);
    let (Place { barycentric, position, outward }, side) = place(on_piece);
    let outward = outward * side;
    let ray = Ray::new(position + outward, -outward);
    let at = world.interaction(&ray, &Hit { b1: barycentric.x, b2: barycentric.y, ..hit });
    let bsdf = world.bsdf(&at);
    if bsdf.is_delta() {
        return Rgb::ZERO;
    }
    let Some(emitter) = Emitter::sample(world, &world.lights, &bsdf, &receiver(&at, &bsdf), choice.x, on_light) else {
        return Rgb::ZERO;
    };
    let light = emitter.value.f.diffuse * emitter.light.radiance * emitter.factor(1.0);
    let seen = emitter.in_sight(world, &at, light, queries).is_some();
    if seen && light.is_finite() { light } else { Rgb::ZERO }
}
