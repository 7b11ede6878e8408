//! `render walk`.

mod cache;
mod files;
mod meter;
mod stats;
mod task;
mod video;

use super::image;
use super::job::{Engine, Job};
use super::method::Method;
use super::options;
use anyhow::{Context, Error, Result, anyhow, bail, ensure};
use files::Files;
use kit::number::number;
use meter::Told;
use render::denoise::{Denoiser, Effort};
use render::integrator::cached::file;
use render::scene::Film;
use render::walk::{FrameNumbers, Walk, read_rows};
use stats::Stats;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;
use task::Task;
use video::Video;

/// What `--help` teaches.
pub const LONG_ABOUT: &str = "\
Draw the frames of a walk: many pictures of one scene through a camera that moves. The caches are filled once for the whole \
path; then every frame only reads them, so that light does not flicker from frame to frame.

A path is a CSV file whose header names the columns frame, eye_x, eye_y, eye_z, look_x, look_y, look_z, up_x, up_y, up_z and fov \
(degrees; it may be left out; a camera of parallel rays may have width, in scene units, instead). Rows may leave out frames: eye, look and up follow smooth curves between them. Or \
camera:NAME@FPS, an animated camera of a glTF file at so many frames per second.

A frame depends on the scene, the path, the options and the cache alone: many machines may draw frames of one walk. Fill the \
cache with --fill-only, draw with --frames-only anywhere, and go on after a loss with --skip-existing.";

/// Samples per pixel of frames from caches, with a denoiser. Measured rel_mse at 1, 4 and 8 samples: .025, .010 and .008 in a staircase
/// of many lamps, .0013, .0008 and .0008 in a glossy box.
const SAMPLES: u32 = 8;

/// Arguments of `render walk`.
#[derive(Debug, clap::Args)]
#[command(
    mut_arg("output", |a| a.required(false).help("Frames to write, as out/####.exr or .png with # for the digits of the number; may be given for each format")),
    mut_arg("time", |a| a.hide(true)),
    mut_arg("show_records", |a| a.hide(true)),
    mut_arg("spp", |a| a.help("Samples per pixel; with a cache, those of direct light [default: what the cache says; 8 with a cache and a denoiser, else what the scene says]")),
    mut_arg("cache", |a| a.help("Keep records in this file: filled for the whole path, and gone on with where it is not")),
    mut_arg("denoise", |a| a.help("Take the grain out of the frames [default: auto]")),
    mut_arg("stats", |a| a.help("Write figures of the walk")),
)]
pub struct Args {
    /// The path of the camera: a CSV file, or camera:NAME@FPS.
    #[arg(long, value_name = "FILE")]
    path: PathBuf,
    /// Frames to draw, as 1-60 or 1,5,9 [default: all of the path]. With --fill-only, the frames to fill for: a part of the
    /// path, to be merged with `render cache merge`.
    #[arg(long, value_name = "A-B")]
    frames: Option<FrameNumbers>,
    /// Mean seconds for a frame, the fill of the caches included: finds tau and the samples per pixel by a trial.
    #[arg(long, value_name = "SECONDS", conflicts_with_all = ["tau", "spp", "error"],
        value_parser = number(1e-3..=1e6f64, "a number of seconds from 0.001 to 1000000"))]
    time_per_frame: Option<f64>,
    /// Fill the cache and draw nothing.
    #[arg(long, requires = "cache", conflicts_with_all = ["frames_only", "skip_existing"])]
    fill_only: bool,
    /// Draw from a cache that is filled, and add nothing to it.
    #[arg(long, requires = "cache")]
    frames_only: bool,
    /// Leave out frames that are there, whole, and of these very settings.
    #[arg(long)]
    skip_existing: bool,
    /// A quarter of the width and height, for a look at the path.
    #[arg(long, conflicts_with = "cache")]
    preview: bool,
    /// Make a video of the frames, which must be PNG too: by ffmpeg, or where that is not installed, say what to run.
    #[arg(long, value_name = "OUT.mp4", conflicts_with = "fill_only")]
    video: Option<PathBuf>,
    /// Frames of the video in a second.
    #[arg(long, value_name = "N", default_value_t = 24.0, requires = "video", value_parser = number(0.1..=1000.0f64, "a number from 0.1 to 1000"))]
    video_fps: f64,
    /// How progress is told.
    #[arg(long, value_enum, default_value_t)]
    progress: Told,
    #[command(flatten)]
    image: image::Args,
}

impl Args {
    /// Refuses options of a single picture.
    fn check(&self) -> Result<()> {
        let Self { image, .. } = self;
        ensure!(self.fill_only || !image.output.is_empty(), "-o is needed: the names of the frames, as out/####.exr");
        ensure!(image.time.is_none(), "--time is for one picture: a walk has --time-per-frame");
        ensure!(image.show_records.is_none(), "--show-records is for one picture: use it with `render image`");
        ensure!(
            !(image.method == Method::Path && self.frames_only),
            "--frames-only needs a cache, and path tracing has none"
        );
        ensure!(
            !(self.frames_only && self.time_per_frame.is_some()),
            "--time-per-frame goes into the cache while it is filled: leave it out with --frames-only"
        );
        ensure!(
            !(self.fill_only && self.frames.is_some() && self.time_per_frame.is_some()),
            "--time-per-frame chooses for the whole path: a part of it is filled at the --tau that you give"
        );
        Ok(())
    }
}

