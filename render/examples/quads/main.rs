//! Records summed on a graphics card in two ways: compute tiles, which walk their records in order and are what the library does, and
//! the quads of "Radiance Cache Splatting" (2005), which are blended onto a picture. Irradiance records; the same surfaces, records and
//! rectangles for both.
//! `cargo run --release -p render --features gpu --example quads -- SCENE [RECORDS,… [WIDTHxHEIGHT,…]]`

mod both;
mod card;

use both::Both;
use glam::Vec3A;
use render::camera::{RayGenerator, Silhouettes};
use render::integrator::cached::policy::{Allowed, Policy};
use render::integrator::cached::{Interpolation, Rendering, Settings};
use render::picture::Budget;
use render::record::Record;
use render::record::eas::Estimator;
use render::record::irradiance::IrradianceRecord;
use render::scene::load;
use render::world::{Queries, World};
use std::error::Error;

/// τ with which records are first sought, and how much finer it gets until there are enough.
const COARSEST: f32 = 0.1;
const FINER: f32 = 0.6;
const FINEST: f32 = 0.01;
/// Width of the film for which they are made.
const FILM: u32 = 1024;

/// Room about rectangles for rounding, pixels.
const ROOM: f64 = 0.05;

/// A surface as the shader has it: position, normal of the hemisphere, normal. What is nowhere is out of reach of all records.
pub type Surface = [[f32; 4]; 3];
const NOWHERE: Surface = [[1e15, 1e15, 1e15, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 1.0, 0.0]];

fn main() -> Result<(), Box<dyn Error>> {
    let mut words = std::env::args().skip(1);
    let scene = words.next().ok_or("which scene?")?;
    let counts = words.next().unwrap_or("1000,4000".into());
    let counts = counts.split(',').map(str::parse).collect::<Result<Vec<usize>, _>>()?;
    let sizes = words.next().unwrap_or("256x256,1920x1080".into());
    let size = |text: &str| Some(text.split_once('x').and_then(|(w, h)| Some((w.parse().ok()?, h.parse().ok()?))));
    let sizes: Vec<(u32, u32)> =
        sizes.split(',').filter_map(size).collect::<Option<_>>().ok_or("sizes are WIDTHxHEIGHT")?;
    let (scene, _) = load::load(scene.as_ref(), &load::Options::default())?;
    let mut world = World::new(scene)?;
    // Records are no denser than pixels.
    world.scene.camera.film.resize(Some(FILM), None);
    let records = records(&world, counts.iter().copied().max().unwrap_or(0))?;
    let both = Both::open()?;
    println!("{}\n\n{}", both.name(), both.head());
    for count in counts.into_iter().filter(|count| *count <= records.len()) {
        let thinned = thinned(&records, count);
        for (width, height) in &sizes {
            world.scene.camera.film.resize(Some(*width), Some(*height));
            let (surfaces, rectangles) = (surfaces(&world), rectangles(&world, &thinned));
            println!("{}", both.compare(&thinned, &rectangles, &surfaces, (*width, *height))?);
        }
    }
    Ok(())
}

/// Irradiance records for what the camera sees, at least so many if τ can be fine enough.
fn records(world: &World, least: usize) -> Result<Vec<IrradianceRecord>, Box<dyn Error>> {
    let policy = Policy::new(&world.scene, Allowed::Irradiance, |_| Err("no tables"))?;
    let mut tolerance = COARSEST;
    loop {
        let settings = Settings {
            tolerance: Some(tolerance),
            estimator: Estimator::Improved,
            spacing: Default::default(),
            sources: None,
            budget: Budget::Samples(1),
            seed: 1,
            indirect_only: false,
            interpolation: Interpolation::Octree,
        };
        let caches = Rendering::new(world, &policy, &settings).fill(world, tolerance, None, None, &|_| ());
        let records = caches.irradiance.records();
        if records.len() >= least || tolerance < FINEST {
            return Ok(records.to_vec());
        }
        tolerance *= FINER;
    }
}

/// So many of the records, each of which reaches as much farther as there are fewer.
fn thinned(records: &[IrradianceRecord], count: usize) -> Vec<IrradianceRecord> {
    let farther = (records.len() as f32 / count as f32).sqrt();
    let chosen = (0..count).map(|i| records[i * records.len() / count]);
    chosen
        .map(|mut record| {
            record.zone_mut().radius *= farther;
            record
        })
        .collect()
}

/// What the middle of each pixel shows, row by row.
fn surfaces(world: &World) -> Vec<Surface> {
    let (generator, film) = (RayGenerator::new(&world.scene.camera), &world.scene.camera.film);
    let mut queries = Queries::default();
    let mut surface = |x: u32, y: u32| {
        let ray = generator.ray(x, y, glam::Vec2::splat(0.5));
        let hit = queries.intersect(world, &ray);
        if !hit.exists() {
            return NOWHERE;
        }
        let at = world.interaction(&ray, &hit);
        let normal = at.shading_normal * 1f32.copysign(at.normal.dot(at.wo) * at.normal.dot(at.shading_normal));
        [at.p, normal, normal].map(|v: Vec3A| v.extend(0.0).to_array())
    };
    (0..film.height).flat_map(|y| (0..film.width).map(move |x| (x, y))).map(|(x, y)| surface(x, y)).collect()
}

/// Where each record appears on the film, pixels: left, top, right, bottom.
fn rectangles(world: &World, records: &[IrradianceRecord]) -> Vec<[f32; 4]> {
    let film = &world.scene.camera.film;
    let silhouettes = Silhouettes::new(&RayGenerator::new(&world.scene.camera));
    let rectangle = |record: &IrradianceRecord| {
        let Some(bounds) = silhouettes.bounds(record.position(), record.radius()) else { return [0.0; 4] };
        let clamp = |x: f64, size: u32| x.clamp(0.0, f64::from(size)) as f32;
        let ([left, top], [right, bottom]) = (bounds.min.to_array(), bounds.max.to_array());
        [
            clamp(left - ROOM, film.width),
            clamp(top - ROOM, film.height),
            clamp(right + ROOM, film.width),
            clamp(bottom + ROOM, film.height),
        ]
    };
    records.iter().map(rectangle).collect()
}
