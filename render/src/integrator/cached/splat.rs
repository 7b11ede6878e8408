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
pub(super) struct Splats {
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
    /// Those that may appear in the rows of the tile.
    rows: Rows,
}

/// Places of spheres that may appear in some rows of pixels, by cache.
#[derive(Default)]
struct Rows {
    irradiance: Vec<u32>,
    glossy: PerKind<Vec<u32>>,
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

    /// Finds those that may appear in these rows.
    fn in_rows(&self, rows: &Range<i32>, found: &mut Vec<u32>) {
        found.clear();
        found.extend((0..).zip(&self.pixels).filter(|(_, [_, y])| meets(y, rows)).map(|(i, _)| i));
    }

    /// Finds those that the surfaces of a tile may need; `in_rows` are those in its rows.
    fn near(&self, place: &Place, in_rows: &[u32], near: &mut Near) {
        near.clear();
        let Place { pixels: [columns, rows], seen, elsewhere } = place;
        let on_tile = |i: usize| meets(&self.pixels[i][0], columns) && meets(&self.pixels[i][1], rows);
        if elsewhere.is_empty() {
            for &i in in_rows {
                let i = i as usize;
                if on_tile(i) && seen.meets(widened(self.spheres.get(i))) {
                    near.add(&self.spheres, i);
                }
            }
        } else {
            for i in 0..self.spheres.len() {
                let sphere = widened(self.spheres.get(i));
                if elsewhere.meets(sphere) || (on_tile(i) && seen.meets(sphere)) {
                    near.add(&self.spheres, i);
                }
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

impl Splats {
    /// As a camera sees them.
    pub fn new(caches: &Caches, camera: &RayGenerator, lens: bool) -> Self {
        let film = Film { silhouettes: Silhouettes::new(camera), reach: camera.filter_reach().into() };
        let mut each = PlaceEach { caches, film: &film, glossy: PerKind::default() };
        let Ok(()) = kinds::each(&mut each);
        let glossy = each.glossy;
        Self { lens, irradiance: Placed::new(&caches.irradiance, &film), glossy }
    }

    /// Notes the records in some rows of the film, for the tiles of these rows.
    pub fn enter(&self, rows: Range<u32>, tile: &mut Tile) {
        let rows = rows.start as i32..rows.end as i32;
        self.irradiance.in_rows(&rows, &mut tile.rows.irradiance);
        let Ok(()) = kinds::each(&mut EnterEach { splats: self, rows, tile });
    }

    /// Finds the records for the surfaces of some columns of the rows that were entered.
    pub fn draw(&self, pixels: &Crop, surfaces: &[&Surface], tile: &mut Tile) {
        let (mut seen, mut elsewhere) = (Box3::EMPTY, Box3::EMPTY);
        for surface in surfaces {
            let to = if self.lens || !surface.is_seen_directly() { &mut elsewhere } else { &mut seen };
            to.add(surface.mean_position());
        }
        let range = |start: u32, length: u32| start as i32..(start + length) as i32;
        let pixels = [range(pixels.x, pixels.width), range(pixels.y, pixels.height)];
        let place = Place { pixels, seen, elsewhere };
        self.irradiance.near(&place, &tile.rows.irradiance, &mut tile.irradiance);
        let Ok(()) = kinds::each(&mut DrawEach { splats: self, place: &place, tile });
    }
}

struct EnterEach<'a> {
    splats: &'a Splats,
    rows: Range<i32>,
    tile: &'a mut Tile,
}

impl EachKind for EnterEach<'_> {
    type Error = Infallible;

    fn run<K: Listed>(&mut self) -> Result<(), Infallible> {
        K::part(&self.splats.glossy).in_rows(&self.rows, K::part_mut(&mut self.tile.rows.glossy));
        Ok(())
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
    splats: &'a Splats,
    place: &'a Place,
    tile: &'a mut Tile,
}

impl EachKind for DrawEach<'_> {
    type Error = Infallible;

    fn run<K: Listed>(&mut self) -> Result<(), Infallible> {
        let Tile { glossy, rows, .. } = &mut *self.tile;
        K::part(&self.splats.glossy).near(self.place, &K::part(&rows.glossy)[..], K::part_mut(glossy));
        Ok(())
    }
}
