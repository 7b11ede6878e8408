//! `render image`.

use super::method::{Method, Reach};
use anyhow::{Context, Result, bail, ensure};
use indicatif::{ProgressBar, ProgressStyle};
use render::cache::Spacing;
use render::film::{Budget, Picture, render};
use render::image::{write_picture, write_png, write_whole};
use render::inspect::overlay::show_records;
use render::integrator::PathTracer;
use render::integrator::cached::file::{self, CacheFileError};
use render::integrator::cached::policy::{Allowed, Policy};
use render::integrator::cached::{Figures, Settings, TOLERANCE, render_cached};
use render::record::eas::Estimator;
use render::record::harmonics::{Basis, Gradients, HarmonicsSettings, MAX_ORDER};
use render::scene::{Camera, Crop, Scene, load};
use render::tables::Tables;
use render::world::{Counts, World};
use serde::Serialize;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::{Duration, Instant};

/// Largest width or height.
pub(super) const MAX_SIZE: u32 = 1 << 15;

/// About what it takes to compress and write a pixel of each format; `--time` sets it aside.
const EXR_SECONDS: f64 = 1.6e-6;
const PNG_SECONDS: f64 = 1e-7;

/// Arguments of `render image`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Scene: Mitsuba XML or glTF.
    scene: PathBuf,
    /// Picture to write: .exr (linear, with layers) or .png (sRGB view); may be given for each.
    #[arg(short, long, value_name = "OUT", required = true)]
    output: Vec<PathBuf>,
    /// How to render.
    #[arg(long, value_enum, default_value_t = Method::Path)]
    method: Method,
    /// How EAS are moved and summed: the published way, or ours.
    #[arg(long, value_enum, default_value_t = Estimator::Improved)]
    eas: Estimator,
    /// Sources of every EAS record, instead of as few as tau allows; a tree has 7, 10, 13… of them.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(7..=4096))]
    sources: Option<u16>,
    /// Harmonics of every view, instead of the least that lose no more of its lobe than tau allows; no view is path traced then.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(1..=MAX_ORDER as i64))]
    order: Option<u8>,
    /// How harmonic records change with position [default: analytic].
    #[arg(long, value_enum)]
    gradients: Option<Gradients>,
    /// Which harmonics: in the frame of the record, or in that of the world [default: hemispherical].
    #[arg(long, value_enum)]
    basis: Option<Basis>,
    /// What decides how far records reach [default: hessian, distance with --eas paper].
    #[arg(long, value_enum)]
    radius: Option<Reach>,
    /// Records that differ by more than this fraction where they overlap reach less far (adaptive caching).
    #[arg(long, value_name = "FRACTION", num_args = 0..=1, default_missing_value = "0.03")]
    adaptive: Option<f32>,
    /// Quality of a cached rendering, the paper's tau: rays, spacing and number of sources follow
    /// [default: 0.02, or what --time allows].
    #[arg(long, value_name = "TAU")]
    tau: Option<f32>,
    /// Folder of fitted tables; what is missing is fitted and kept there.
    #[arg(long, value_name = "DIR", default_value = "tables")]
    tables: PathBuf,
    /// Keep records in this file: read where it exists, written at the end. The same camera gives the same picture.
    #[arg(long, value_name = "FILE", conflicts_with = "time")]
    cache: Option<PathBuf>,
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
    /// Write the rendering with its records: dots, and the circles they reach. EAS or harmonics red, irradiance green, coarse
    /// irradiance blue.
    #[arg(long, value_name = "OUT.png")]
    show_records: Option<PathBuf>,
}

