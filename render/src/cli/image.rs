//! `render image`.

use super::caching;
use super::choices::{BASES, ESTIMATORS, GRADIENTS, INTERPOLATIONS, choices};
use super::denoise::{self, Denoising};
use super::job::{Engine, Job};
use super::lens::Optics;
use super::look::Looking;
use super::method::{Method, Reach};
use super::options;
use super::outputs;
use super::reading::Reading;
use super::stats::Stats;
use super::view::parse_crop;
use crate::chart::setting::{parse_tau, parse_time};
use anyhow::Result;
use kit::number::{number, whole};
use kit::with_progress;
use render::film::render;
use render::integrator::PathTracer;
use render::integrator::cached::Interpolation;
use render::picture::Picture;
use render::record::eas::Estimator;
use render::record::harmonics::{Basis, Gradients, MAX_ORDER};
use render::scene::{Crop, Film};
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

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
    /// How the equivalent area lights (EAS) of a record are moved to a pixel and summed [default: improved].
    #[arg(long, value_parser = choices(&ESTIMATORS))]
    pub(super) eas: Option<Estimator>,
    /// Equivalent area lights (EAS) in every record: 7, 10, 13, … [default: as few as tau allows].
    #[arg(long, value_name = "N", value_parser = whole(7..=4096u16, ""))]
    pub(super) sources: Option<u16>,
    /// Order of the harmonics: N bands, N² coefficients per channel in every record. The sharper a lobe, the more bands it takes.
    ///
    /// By default each direction to the eye gets the lowest order that keeps the lobe to the accuracy of --tau, and directions
    /// that 29 bands do not hold are path traced. With --order all are drawn from N bands, however blurred: to compare with a
    /// fixed size of record.
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
    /// Who sums the records of a pixel; the picture is the same [default: auto].
    #[arg(long, value_parser = choices(INTERPOLATIONS))]
    pub(super) interpolation: Option<Interpolation>,
    /// Samples per pixel [default: what the scene asks for].
    #[arg(long, value_name = "N", conflicts_with_all = ["time", "error"], value_parser = whole(1..=1u32 << 22, ""))]
    pub(super) spp: Option<u32>,
    /// Seconds for everything but loading, denoising included.
    #[arg(long, value_name = "SECONDS", conflicts_with = "error", value_parser = parse_time())]
    pub(super) time: Option<f64>,
    /// Stop at this relative error: the root of the estimated rel_mse.
    #[arg(long, value_name = "RELATIVE", value_parser = number(f32::MIN_POSITIVE..=f32::MAX, "a number > 0"))]
    pub(super) error: Option<f32>,
    /// Width of the film in pixels; alone, it keeps the aspect.
    #[arg(long, value_parser = whole(1..=Film::MAX_SIZE, ""))]
    pub(super) width: Option<u32>,
    /// Height of the film in pixels; alone, it keeps the aspect.
    #[arg(long, value_parser = whole(1..=Film::MAX_SIZE, ""))]
    pub(super) height: Option<u32>,
    /// Render a part of the film only: x,y,width,height in pixels from the top left.
    #[arg(long, value_name = "X,Y,W,H", value_parser = parse_crop)]
    pub(super) crop: Option<Crop>,
    #[command(flatten)]
    pub(super) denoising: Denoising,
    #[command(flatten)]
    pub(super) optics: Optics,
    #[command(flatten)]
    pub(super) looking: Looking,
    #[command(flatten)]
    pub(super) reading: Reading,
    /// Let light end softly on smooth surfaces of few triangles, whose edges show where it grazes them. Darker there than
    /// the truth of the smooth normals; leave it out where pictures are compared.
    #[arg(long)]
    pub(super) soft_terminator: bool,
    /// Largest number of path segments, 1 = emitters only [default: the scene's].
    #[arg(long, value_name = "N", value_parser = whole(1..=u32::MAX, "; leave it out for the scene's own"))]
    pub(super) max_depth: Option<u32>,
    /// Leave out light that is scattered less than twice.
    #[arg(long)]
    pub(super) indirect_only: bool,
    /// Number of threads [default: all cores].
    #[arg(long, value_name = "N", value_parser = whole(1..=1024u16, ""))]
    pub(super) threads: Option<u16>,
    /// Seed of the sample points.
    #[arg(long, default_value_t = 0, value_parser = whole(0..=u64::MAX, ""))]
    pub(super) seed: u64,
    /// Write figures of the run.
    #[arg(long, value_name = "FILE.json")]
    pub(super) stats: Option<PathBuf>,
    /// Write the rendering with its records: dots, and the circles they reach. EAS or harmonics red, irradiance green, coarse
    /// irradiance blue.
    #[arg(long, value_name = "OUT.png")]
    pub(super) show_records: Option<PathBuf>,
}

/// Loads, renders, writes.
pub fn run(args: &Args) -> Result<ExitCode> {
    let start = Instant::now();
    options::check(args)?;
    outputs::check(args, &[])?;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(args.threads.unwrap_or(0).into()).build()?;
    let denoiser = args.denoising.open(args.time.is_some(), pool.current_num_threads())?;
    let mut job = pool
        .install(|| Job::new(args, &args.reading.options()?, denoiser.as_ref(), |read| outputs::check(args, read)))?;
    let mut stats = Stats::new(args.method.name(), pool.current_num_threads(), start.elapsed());
    if job.choose(args, denoiser.as_ref()) {
        eprintln!(
            "render: auto traces paths: of one picture that is denoised records make no better one, of a walk they do"
        );
    }
    let (mut picture, records) = match &job.engine {
        Engine::Traced => (pool.install(|| traced(&job, &mut stats)), None),
        Engine::Cached(caching) => {
            let (picture, records) = pool.install(|| caching::render(caching, &job.world, &mut stats))?;
            (picture, Some(records))
        }
    };
    stats.count(&picture);
    if let Some(warning) = not_finite_warning(picture.counts.not_finite, picture.counts.paths) {
        eprintln!("render: warning: {warning}");
    }
    let denoised = match (&denoiser, job.effort) {
        (Some(denoiser), Some(effort)) => {
            pool.install(|| denoise::apply(denoiser, effort, &job, &mut picture, &mut stats))
        }
        _ => Ok(()),
    };
    outputs::write(args, &job, &picture, records.as_ref(), &mut stats, start)?;
    denoised.map(|()| ExitCode::SUCCESS)
}

/// Renders by path tracing.
fn traced(job: &Job, stats: &mut Stats) -> Picture {
    let shading = Instant::now();
    let integrator = PathTracer { settings: job.world.scene.integrator, indirect_only: job.indirect_only };
    let picture = with_progress("image", |progress| render(&job.world, &integrator, job.budget, job.seed, progress));
    stats.seconds.shade = shading.elapsed().as_secs_f64();
    picture
}

/// Said where so many paths were dropped that a picture may show it.
pub(super) fn not_finite_warning(dropped: u64, paths: u64) -> Option<String> {
    let too_many = u128::from(dropped) * 1_000_000 > u128::from(paths);
    too_many.then(|| format!("{dropped} of {paths} paths were not finite and count as black: the picture is too dark"))
}
