//! Table 1 of "Radiance Cache Splatting" (2005) again: the error of irradiances from a picture on a plane above the record, with its
//! border black, rescaled or extended to the horizon, beside a stratified hemisphere of as many rays. First bounce only.
//! `cargo run --release -p burnish-render --example plane -- SCENE [POINTS [SIDE]]`

use rayon::prelude::*;
use render::camera::RayGenerator;
use render::color::luminance;
use render::frame::Frame;
use render::hemisphere::{Border, Plane};
use render::integrator::cached::IncidentTracer;
use render::record::irradiance::{IrradianceRecord, Strata};
use render::sampler::Sampler;
use render::scene::{Rgb, load};
use render::world::{Interaction, Queries, World};
use std::error::Error;

/// Heights of the plane over its half width.
const HEIGHTS: [f64; 4] = [0.1, 0.25, 0.5, 1.0];
const BORDERS: [Border; 3] = [Border::Black, Border::Rescaled, Border::Extended];
/// Rays of the truth over those of what is measured.
const FINER: u32 = 16;

/// Irradiance at a point: the truth, by strata, and for each height by each border.
type Row = (f32, f32, [[f32; BORDERS.len()]; HEIGHTS.len()]);

fn main() -> Result<(), Box<dyn Error>> {
    let mut words = std::env::args().skip(1);
    let scene = words.next().ok_or("which scene?")?;
    let points: u32 = words.next().map_or(Ok(10_000), |w| w.parse())?;
    let side: u32 = words.next().map_or(Ok(64), |w| w.parse())?;
    let (scene, _) = load::load(scene.as_ref(), &load::Options::default())?;
    let world = World::new(scene)?;
    let rows: Vec<Row> = (0..points).into_par_iter().filter_map(|i| irradiances(&world, i, side)).collect();
    let mean = rows.iter().map(|row| f64::from(row.0)).sum::<f64>() / rows.len() as f64;
    println!(
        "{} points, mean irradiance {mean:.4}, {} rays each, the truth {FINER} times as many",
        rows.len(),
        side * side
    );
    let error = |of: &dyn Fn(&Row) -> f32| {
        let off = rows.iter().map(|row| f64::from(of(row) - row.0));
        let (squares, sum) = off.fold((0.0, 0.0), |(squares, sum), x| (squares + x * x, sum + x));
        let count = rows.len() as f64;
        format!("{:6.2} % rms {:+7.2} % bias", 100.0 * (squares / count).sqrt() / mean, 100.0 * sum / count / mean)
    };
    println!("stratified            {}", error(&|row| row.1));
    for (k, height) in HEIGHTS.iter().enumerate() {
        for (b, border) in BORDERS.iter().enumerate() {
            println!("plane {height:4} {:10} {}", format!("{border:?}").to_lowercase(), error(&|row| row.2[k][b]));
        }
    }
    Ok(())
}

/// Irradiances at what a random place of the film shows; `None` where it shows nothing.
fn irradiances(world: &World, i: u32, side: u32) -> Option<Row> {
    let generator = RayGenerator::new(&world.scene.camera);
    let film = &world.scene.camera.film;
    let mut sampler = Sampler::new(1, (i, 0), 0);
    let place = sampler.next_2d();
    let pixel =
        [(place.x, film.width), (place.y, film.height)].map(|(u, size)| ((u * size as f32) as u32).min(size - 1));
    let ray = generator.ray(pixel[0], pixel[1], sampler.next_2d());
    let mut queries = Queries::default();
    let hit = queries.intersect(world, &ray);
    if !hit.exists() {
        return None;
    }
    let at = world.interaction(&ray, &hit);
    let frame = Frame::from_normal(at.normal * 1f32.copysign(at.normal.dot(at.wo)));
    let mut gathered = |seed: u64, rays: u32| {
        let place = |number| Sampler::new(seed, (i, 1), number).next_2d();
        let light = |direction, number| {
            let mut sampler = Sampler::new(seed, (i, 2), number);
            tracer(world).incident(at.spawn(direction), &mut sampler, &mut queries)
        };
        luminance(IrradianceRecord::gather(at.p, &frame, Strata::about(rays), place, light).record.irradiance)
    };
    let (truth, strata) = (gathered(2, FINER * side * side), gathered(3, side * side));
    let planes = HEIGHTS.map(|height| on_planes(world, &at, &frame, (i, side, height), &mut queries));
    Some((truth, strata, planes))
}

/// One picture on a plane, summed with each border.
fn on_planes(
    world: &World,
    at: &Interaction,
    frame: &Frame,
    (i, side, height): (u32, u32, f64),
    queries: &mut Queries,
) -> [f32; BORDERS.len()] {
    let planes = BORDERS.map(|border| Plane::new(side, height, border));
    let mut sums = [Rgb::ZERO; BORDERS.len()];
    for cell in 0..planes[0].len() {
        let mut sampler = Sampler::new(4, (i, 3), cell);
        let ray = at.spawn(frame.to_world(planes[0].direction(cell)));
        let light = tracer(world).incident(ray, &mut sampler, queries).radiance;
        for (sum, plane) in sums.iter_mut().zip(&planes) {
            *sum += light * plane.projected(cell) as f32;
        }
    }
    sums.map(luminance)
}

/// What is reflected once.
fn tracer(world: &World) -> IncidentTracer<'_> {
    IncidentTracer { world, irradiance: None, environment: None, max_segments: 2, rr_depth: 8 }
}