pub(super) fn parse_define(text: &str) -> Result<(String, String), String> {
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

/// Renders through caches; tells what it does with each material.
fn cached(args: &Args, world: &World, budget: Budget, pool: &rayon::ThreadPool, stats: &mut Stats) -> Result<Picture> {
    ensure!(args.error.is_none(), "--error needs --method path: a cached picture does not know its error");
    if let Some(tau) = args.tau {
        ensure!((0.0005..=1.0).contains(&tau), "--tau needs a number from 0.0005 to 1");
    }
    let allowed = match args.method {
        Method::Irradiance => Allowed::Irradiance,
        Method::Eas => Allowed::Eas,
        Method::Sh => Allowed::Harmonics(HarmonicsSettings::new(
            args.basis.unwrap_or_default(),
            args.gradients.unwrap_or_default(),
            args.tau.unwrap_or(TOLERANCE),
            args.order.map(usize::from),
        )),
        Method::Auto | Method::Path => Allowed::Auto,
    };
    let mut tables = Tables::open(&args.tables)?;
    let deciding = Instant::now();
    let policy = pool.install(|| Policy::new(&world.scene, allowed, |recipe| tables.find(recipe)))?;
    let fitting = if policy.projection.is_some() { deciding.elapsed() } else { tables.fitting };
    for note in tables.notes.iter().chain(&policy.notes) {
        eprintln!("render: {note}");
    }
    let settings = Settings {
        tolerance: args.tau,
        estimator: args.eas,
        spacing: Spacing {
            hessian: args.radius.unwrap_or(Reach::of(args.eas)) == Reach::Hessian,
            adaptive: args.adaptive,
        },
        sources: args.sources.map(usize::from),
        budget,
        seed: args.seed,
        indirect_only: args.indirect_only,
    };
    let tolerance = args.tau.unwrap_or(TOLERANCE);
    let mut kept = None;
    if let Some(path) = args.cache.as_ref().filter(|p| p.exists()) {
        let loaded = file::load(path, world, &policy, &settings, tolerance);
        kept = Some(loaded.map_err(|e: CacheFileError| anyhow::anyhow!("{}: {e}", path.display()))?);
    }
    let (picture, figures, caches) =
        pool.install(|| with_progress(|progress| render_cached(world, &policy, &settings, kept, progress)));
    if let Some(path) = &args.cache {
        file::save(path, world, &policy, &settings, tolerance, &caches)
            .map_err(|e| anyhow::anyhow!("{}: {e}", path.display()))?;
    }
    stats.take(&figures, fitting);
    let glossy = match args.method {
        Method::Sh => format!("{} harmonic records of order {:.1}", figures.harmonics_records, stats.order_mean),
        _ => format!("{} EAS records of {:.0} sources", figures.eas_records, stats.eas_mean),
    };
    if figures.negative_pixels > 0 {
        eprintln!("render: indirect light is negative in {} pixels: ringing", figures.negative_pixels);
    }
    eprintln!(
        "render: {:.2} s to fill, {:.2} s to shade; {glossy} and {:.0} bytes, {} irradiance records; {} KB in all; tau {:.4}",
        stats.seconds.fill,
        stats.seconds.shade,
        stats.bytes_per_record,
        figures.irradiance_records,
        figures.bytes / 1000,
        figures.tolerance
    );
    if let Some(path) = &args.show_records {
        write_png(path, &show_records(&picture.image(), world, &caches))?;
    }
    Ok(picture)
}

/// What `--stats` says; the keys of the cache stay zero without one.
#[derive(Debug, Default, Serialize)]
struct Stats {
    method: &'static str,
    seconds: Seconds,
    rays: u64,
    not_finite: u64,
    records: u64,
    eas_mean: f64,
    order_mean: f64,
    negative_pixels: u64,
    bytes_per_record: f64,
    cache_bytes: u64,
    spp: u32,
    threads: usize,
}

impl Stats {
    fn take(&mut self, figures: &Figures, fitting: Duration) {
        self.seconds.fit = fitting.as_secs_f64();
        self.seconds.fill = figures.fill.as_secs_f64();
        self.seconds.shade = figures.shade.as_secs_f64();
        let glossy = figures.eas_records + figures.harmonics_records;
        self.records = (glossy + figures.irradiance_records) as u64;
        let per_record = |x: usize| x as f64 / glossy.max(1) as f64;
        self.eas_mean = per_record(figures.sources);
        self.order_mean = per_record(figures.bands);
        self.negative_pixels = figures.negative_pixels;
        self.bytes_per_record = per_record(figures.eas_bytes + figures.harmonics_bytes);
        self.cache_bytes = figures.bytes as u64;
    }
}

#[derive(Debug, Default, Serialize)]
struct Seconds {
    load: f64,
    fit: f64,
    fill: f64,
    shade: f64,
    write: f64,
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
    if !matches!(args.method, Method::Sh) {
        let given = [
            ("--order", args.order.is_some()),
            ("--gradients", args.gradients.is_some()),
            ("--basis", args.basis.is_some()),
        ];
        if let Some((option, _)) = given.into_iter().find(|(_, given)| *given) {
            bail!("{option} needs --method sh");
        }
    }
    if let Some(fraction) = args.adaptive {
        ensure!((0.001..=1.0).contains(&fraction), "--adaptive needs a number from 0.001 to 1");
    }
    if matches!(args.method, Method::Path) && (args.radius.is_some() || args.adaptive.is_some()) {
        bail!("--radius and --adaptive need --method auto, eas, sh or irradiance: path tracing keeps no records");
    }
    for output in &args.output {
        let extension = output.extension().unwrap_or_default().to_ascii_lowercase();
        if extension != "exr" && extension != "png" {
            bail!("{}: the name must end in .exr or .png", output.display());
        }
    }
    if let Some(path) = &args.show_records {
        ensure!(
            !matches!(args.method, Method::Path),
            "--show-records needs --method auto, eas, sh or irradiance: path tracing keeps no records"
        );
        if path.extension().is_none_or(|e| !e.eq_ignore_ascii_case("png")) {
            bail!("{}: the name must end in .png", path.display());
        }
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
    let world = pool.install(|| World::new(scene)).with_context(|| args.scene.display().to_string())?;
    let load_seconds = start.elapsed().as_secs_f64();
    let mut stats = Stats { method: args.method.name(), threads: pool.current_num_threads(), ..Stats::default() };
    stats.seconds.load = load_seconds;
    let picture = match args.method {
        Method::Path => {
            let shading = Instant::now();
            let integrator = PathTracer { settings: world.scene.integrator, indirect_only: args.indirect_only };
            let picture =
                pool.install(|| with_progress(|progress| render(&world, &integrator, budget, args.seed, progress)));
            stats.seconds.shade = shading.elapsed().as_secs_f64();
            picture
        }
        _ => cached(args, &world, budget, &pool, &mut stats)?,
    };
    let writing = Instant::now();
    for output in &args.output {
        write_picture(output, &picture)?;
    }
    stats.seconds.write = writing.elapsed().as_secs_f64();
    let Counts { rays, paths, not_finite } = picture.counts;
    (stats.rays, stats.not_finite, stats.spp) = (rays, not_finite, picture.spp);
    if let Some(warning) = not_finite_warning(not_finite, paths) {
        eprintln!("render: warning: {warning}");
    }
    stats.seconds.total = start.elapsed().as_secs_f64();
    if let Some(path) = &args.stats {
        write_whole(path, (serde_json::to_string_pretty(&stats)? + "\n").as_bytes())?;
    }
    Ok(ExitCode::SUCCESS)
}

/// Said where so many paths were dropped that a picture may show it.
fn not_finite_warning(dropped: u64, paths: u64) -> Option<String> {
    let too_many = u128::from(dropped) * 1_000_000 > u128::from(paths);
    too_many.then(|| format!("{dropped} of {paths} paths were not finite and count as black: the picture is too dark"))
}

fn budget(args: &Args, scene: &Scene) -> Budget {
    match (args.spp, args.time, args.error) {
        (_, Some(seconds), _) => {
            let film = scene.camera.film.window();
            let exr = |p: &&PathBuf| p.extension().is_some_and(|e| e.eq_ignore_ascii_case("exr"));
            let exrs = args.output.iter().filter(exr).count();
            let per_pixel = EXR_SECONDS * exrs as f64 + PNG_SECONDS * (args.output.len() - exrs) as f64;
            let writing = per_pixel * f64::from(film.width) * f64::from(film.height);
            Budget::Time(Duration::from_secs_f64(seconds - writing.min(0.5 * seconds)))
        }
        (_, _, Some(error)) => Budget::Error(error),
        (spp, ..) => Budget::Samples(spp.unwrap_or(scene.integrator.spp)),
    }
}

/// Applies `--width`, `--height` and `--crop`. A new size drops the crop of the file, whose pixels are others.
fn change_view(camera: &mut Camera, args: &Args) {
    resize(camera, args.width, args.height);
    if let Some(crop) = args.crop {
        camera.film.crop = Some(crop);
    }
}

/// Sets the size of the film; one number alone keeps the aspect.
pub(crate) fn resize(camera: &mut Camera, width: Option<u32>, height: Option<u32>) {
    let film = &mut camera.film;
    let scaled = |x: u32, to: u32, from: u32| {
        ((u64::from(x) * u64::from(to) + u64::from(from) / 2) / u64::from(from)).clamp(1, u64::from(MAX_SIZE)) as u32
    };
    let (width, height) = match (width, height) {
        (None, None) => (film.width, film.height),
        (Some(w), Some(h)) => (w, h),
        (Some(w), None) => (w, scaled(film.height, w, film.width)),
        (None, Some(h)) => (scaled(film.width, h, film.height), h),
    };
    if (width, height) != (film.width, film.height) {
        (film.width, film.height, film.crop) = (width, height, None);
    }
}

/// Renders with a bar and the time left on standard error, where that is a terminal.
pub(super) fn with_progress<T>(render: impl FnOnce(&(dyn Fn(f64) + Sync)) -> T) -> T {
    const STEPS: u64 = 1000;
    let bar = ProgressBar::new(STEPS);
    if let Ok(style) = ProgressStyle::with_template("{bar:40} {percent:>3} %  {elapsed} passed, {eta} left") {
        bar.set_style(style);
    }
    let out = render(&|share| {
        let position = (share * STEPS as f64) as u64;
        if position > bar.position() {
            bar.set_position(position);
        }
    });
    bar.finish_and_clear();
    out
}
