//! What `render image` or a walk is asked for, once every argument has been found to have a meaning.

use super::image::Args;
use super::look;
use super::method::{Method, Reach};
use super::options;
use super::view;
use anyhow::{Context, Error, Result};
use render::cache::Spacing;
use render::denoise::{Denoiser, Effort};
use render::image::Look;
use render::integrator::cached::policy::Allowed;
use render::integrator::cached::{Settings, TOLERANCE, kept_pixels};
use render::outlines;
use render::picture::{Budget, require_memory};
use render::record::harmonics::HarmonicsSettings;
use render::scene::load::{self, Loaded, Options};
use render::scene::{Camera, Film, FovAxis, Scene};
use render::world::World;
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// About what it takes to compress and write a pixel of each format; `--time` sets it aside.
const EXR_SECONDS: f64 = 1.6e-6;
const SCREEN_SECONDS: f64 = 3e-7;

/// What is to be rendered, and how.
pub(super) struct Job {
    pub world: World,
    pub engine: Engine,
    pub budget: Budget,
    /// How well to denoise, if at all.
    pub effort: Option<Effort>,
    pub seed: u64,
    pub indirect_only: bool,
    /// How pictures for a screen look.
    pub look: Look,
    pub views: Views,
}

/// What the file says of views, for cameras that are not its own.
pub(super) struct Views {
    /// Along which axis angles of view are given.
    pub fov_axis: FovAxis,
    /// Width over height of its film.
    pub aspect: f64,
    /// The camera at every frame of its animation, where that was asked for.
    pub track: Vec<Camera>,
}

/// What renders.
pub(super) enum Engine {
    /// The path tracer.
    Traced,
    /// Caches.
    Cached(Caching),
}

/// How caches are used.
pub(super) struct Caching {
    pub allowed: Allowed,
    /// Whether the bases below lobes that are traced are held.
    pub bases: bool,
    pub settings: Settings,
    /// τ that is not left to a budget of time.
    pub tolerance: f32,
    /// Folder of tables.
    pub tables: PathBuf,
    /// File of records.
    pub file: Option<PathBuf>,
}

impl Job {
    /// Loads the scene and puts the arguments to it. `check` looks at the outputs when the files that were read are known.
    ///
    /// # Errors
    /// One line: a scene that cannot be loaded, or an argument that does not fit it.
    pub fn new(
        args: &Args,
        reading: &Options,
        denoiser: Option<&Denoiser>,
        check: impl FnOnce(&[PathBuf]) -> Result<()>,
    ) -> Result<Self> {
        let Loaded { mut scene, warnings, files, fov_axis, track, .. } = load::open(&args.scene, reading)?;
        check(&files)?;
        for warning in warnings {
            eprintln!("render: warning: {warning}");
        }
        let place = || args.scene.display().to_string();
        let film = &scene.camera.film;
        let views = Views { fov_axis, aspect: f64::from(film.width) / f64::from(film.height), track };
        view::change(&mut scene.camera, args.width, args.height, args.crop);
        look::check_size(&args.output, &scene.camera.film)?;
        let lens = args.optics.check(&scene.camera)?;
        let kept = match args.method {
            Method::Path => 0,
            _ => kept_pixels(scene.camera.film.window(), args.time.is_none()),
        };
        let memory = require_memory(&scene.camera, kept, lens, denoiser.is_some());
        memory.map_err(Error::msg).with_context(place)?;
        scene.integrator.hide_environment = args.looking.transparent;
        scene.integrator.soft_terminator = args.soft_terminator;
        if let Some(depth) = args.max_depth {
            scene.integrator.max_depth = depth;
        }
        let mut world = World::new(scene).with_context(place)?;
        let (effort, denoising) = denoising(args, &world, denoiser)?;
        let budget = budget(args, &world.scene, denoising);
        if let Some(focus) = args.optics.apply(&mut world)? {
            eprintln!("render: focused at {focus}, on what the middle of the picture shows");
        }
        let engine = Engine::new(args, budget, denoiser.is_some());
        let look = args.looking.look();
        let (seed, indirect_only) = (args.seed, args.indirect_only);
        Ok(Self { world, engine, budget, effort, seed, indirect_only, look, views })
    }

