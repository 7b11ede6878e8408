//! `render image`.

use anyhow::{Context, Result, bail, ensure};
use indicatif::{ProgressBar, ProgressStyle};
use render::film::{Budget, Picture, render};
use render::image::write_picture;
use render::integrator::PathTracer;
use render::scene::{Camera, Crop, Scene, load};
use render::world::World;
use serde::Serialize;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::{Duration, Instant};

/// Largest width or height.
const MAX_SIZE: u32 = 1 << 15;

/// About what it takes to compress and write a pixel of each format; `--time` sets it aside.
const EXR_SECONDS: f64 = 1e-6;
const PNG_SECONDS: f64 = 1e-7;

/// How to render.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum Method {
    /// Path tracing.
    Path,
}

/// Arguments of `render image`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Scene: Mitsuba XML or glTF.
    scene: PathBuf,
    /// Picture to write: .exr (linear, with layers) or .png (sRGB view).
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
    /// How to render.
    #[arg(long, value_enum, default_value_t = Method::Path)]
    method: Method,
    /// Samples per pixel [default: what the scene asks for].
    #[arg(long, value_name = "N", conflicts_with_all = ["time", "error"], value_parser = clap::value_parser!(u32).range(1..=1 << 22))]
    spp: Option<u32>,
    /// Seconds for everything but loading.
    #[arg(long, value_name = "SECONDS", conflicts_with = "error")]
    time: Option<f64>,
    /// Stop at this relative error: the root of the estimated rel_mse.
    #[arg(long, value_name = "RELATIVE")]
    error: Option<f32>,
    /// Width of the film in pixels; alone, it keeps the aspect.
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_SIZE)))]
    width: Option<u32>,
    /// Height of the film in pixels; alone, it keeps the aspect.
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_SIZE)))]
    height: Option<u32>,
    /// Render a part of the film only: x,y,width,height in pixels from the top left.
    #[arg(long, value_name = "X,Y,W,H", value_parser = parse_crop)]
    crop: Option<Crop>,
    /// Set a parameter of the scene file.
    #[arg(short = 'D', value_name = "NAME=VALUE", value_parser = parse_define)]
    define: Vec<(String, String)>,
    /// Largest number of path segments, 1 = emitters only [default: the scene's].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    max_depth: Option<u32>,
    /// Leave out light that is scattered less than twice.
    #[arg(long)]
    indirect_only: bool,
    /// Number of threads [default: all cores].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    /// Seed of the sample points.
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Write figures of the run.
    #[arg(long, value_name = "FILE.json")]
    stats: Option<PathBuf>,
}

fn parse_define(text: &str) -> Result<(String, String), String> {
    let (name, value) = text.split_once('=').ok_or("expected NAME=VALUE")?;
    Ok((name.to_owned(), value.to_owned()))
}

fn parse_crop(text: &str) -> Result<Crop, String> {
    let numbers: Result<Vec<u32>, _> = text.split(',').map(|n| n.trim().parse()).collect();
    match numbers.as_deref() {
        Ok(&[x, y, width, height]) => Ok(Crop { x, y, width, height }),
        _ => Err("expected X,Y,WIDTH,HEIGHT".into()),
    }
}

/// What `--stats` says; the keys of the cache stay zero without one.
#[derive(Debug, Serialize)]
struct Stats {
    method: &'static str,
    seconds: Seconds,
    rays: u64,
    records: u64,
    eas_mean: f64,
    bytes_per_record: f64,
    cache_bytes: u64,
    spp: u32,
    threads: usize,
}

#[derive(Debug, Serialize)]
struct Seconds {
    load: f64,
    fit: f64,
    fill: f64,
    shade: f64,
    total: f64,
}

