//! Table 1 of "Radiance Cache Splatting" (2005) again: the error of irradiances from a picture on a plane above the record, with its
//! border black, rescaled or extended to the horizon, beside a stratified hemisphere of as many rays. First bounce only. The picture is
//! drawn by rays and, in a build with the feature `gpu`, rasterised by a graphics card; both find the light that surfaces reflect held
//! in pieces of them.
//! `cargo run --release -p burnish-render --features gpu --example plane -- SCENE [POINTS [SIDE [FINER]]]`

use rayon::prelude::*;
use render::camera::RayGenerator;
use render::color::luminance;
use render::hemisphere::{Border, Plane};
use render::integrator::cached::IncidentTracer;
#[cfg(feature = "gpu")]
use render::integrator::plane::Rasterizer;
use render::integrator::plane::{SurfaceLight, Viewpoint};
use render::record::irradiance::{IrradianceRecord, Strata};
use render::sampler::Sampler;
use render::scene::{Rgb, load};
use render::world::{Interaction, Queries, World};
use std::error::Error;
use std::time::Instant;

/// Heights of the plane over its half width.
const HEIGHTS: [f64; 4] = [0.1, 0.25, 0.5, 1.0];
const BORDERS: [Border; 3] = [Border::Black, Border::Rescaled, Border::Extended];
/// Rays of the truth over those of what is measured.
const FINER: u32 = 16;
/// Points for which the card is timed.
#[cfg(feature = "gpu")]
const TIMED: usize = 256;
/// Pieces of surfaces, and shadow rays of each.
const PIECES: (usize, u32) = (1 << 20, 4);

fn main() -> Result<(), Box<dyn Error>> {
    let mut words = std::env::args().skip(1);
    let scene = words.next().ok_or("which scene?")?;
    let mut number = |default: u32| words.next().map_or(Ok(default), |w| w.parse());
    let (points, side, finer) = (number(10_000)?, number(64)?, number(FINER)?);
    let (scene, _) = load::load(scene.as_ref(), &load::Options::default())?;
    let world = World::new(scene)?;
    let seen: Vec<(u32, Interaction)> = (0..points).filter_map(|i| Some((i, shown(&world, i)?))).collect();
    let viewpoints: Vec<_> = seen.iter().map(|(_, at)| Viewpoint::on(at)).collect();
    let stratified = |seed: u64, rays: u32| -> Vec<Rgb> {
        seen.par_iter().map(|(i, at)| gathered(&world, (*i, at), (seed, rays))).collect()
    };
    let truth: Vec<f64> = luminances(&stratified(2, finer * side * side));
    let mean = truth.iter().sum::<f64>() / truth.len() as f64;
    let (count, threads) = (truth.len(), rayon::current_num_threads());
    println!(
        "{count} points, mean irradiance {mean:.4}, {side}² rays or cells each, the truth {finer} times as many; {threads} threads"
    );
    let error = |irradiances: &[Rgb]| {
        let found = luminances(irradiances);
        let off = found.iter().zip(&truth).map(|(a, b)| a - b);
        let (squares, sum) = off.fold((0.0, 0.0), |(squares, sum), x| (squares + x * x, sum + x));
        let count = found.len() as f64;
        format!("{:6.2} % rms {:+7.2} % bias", 100.0 * (squares / count).sqrt() / mean, 100.0 * sum / count / mean)
    };
    let (irradiances, time) = timed(|| stratified(3, side * side));
    println!("stratified            {}, {:.2} ms each", error(&irradiances), time / count as f64);
    let (light, time) = timed(|| SurfaceLight::new(&world, PIECES.0, PIECES.1));
    let light = light?;
    println!("light of {} pieces held in {time:.0} ms", light.pieces());
    #[cfg(feature = "gpu")]
    let card = Rasterizer::new(&world, &light)?;
    #[cfg(feature = "gpu")]
    println!("rasterised by {}", card.name());
    for height in HEIGHTS {
        let planes = BORDERS.map(|border| Plane::new(side, height, border));
        let sums_of = |plane: &Plane, pictures: &[Vec<u32>]| -> Vec<Rgb> {
            let weights = plane.weights();
            pictures.iter().map(|picture| light.sum(picture, &weights)).collect()
        };
        let print = |by: &str, pictures: &[Vec<u32>], time: f64| {
            for (border, plane) in BORDERS.iter().zip(&planes) {
                let (border, error) = (format!("{border:?}").to_lowercase(), error(&sums_of(plane, pictures)));
                println!("plane {height:4} {border:10} {by} {error}, {time:.2} ms each");
            }
        };
        let (_, time) = timed(|| light.irradiances(&world, &viewpoints, &planes[0]));
        let traced = light.pictures(&world, &viewpoints, &planes[0]);
        print("rays", &traced, time / count as f64);
        #[cfg(feature = "gpu")]
        {
            let some = &viewpoints[..viewpoints.len().min(TIMED)];
            let (sums, time) = timed(|| card.irradiances(some, &planes[0]));
            let drawn = card.pictures(&viewpoints, &planes[0])?;
            print("card", &drawn, time / sums?.len() as f64);
            let cells = traced.iter().flatten().zip(drawn.iter().flatten());
            let others = cells.clone().filter(|(a, b)| a != b).count();
            let [a, b] = [&traced, &drawn].map(|pictures| luminances(&sums_of(&planes[2], pictures)));
            let squares: f64 = a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum();
            println!(
                "           card against rays: {:.3} % of the cells differ, irradiances by {:.4} % rms",
                100.0 * others as f64 / cells.count() as f64,
                100.0 * (squares / count as f64).sqrt() / mean
            );
        }
    }
    Ok(())
}

fn luminances(irradiances: &[Rgb]) -> Vec<f64> {
    irradiances.iter().map(|irradiance| f64::from(luminance(*irradiance))).collect()
}

/// What it gives, and milliseconds.
fn timed<T>(work: impl FnOnce() -> T) -> (T, f64) {
    let begin = Instant::now();
    let made = work();
    (made, 1e3 * begin.elapsed().as_secs_f64())
}

/// What a random place of the film shows; `None` where it shows nothing.
fn shown(world: &World, i: u32) -> Option<Interaction> {
    let generator = RayGenerator::new(&world.scene.camera);
    let film = &world.scene.camera.film;
    let mut sampler = Sampler::new(1, (i, 0), 0);
    let place = sampler.next_2d();
    let pixel =
        [(place.x, film.width), (place.y, film.height)].map(|(u, size)| ((u * size as f32) as u32).min(size - 1));
    let ray = generator.ray(pixel[0], pixel[1], sampler.next_2d());
    let hit = world.intersect(&ray);
    hit.exists().then(|| world.interaction(&ray, &hit))
}

/// Irradiance by strata.
fn gathered(world: &World, (i, at): (u32, &Interaction), (seed, rays): (u64, u32)) -> Rgb {
    let mut queries = Queries::default();
    let tracer = IncidentTracer { world, irradiance: None, environment: None, max_segments: 2, rr_depth: 8 };
    let place = |number| Sampler::new(seed, (i, 1), number).next_2d();
    let light =
        |direction, number| tracer.incident(at.spawn(direction), &mut Sampler::new(seed, (i, 2), number), &mut queries);
    IrradianceRecord::gather(at.p, &Viewpoint::on(at).frame, Strata::about(rays), place, light).record.irradiance
}
