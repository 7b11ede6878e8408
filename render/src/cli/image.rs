//! `render image`.

use super::choices::{BASES, ESTIMATORS, GRADIENTS, choices};
use super::lens::Optics;
use super::look::{self, Looking};
use super::method::{Method, Reach};
use super::options;
use super::outputs::{self, Records};
use super::reading::Reading;
use super::view::{self, parse_crop};
use crate::chart::setting::{parse_tau, parse_time};
use anyhow::{Context, Error, Result};
use kit::number::{number, whole};
use kit::with_progress;
use render::cache::Spacing;
use render::film::render;
use render::integrator::PathTracer;
use render::integrator::cached::file::{self, CacheFileError};
use render::integrator::cached::policy::{Allowed, Policy};
use render::integrator::cached::{Figures, Settings, TOLERANCE, render_cached};
use render::picture::{Budget, Picture, require_memory};
use render::record::eas::Estimator;
use render::record::harmonics::{Basis, Gradients, HarmonicsSettings, MAX_ORDER};
use render::scene::{Crop, Film, Scene, load};
use render::tables::Tables;
use render::world::{Counts, World};
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::{Duration, Instant};

/// About what it takes to compress and write a pixel of each format; `--time` sets it aside.
const EXR_SECONDS: f64 = 1.6e-6;
const SCREEN_SECONDS: f64 = 3e-7;

/// Arguments of `render image`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Scene: Mitsuba XML or glTF; or a model (OBJ, PLY, STL), for a quick look.
    pub(super) scene: PathBuf,
    /// Picture to write; may be given for each format. .exr: linear light with layers; .png, .webp (lossless) and .jpg: as a screen
    /// shows it (see --view).
    #[arg(short, long, value_name = "OUT", required = true)]
    pub(super) output: Vec<PathBuf>,
    /// How to render.
    #[arg(long, value_enum, default_value_t = Method::Path)]
    pub(super) method: Method,
    /// How EAS are moved and summed: the published way, or ours [default: improved].
    #[arg(long, value_parser = choices(&ESTIMATORS))]
    pub(super) eas: Option<Estimator>,
    /// Sources of every EAS record, instead of as few as tau allows; a tree has 7, 10, 13… of them.
    #[arg(long, value_name = "N", value_parser = whole(7..=4096u16, ""))]
    pub(super) sources: Option<u16>,
    /// Harmonics of every view, instead of the least that lose no more of its lobe than tau allows; no view is path traced then.
    #[arg(long, value_name = "N", value_parser = whole(1..=MAX_ORDER as u8, ""))]
    pub(super) order: Option<u8>,
    /// How harmonic records change with position [default: analytic].
    #[arg(long, value_parser = choices(&GRADIENTS))]
    pub(super) gradients: Option<Gradients>,
    /// Which harmonics: in the frame of the record, or in that of the world [default: hemispherical].
    #[arg(long, value_parser = choices(&BASES))]
    pub(super) basis: Option<Basis>,
    /// What decides how far records reach [default: hessian, distance with --eas paper].
    #[arg(long, value_enum)]
    pub(super) radius: Option<Reach>,
    /// Records that differ by more than this fraction where they overlap reach less far (adaptive caching).
    #[arg(long, value_name = "FRACTION", num_args = 0..=1, default_missing_value = "0.03", value_parser = number(0.001..=1.0f32, "a fraction from 0.001 to 1"))]
    pub(super) adaptive: Option<f32>,
    /// Quality of a cached rendering, the paper's tau: rays, spacing and number of sources follow
    /// [default: 0.02, or what --time allows].
    #[arg(long, value_name = "TAU", value_parser = parse_tau())]
    pub(super) tau: Option<f32>,
    /// Folder of fitted tables; what is missing is fitted and kept there [default: tables].
    #[arg(long, value_name = "DIR")]
    pub(super) tables: Option<PathBuf>,
    /// Keep records in this file: read where it exists, written at the end. The same camera gives the same picture.
    #[arg(long, value_name = "FILE", conflicts_with = "time")]
    pub(super) cache: Option<PathBuf>,
    /// Samples per pixel [default: what the scene asks for].
    #[arg(long, value_name = "N", conflicts_with_all = ["time", "error"], value_parser = whole(1..=1u32 << 22, ""))]
    spp: Option<u32>,
    /// Seconds for everything but loading.
    #[arg(long, value_name = "SECONDS", conflicts_with = "error", value_parser = parse_time())]
    time: Option<f64>,
    /// Stop at this relative error: the root of the estimated rel_mse.
    #[arg(long, value_name = "RELATIVE", value_parser = number(f32::MIN_POSITIVE..=f32::MAX, "a number > 0"))]
    pub(super) error: Option<f32>,
    /// Width of the film in pixels; alone, it keeps the aspect.
    #[arg(long, value_parser = whole(1..=Film::MAX_SIZE, ""))]
    width: Option<u32>,
    /// Height of the film in pixels; alone, it keeps the aspect.
    #[arg(long, value_parser = whole(1..=Film::MAX_SIZE, ""))]
    height: Option<u32>,
    /// Render a part of the film only: x,y,width,height in pixels from the top left.
    #[arg(long, value_name = "X,Y,W,H", value_parser = parse_crop)]
    crop: Option<Crop>,
    #[command(flatten)]
    pub(super) optics: Optics,
    #[command(flatten)]
    pub(super) looking: Looking,
    #[command(flatten)]
    pub(super) reading: Reading,
    /// Largest number of path segments, 1 = emitters only [default: the scene's].
    #[arg(long, value_name = "N", value_parser = whole(1..=u32::MAX, "; leave it out for the scene's own"))]
    max_depth: Option<u32>,
    /// Leave out light that is scattered less than twice.
    #[arg(long)]
    indirect_only: bool,
    /// Number of threads [default: all cores].
    #[arg(long, value_name = "N", value_parser = whole(1..=1024u16, ""))]
    threads: Option<u16>,
    /// Seed of the sample points.
    #[arg(long, default_value_t = 0, value_parser = whole(0..=u64::MAX, ""))]
    seed: u64,
    /// Write figures of the run.
    #[arg(long, value_name = "FILE.json")]
    pub(super) stats: Option<PathBuf>,
    /// Write the rendering with its records: dots, and the circles they reach. EAS or harmonics red, irradiance green, coarse
    /// irradiance blue.
    #[arg(long, value_name = "OUT.png")]
    pub(super) show_records: Option<PathBuf>,
}