/// Loads, renders, writes.
pub fn run(args: &Args) -> Result<ExitCode> {
    let start = Instant::now();
    if let Some(seconds) = args.time {
        ensure!(seconds > 0.0 && seconds < 1e7, "--time needs a number of seconds > 0");
    }
    if let Some(error) = args.error {
        ensure!(error > 0.0 && error.is_finite(), "--error needs a number > 0");
    }
    let extension = args.output.extension().unwrap_or_default().to_ascii_lowercase();
    if extension != "exr" && extension != "png" {
        bail!("{}: the name must end in .exr or .png", args.output.display());
    }
    let pool = rayon::ThreadPoolBuilder::new().num_threads(args.threads.unwrap_or(0).into()).build()?;
    let (mut scene, warnings) = load::load(&args.scene, &args.define)?;
    for warning in warnings {
        eprintln!("render: warning: {warning}");
    }
    change_view(&mut scene.camera, args);
    if let Some(depth) = args.max_depth {
        scene.integrator.max_depth = depth;
    }
    let budget = budget(args, &scene);
    let Method::Path = args.method;
    let integrator = PathTracer { settings: scene.integrator, indirect_only: args.indirect_only };
    let world = pool.install(|| World::new(scene)).with_context(|| args.scene.display().to_string())?;
    let load_seconds = start.elapsed().as_secs_f64();
    let shading = Instant::now();
    let picture = pool.install(|| with_progress(&world, &integrator, budget, args.seed));
    write_picture(&args.output, &picture)?;
    let shade = shading.elapsed().as_secs_f64();
    if let Some(path) = &args.stats {
        let stats = Stats {
            method: "path",
            seconds: Seconds { load: load_seconds, fit: 0.0, fill: 0.0, shade, total: start.elapsed().as_secs_f64() },
            rays: picture.rays,
            records: 0,
            eas_mean: 0.0,
            bytes_per_record: 0.0,
            cache_bytes: 0,
            spp: picture.spp,
            threads: pool.current_num_threads(),
        };
        std::fs::write(path, serde_json::to_string_pretty(&stats)? + "\n")
            .with_context(|| path.display().to_string())?;
    }
    Ok(ExitCode::SUCCESS)
}

fn budget(args: &Args, scene: &Scene) -> Budget {
    match (args.spp, args.time, args.error) {
        (_, Some(seconds), _) => {
            let film = scene.camera.film.window();
            let per_pixel = if args.output.extension().is_some_and(|e| e.eq_ignore_ascii_case("exr")) {
                EXR_SECONDS
            } else {
                PNG_SECONDS
            };
            let writing = per_pixel * f64::from(film.width) * f64::from(film.height);
            Budget::Time(Duration::from_secs_f64(seconds - writing.min(0.5 * seconds)))
        }
        (_, _, Some(error)) => Budget::Error(error),
        (spp, ..) => Budget::Samples(spp.unwrap_or(scene.integrator.spp)),
    }
}

/// Applies `--width`, `--height` and `--crop`. A new size drops the crop of the file, whose pixels are others.
fn change_view(camera: &mut Camera, args: &Args) {
    let film = &mut camera.film;
    let scaled = |x: u32, to: u32, from: u32| {
        ((u64::from(x) * u64::from(to) + u64::from(from) / 2) / u64::from(from)).clamp(1, u64::from(MAX_SIZE)) as u32
    };
    let (width, height) = match (args.width, args.height) {
        (None, None) => (film.width, film.height),
        (Some(w), Some(h)) => (w, h),
        (Some(w), None) => (w, scaled(film.height, w, film.width)),
        (None, Some(h)) => (scaled(film.width, h, film.height), h),
    };
    if (width, height) != (film.width, film.height) {
        (film.width, film.height, film.crop) = (width, height, None);
    }
    if let Some(crop) = args.crop {
        film.crop = Some(crop);
    }
}

/// Renders with a bar and the time left on standard error, where that is a terminal.
fn with_progress(world: &World, integrator: &PathTracer, budget: Budget, seed: u64) -> Picture {
    const STEPS: u64 = 1000;
    let bar = ProgressBar::new(STEPS);
    if let Ok(style) = ProgressStyle::with_template("{bar:40} {percent:>3} %  {elapsed} passed, {eta} left") {
        bar.set_style(style);
    }
    let picture = render(world, integrator, budget, seed, &|share| {
        let position = (share * STEPS as f64) as u64;
        if position > bar.position() {
            bar.set_position(position);
        }
    });
    bar.finish_and_clear();
    picture
}
