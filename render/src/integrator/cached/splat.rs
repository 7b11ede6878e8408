//! Records drawn onto tiles of pixels ("Radiance Cache Splatting", 2005, Algorithm 1).
//!
//! The surfaces of the pixels are the geometry buffer. Every record is a sphere, which appears in a rectangle of the film; a tile of
//! pixels takes the records whose rectangles meet it and whose spheres meet the box about its surfaces. What is seen in
//! mirrors, or through a lens, appears elsewhere than it is: there the box alone decides. The surfaces then sum the records
//! of their tile by the same code that sums those of an octree.

use super::caches::Caches;
use super::kinds::{self, EachKind, Listed, PerKind};
use super::surface::Surface;
use crate::cache::{Cache, Near, Spheres};
use crate::camera::{RayGenerator, Silhouettes};
use crate::record::Record;
use crate::scene::Crop;
use core::convert::Infallible;
use core::ops::Range;
use glam::Vec3A;

/// Sides of tiles, pixels.
pub(super) const SIDE: usize = 16;

/// Room about spheres for the rounding of positions, in units of their last place, and on the film, in pixels.
const ULPS: f32 = 16.0;
const PIXELS: f64 = 0.02;

/// The records of all caches as a camera sees them.
pub(super) struct Splats<'a> {
    pub(super) caches: &'a Caches,
    /// Whether surfaces appear elsewhere than they are.
    lens: bool,
    irradiance: Placed,
    glossy: PerKind<Placed>,
}

/// The records near the surfaces of a tile, by cache.
#[derive(Default)]
pub(super) struct Tile {
    pub irradiance: Near,
    pub glossy: PerKind<Near>,
}

/// The spheres of a cache, and the columns and rows of pixels whose samples may show them.
#[derive(Default)]
struct Placed {
    spheres: Spheres,
    pixels: Vec<[Range<i32>; 2]>,
}

/// How a camera turns spheres into rectangles of pixels.
struct Film {
    silhouettes: Silhouettes,
    /// Distance of samples from the middle of their pixel.
    reach: f64,
}

impl Film {
    /// Pixels of the whole film that may show a sphere.
    fn pixels(&self, center: Vec3A, radius: f32) -> [Range<i32>; 2] {
        // Casts saturate: bounds may be infinite.
        let range = |low: f64, high: f64| {
            let room = self.reach + PIXELS;
            ((low - 0.5 - room).ceil() as i32)..((high - 0.5 + room).floor() as i32).saturating_add(1)
        };
        let bounds = self.silhouettes.bounds(center, radius);
        bounds.map_or([0..0, 0..0], |b| [range(b.min.x, b.max.x), range(b.min.y, b.max.y)])
    }
}

impl Placed {
    fn new<R: Record>(cache: &Cache<R>, film: &Film) -> Self {
        let spheres = Spheres::of(cache);
        let pixels = (0..spheres.len()).map(|i| {
            let (center, radius) = widened(spheres.get(i));
            film.pixels(center, radius)
        });
        Self { pixels: pixels.collect(), spheres }
    }

    /// Adds to `near` those that the surfaces of a tile may need.
    fn near(&self, place: &Place, near: &mut Near) {
        near.clear();
        let Place { pixels: [columns, rows], seen, elsewhere } = place;
        for (i, [x, y]) in self.pixels.iter().enumerate() {
            let on_tile = meets(y, rows) && meets(x, columns);
            if (on_tile || !elsewhere.is_empty()) && {
                let sphere = widened(self.spheres.get(i));
                (on_tile && seen.meets(sphere)) || elsewhere.meets(sphere)
            } {
                near.add(&self.spheres, i);
            }
        }
    }
}

/// A sphere with room for the rounding of what lies on it.
fn widened((center, radius): (Vec3A, f32)) -> (Vec3A, f32) {
    (center, radius + ULPS * f32::EPSILON * (radius + center.abs().max_element()))
}

fn meets(a: &Range<i32>, b: &Range<i32>) -> bool {
    a.start < b.end && b.start < a.end
}

/// Where a tile and its surfaces are.
struct Place {
    pixels: [Range<i32>; 2],
    /// About surfaces that appear where they are.
    seen: Box3,
    /// About those seen in mirrors and through lenses.
    elsewhere: Box3,
}

/// A box with sides along the axes.
#[derive(Clone, Copy)]
struct Box3 {
    min: Vec3A,
    max: Vec3A,
}

impl Box3 {
    const EMPTY: Self = Self { min: Vec3A::INFINITY, max: Vec3A::NEG_INFINITY };

    fn is_empty(&self) -> bool {
        self.min.x > self.max.x
    }

    fn add(&mut self, p: Vec3A) {
        (self.min, self.max) = (self.min.min(p), self.max.max(p));
    }

    /// Whether any of it lies in a sphere.
    #[inline]
    fn meets(&self, (center, radius): (Vec3A, f32)) -> bool {
        !self.is_empty() && center.clamp(self.min, self.max).distance_squared(center) <= radius * radius
    }
}

impl<'a> Splats<'a> {
    /// As a camera sees them.
    pub fn new(caches: &'a Caches, camera: &RayGenerator, lens: bool) -> Self {
        let film = Film { silhouettes: Silhouettes::new(camera), reach: camera.filter_reach().into() };
        let mut each = PlaceEach { caches, film: &film, glossy: PerKind::default() };
        let Ok(()) = kinds::each(&mut each);
        let glossy = each.glossy;
        Self { caches, lens, irradiance: Placed::new(&caches.irradiance, &film), glossy }
    }

    /// Finds the records for the surfaces of some pixels of the film.
    pub fn draw<'s>(&self, pixels: &Crop, surfaces: impl Iterator<Item = &'s Surface>, tile: &mut Tile) {
        let (mut seen, mut elsewhere) = (Box3::EMPTY, Box3::EMPTY);
        for surface in surfaces {
            let to = if self.lens || !surface.is_seen_directly() { &mut elsewhere } else { &mut seen };
            to.add(surface.mean_position());
        }
        let range = |start: u32, length: u32| start as i32..(start + length) as i32;
        let pixels = [range(pixels.x, pixels.width), range(pixels.y, pixels.height)];
        let place = Place { pixels, seen, elsewhere };
        self.irradiance.near(&place, &mut tile.irradiance);
        let Ok(()) = kinds::each(&mut DrawEach { splats: self, place: &place, tile });
    }
}

struct PlaceEach<'a> {
    caches: &'a Caches,
    film: &'a Film,
    glossy: PerKind<Placed>,
}

impl EachKind for PlaceEach<'_> {
    type Error = Infallible;

    fn run<K: Listed>(&mut self) -> Result<(), Infallible> {
        *K::part_mut(&mut self.glossy) = Placed::new(K::cache(&self.caches.glossy), self.film);
        Ok(())
    }
}

struct DrawEach<'a> {
    splats: &'a Splats<'a>,
    place: &'a Place,
    tile: &'a mut Tile,
}

impl EachKind for DrawEach<'_> {
    type Error = Infallible;

    fn run<K: Listed>(&mut self) -> Result<(), Infallible> {
        K::part(&self.splats.glossy).near(self.place, K::part_mut(&mut self.tile.glossy));
        Ok(())
    }
}