/// Renders through caches; tells what it does with each material.
fn cached(
    args: &Args,
    world: &World,
    budget: Budget,
    pool: &rayon::ThreadPool,
    stats: &mut Stats,
) -> Result<(Picture, Records)> {
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
    let mut tables = Tables::open(args.tables.as_deref().unwrap_or(Path::new("tables")))?;
    let deciding = Instant::now();
    let policy = pool.install(|| Policy::new(&world.scene, allowed, |recipe| tables.find(recipe)))?;
    let fitting = if policy.projection.is_some() { deciding.elapsed() } else { tables.fitting };
    for note in tables.notes.iter().chain(&policy.notes) {
        eprintln!("render: {note}");
    }
    let estimator = args.eas.unwrap_or_default();
    let settings = Settings {
        tolerance: args.tau,
        estimator,
        spacing: Spacing {
            hessian: args.radius.unwrap_or(Reach::of(estimator)) == Reach::Hessian,
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
        pool.install(|| with_progress("image", |progress| render_cached(world, &policy, &settings, kept, progress)));
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
    Ok((picture, Records { policy, settings, tolerance, caches }))
}

/// What `--stats` says; the keys of the cache stay zero without one.
#[derive(Debug, Default, Serialize)]
pub(super) struct Stats {
    method: &'static str,
    pub(super) seconds: Seconds,
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
pub(super) struct Seconds {
    load: f64,
    fit: f64,
    fill: f64,
    shade: f64,
    pub(super) write: f64,
    pub(super) total: f64,
}

/// Loads, renders, writes.
pub fn run(args: &Args) -> Result<ExitCode> {
    let start = Instant::now();
    options::check(args)?;
    outputs::check(args)?;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(args.threads.unwrap_or(0).into()).build()?;
    let (mut scene, warnings) = load::load(&args.scene, &args.reading.options()?)?;
    for warning in warnings {
        eprintln!("render: warning: {warning}");
    }
    view::change(&mut scene.camera, args.width, args.height, args.crop);
    look::check_size(&args.output, &scene.camera.film)?;
    let lens = args.optics.check(&scene.camera)?;
    require_memory(&scene.camera, !matches!(args.method, Method::Path), lens)
        .map_err(Error::msg)
        .with_context(|| args.scene.display().to_string())?;
    scene.integrator.hide_environment = args.looking.transparent;
    if let Some(depth) = args.max_depth {
        scene.integrator.max_depth = depth;
    }
    let budget = budget(args, &scene);
    let mut world = pool.install(|| World::new(scene)).with_context(|| args.scene.display().to_string())?;
    if let Some(focus) = args.optics.apply(&mut world)? {
        eprintln!("render: focused at {focus}, on what the middle of the picture shows");
    }
    let look = args.looking.look();
    let load_seconds = start.elapsed().as_secs_f64();
    let mut stats = Stats { method: args.method.name(), threads: pool.current_num_threads(), ..Stats::default() };
    stats.seconds.load = load_seconds;
    let (picture, records) = match args.method {
        Method::Path => {
            let shading = Instant::now();
            let integrator = PathTracer { settings: world.scene.integrator, indirect_only: args.indirect_only };
            let picture = pool.install(|| {
                with_progress("image", |progress| render(&world, &integrator, budget, args.seed, progress))
            });
            stats.seconds.shade = shading.elapsed().as_secs_f64();
            (picture, None)
        }
        _ => {
            let (picture, records) = cached(args, &world, budget, &pool, &mut stats)?;
            (picture, Some(records))
        }
    };
    let Counts { rays, paths, not_finite } = picture.counts;
    (stats.rays, stats.not_finite, stats.spp) = (rays, not_finite, picture.spp);
    if let Some(warning) = not_finite_warning(not_finite, paths) {
        eprintln!("render: warning: {warning}");
    }
    outputs::write(args, &world, &picture, &look, records.as_ref(), &mut stats, start)?;
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
            let per_pixel = EXR_SECONDS * exrs as f64 + SCREEN_SECONDS * (args.output.len() - exrs) as f64;
            let writing = per_pixel * f64::from(film.width) * f64::from(film.height);
            Budget::Time(Duration::from_secs_f64(seconds - writing.min(0.5 * seconds)))
        }
        (_, _, Some(error)) => Budget::Error(error),
        (spp, ..) => Budget::Samples(spp.unwrap_or(scene.integrator.spp)),
    }
}