    /// With `--method auto` and a budget of time that nothing ties to records, turns to path tracing where it is better: for a
    /// single picture of some seconds it is on all eight scenes measured (2 to 10 s) where Open Image Denoise comes after it, on
    /// two of six where ours does, and on none without a denoiser. Tells whether it did.
    pub fn choose(&mut self, args: &Args, denoiser: Option<&Denoiser>) -> bool {
        let timed = matches!(self.budget, Budget::Time(_));
        let neural = denoiser.is_some_and(|d| !d.is_builtin());
        let traces = args.method == Method::Auto && timed && neural && !options::for_records(args);
        if traces {
            self.engine = Engine::Traced;
        }
        traces
    }
}

impl Engine {
    fn new(args: &Args, budget: Budget, denoised: bool) -> Self {
        let tolerance = args.tau.unwrap_or(TOLERANCE);
        let Some(mut allowed) = args.method.allowed(tolerance) else { return Self::Traced };
        if let Allowed::Harmonics(settings) = &mut allowed {
            let (basis, gradients) = (args.basis.unwrap_or_default(), args.gradients.unwrap_or_default());
            *settings = HarmonicsSettings::new(basis, gradients, tolerance, args.order.map(usize::from));
        }
        let estimator = args.eas.unwrap_or_default();
        let hessian = args.radius.unwrap_or(Reach::of(estimator)) == Reach::Hessian;
        let settings = Settings {
            tolerance: args.tau,
            estimator,
            spacing: Spacing { hessian, adaptive: args.adaptive },
            sources: args.sources.map(usize::from),
            budget,
            seed: args.seed,
            indirect_only: args.indirect_only,
            interpolation: args.interpolation.unwrap_or_default(),
        };
        let tables = args.tables.clone().unwrap_or_else(|| "tables".into());
        // Half the error without a denoiser, and more of it with one, which takes noise away but no blotches.
        let bases = allowed != Allowed::Auto || !denoised;
        Self::Cached(Caching { allowed, bases, settings, tolerance, tables, file: args.cache.clone() })
    }
}

/// How well to denoise, and the seconds that it takes, with those of finding out.
fn denoising(args: &Args, world: &World, denoiser: Option<&Denoiser>) -> Result<(Option<Effort>, f64)> {
    let Some(denoiser) = denoiser else { return Ok((None, 0.0)) };
    let Some(seconds) = args.time else { return Ok((Some(Effort::High), 0.0)) };
    let film = world.scene.camera.film.window();
    let start = Instant::now();
    let plan = denoiser.plan(u64::from(film.width) * u64::from(film.height), false, Some(seconds))?;
    let outlines = outlines::seconds(world, seconds - plan.seconds);
    Ok((Some(plan.effort), plan.seconds + outlines + start.elapsed().as_secs_f64()))
}

/// About what it takes to write a picture to these files.
pub(super) fn writing_seconds(files: &[PathBuf], film: &Film) -> f64 {
    let film = film.window();
    let exr = |p: &&PathBuf| p.extension().is_some_and(|e| e.eq_ignore_ascii_case("exr"));
    let exrs = files.iter().filter(exr).count();
    let per_pixel = EXR_SECONDS * exrs as f64 + SCREEN_SECONDS * (files.len() - exrs) as f64;
    per_pixel * f64::from(film.width) * f64::from(film.height)
}

fn budget(args: &Args, scene: &Scene, denoising: f64) -> Budget {
    match (args.spp, args.time, args.error) {
        (_, Some(seconds), _) => {
            let writing = writing_seconds(&args.output, &scene.camera.film);
            Budget::Time(Duration::from_secs_f64(seconds - (writing + denoising).min(0.5 * seconds)))
        }
        (_, _, Some(error)) => Budget::Error(error),
        (spp, ..) => Budget::Samples(spp.unwrap_or(scene.integrator.spp)),
    }
}