/// Loads, fills, draws.
pub fn run(args: &mut Args) -> Result<ExitCode> {
    let start = Instant::now();
    args.check()?;
    options::check(&args.image)?;
    let files = Files::new(args)?;
    let video = args.video.as_ref().map(|path| Video::new(path, args.video_fps, &args.image.output)).transpose()?;
    let mut reading = args.image.reading.options()?;
    let track = camera_of(&args.path)?;
    if let Some((name, fps)) = &track {
        ensure!(reading.camera.is_none(), "--camera and --path {} both name a camera", args.path.display());
        (reading.camera, reading.track) = (Some(name.clone()), Some(*fps));
    }
    // The same for all frames, whoever draws them and in whatever time.
    let mut effort = Effort::Low;
    // What was chosen for a cache stands in it.
    if let Some(path) = args.image.cache.as_ref().filter(|path| args.frames_only || path.exists()) {
        let info = file::info(path).map_err(|e| anyhow!("{}: {e}", path.display()))?;
        let chosen = info.walk.as_ref().and_then(|walk| walk.chosen);
        ensure!(
            chosen.is_none() || args.time_per_frame.is_none(),
            "{}: --time-per-frame has chosen for this cache already: draw from it with --frames-only, or remove it",
            path.display()
        );
        let reads = args.frames_only || chosen.is_some();
        args.image.tau = args.image.tau.or(Some(info.tau).filter(|_| reads));
        args.image.spp = args.image.spp.or(chosen.map(|chosen| chosen.spp));
        effort = chosen.map_or(effort, |chosen| chosen.effort);
    }
    let pool = rayon::ThreadPoolBuilder::new().num_threads(args.image.threads.unwrap_or(0).into()).build()?;
    let denoiser = args.image.denoising.open(true, pool.current_num_threads())?;
    if args.image.method != Method::Path && denoiser.is_some() {
        args.image.spp = args.image.spp.or((args.time_per_frame.is_none()).then_some(SAMPLES));
    }
    let args = &*args;
    pool.install(|| {
        let Job { mut world, engine, budget, seed, indirect_only, look, views, .. } =
            Job::new(&args.image, &reading, denoiser.as_ref(), |read| files.check(args, read))?;
        let place = || args.path.display().to_string();
        let mut walk = match track {
            Some(_) => Walk::new(0, views.track),
            None => {
                let text = std::fs::read(&args.path).with_context(place)?;
                let rows = read_rows(&text).map_err(Error::msg).with_context(place)?;
                Walk::through(&rows, &world.scene.camera, views.fov_axis, views.aspect)
            }
        }
        .map_err(Error::msg)
        .with_context(place)?;
        if args.preview {
            let Film { width, height, .. } = world.scene.camera.film;
            world.scene.camera.film.resize(Some((width / 4).max(1)), Some((height / 4).max(1)));
        }
        let camera = world.scene.camera.clone();
        walk.change(|frame| (frame.film, frame.lens) = (camera.film.clone(), camera.lens));
        if let Some(note) = denoiser.as_ref().and_then(Denoiser::note) {
            eprintln!("render: frames are denoised by builtin ({note})");
        }
        let mut stats = Stats::new(args.image.method.name(), pool.current_num_threads(), start.elapsed());
        stats.path_frames = walk.frames().end() - walk.frames().start() + 1;
        let mut task =
            Task { args, world, walk, files, look, denoiser, effort, seed, indirect_only, budget, start, stats };
        let frames = task.frames()?;
        video.as_ref().map_or(Ok(()), |_| Video::check(&frames))?;
        match engine {
            Engine::Traced => task.traced(&frames, 0.0)?,
            Engine::Cached(caching) => task.cached(&caching, &frames)?,
        }
        video.map_or(Ok(()), |video| video.make(&frames))?;
        task.finish()
    })
}

/// `camera:NAME@FPS`.
fn camera_of(path: &Path) -> Result<Option<(String, f64)>> {
    let Some(text) = path.to_str().and_then(|text| text.strip_prefix("camera:")) else { return Ok(None) };
    let parts = text.rsplit_once('@').and_then(|(name, fps)| Some((name.to_owned(), fps.parse::<f64>().ok()?)));
    match parts {
        Some((name, fps)) if !name.is_empty() && (1e-3..=1e6).contains(&fps) => Ok(Some((name, fps))),
        _ => bail!("--path camera:{text}: expected camera:NAME@FPS, as in camera:Camera@24"),
    }
}
