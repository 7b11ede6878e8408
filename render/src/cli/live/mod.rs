//! `render view`.

mod audience;
mod guard;
mod records;
mod server;
mod socket;

use super::choices::{VIEWS, choices};
use super::denoise::Denoising;
use super::method::Method;
use super::reading::Reading;
use crate::chart::setting::parse_tau;
use anyhow::{Context, Error, Result, anyhow, ensure};
use audience::Page;
use clap::ValueEnum;
use guard::Token;
use kit::number::{number, whole};
use kit::output::Outputs;
use records::Records;
use render::cache::Spacing;
use render::image::view::View;
use render::integrator::cached::policy::Policy;
use render::integrator::cached::{Interpolation, Settings, TOLERANCE, kept_pixels};
use render::live::{Desk, Engine, Menu, Options, Session, TAUS};
use render::picture::{Budget, require_memory};
use render::record::eas::Estimator;
use render::scene::load::{self, Loaded};
use render::scene::{Film, Projection};
use render::tables::Tables;
use render::world::World;
use server::Server;
use std::collections::HashSet;
use std::net::{Ipv4Addr, TcpListener};
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;

/// What `--help` teaches.
pub const LONG_ABOUT: &str = "\
Walk through a scene in a browser, while its caches fill. The command prints the address of a page, which it serves to this machine \
and to whoever knows the address only; Ctrl-C ends it.

Drag to look around, walk with W A S D, turn the wheel or pinch to go ahead. Frames are as large as the time allows while the camera \
moves. When it stands still, the picture becomes that of `render image` with the same options. The page saves views and records \
walks as paths for `render walk`.";

/// Pixels along the longer side of a film that nobody asked for.
const LONGEST: u32 = 512;
/// Bytes of records from which on no more are made.
const MOST_BYTES: usize = 1 << 30;

/// Arguments of `render view`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Scene: Mitsuba XML or glTF; or a model (OBJ, PLY, STL).
    scene: PathBuf,
    /// Port of the page on 127.0.0.1 [default: one that is free].
    #[arg(long, value_name = "N", value_parser = whole(1..=u16::MAX, ""))]
    port: Option<u16>,
    /// How to render at first; the page has all methods.
    #[arg(long, value_enum, default_value_t = Method::Auto)]
    method: Method,
    /// Quality of records at first, the paper's tau: smaller is better and slower [default: 0.1].
    #[arg(long, value_name = "TAU", value_parser = parse_tau())]
    tau: Option<f32>,
    /// Samples per pixel of the picture of a camera that stands still [default: what the scene asks for].
    #[arg(long, value_name = "N", value_parser = whole(1..=1u32 << 22, ""))]
    spp: Option<u32>,
    /// Keep the records of the first method at the first tau in this file: read where it exists, written at the end.
    #[arg(long, value_name = "FILE")]
    cache: Option<PathBuf>,
    /// Write the walk that is recorded last to this file too: a path for `render walk`.
    #[arg(long, value_name = "FILE.csv")]
    record: Option<PathBuf>,
    /// Width of the film in pixels; alone, it keeps the aspect [default: the scene's, at most 512 pixels along the longer side].
    #[arg(long, value_parser = whole(1..=Film::MAX_SIZE, ""))]
    width: Option<u32>,
    /// Height of the film in pixels; alone, it keeps the aspect.
    #[arg(long, value_parser = whole(1..=Film::MAX_SIZE, ""))]
    height: Option<u32>,
    /// Brighten the picture by so many stops at first.
    #[arg(long, value_name = "EV", default_value_t = 0.0, value_parser = number(-16.0..=16.0f32, "a number of stops from -16 to 16"))]
    exposure: f32,
    /// How the page shows light that is brighter than a screen, at first [default: agx].
    #[arg(long, value_parser = choices(&VIEWS))]
    view: Option<View>,
    #[command(flatten)]
    denoising: Denoising,
    /// Folder of fitted tables; what is missing is fitted and kept there.
    #[arg(long, value_name = "DIR", default_value = "tables")]
    tables: PathBuf,
    #[command(flatten)]
    reading: Reading,
    /// Largest number of path segments, 1 = emitters only [default: the scene's].
    #[arg(long, value_name = "N", value_parser = whole(1..=u32::MAX, "; leave it out for the scene's own"))]
    max_depth: Option<u32>,
    /// Number of threads [default: all cores].
    #[arg(long, value_name = "N", value_parser = whole(1..=1024u16, ""))]
    threads: Option<u16>,
    /// Seed of the sample points.
    #[arg(long, default_value_t = 0, value_parser = whole(0..=u64::MAX, ""))]
    seed: u64,
}

/// τ of a view where nobody asked for one: it fills in about a second.
const TAU: f32 = 0.1;

/// Loads, serves the page, draws until it is told to end.
pub fn run(args: &Args) -> Result<ExitCode> {
    let tau = args.tau.unwrap_or(TAU);
    ensure!(args.method != Method::Path || args.tau.is_none(), "--tau needs a --method with records to begin with");
    ensure!(args.method != Method::Path || args.cache.is_none(), "--cache needs a --method with records to begin with");
    ensure!((TAUS[0]..=TAUS[1]).contains(&tau), "--tau: a view has tau from {} to {}", TAUS[0], TAUS[1]);
    outputs(args, &[])?;
    let port = args.port.unwrap_or(0);
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port)).map_err(|e| match e.kind() {
        std::io::ErrorKind::AddrInUse => {
            anyhow!("--port {port} is taken: name another, or leave it out for a free one")
        }
        _ => anyhow!("--port {port}: {e}"),
    })?;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(args.threads.unwrap_or(0).into()).build()?;
    let denoiser = args.denoising.open(true, pool.current_num_threads())?;
    let place = || args.scene.display().to_string();
    let Loaded { mut scene, warnings, files, fov_axis, .. } =
        pool.install(|| load::open(&args.scene, &args.reading.options()?).map_err(Error::from))?;
    outputs(args, &files)?;
    for warning in warnings {
        eprintln!("render: warning: {warning}");
    }
    let aspect = f64::from(scene.camera.film.width) / f64::from(scene.camera.film.height);
    match (args.width, args.height) {
        (None, None) => scene.camera.film = scene.camera.film.at_most(LONGEST),
        (width, height) => scene.camera.film.resize(width, height),
    }
    let lens = scene.camera.lens.is_some();
    let kept = kept_pixels(scene.camera.film.window(), false);
    require_memory(&scene.camera, kept, lens, denoiser.is_some()).map_err(Error::msg).with_context(place)?;
    scene.integrator.max_depth = args.max_depth.unwrap_or(scene.integrator.max_depth);
    let world = pool.install(|| World::new(scene)).with_context(place)?;

    let spp = args.spp.unwrap_or(world.scene.integrator.spp);
    let settings = Settings {
        tolerance: Some(tau),
        estimator: Estimator::default(),
        spacing: Spacing { hessian: true, adaptive: None },
        sources: None,
        interpolation: Interpolation::default(),
        budget: Budget::Samples(spp),
        seed: args.seed,
        indirect_only: false,
    };
    let mut decide = Decide { tables: Tables::open(&args.tables)?, world: &world, told: HashSet::new() };
    let mut records = Records::default();
    if let (Some(path), Some(allowed)) = (&args.cache, args.method.allowed(tau)) {
        let policy = Policy::new(&world.scene, allowed, |recipe| decide.tables.find(recipe))?;
        records = Records::open(path, &world, &policy, &settings, tau)?;
    }
    let menu = menu(args, &world, denoiser.as_ref().map(|d| d.name().to_owned()));
    let engine = Method::value_variants().iter().position(|method| *method == args.method).unwrap_or(0);
    let view = args.view.unwrap_or(View::Agx);
    let options = Options {
        engines: Method::value_variants().iter().map(engine_of).collect(),
        engine,
        settings,
        tolerance: tau,
        spp,
        stops: args.exposure,
        view,
        denoise: false,
        denoiser,
        fov: (fov_axis, aspect),
        most_bytes: MOST_BYTES,
    };
    let desk = Arc::new(Desk::default());
    let (mut page, hall) = Page::open(args.record.clone());
    let server = Server::start(listener, Token::new()?, menu, Arc::clone(&desk), hall)?;
    let leaving = Arc::clone(&desk);
    kit::stop_with(move || leaving.leave());
    eprintln!("render: open this address in a browser on this machine; Ctrl-C ends the view");
    println!("{}", server.address());
    let caches = records.take();
    let mut prepare = |engine: &Engine, tolerance: f32| decide.policy(engine, tolerance);
    let caches = pool.install(|| Session::new(&world, options, caches, &desk, &mut prepare, &mut page).run());
    let kept = caches.map_or(Ok(()), |caches| records.save(caches));
    let recorded = page.close();
    server.stop();
    kept.and(recorded)?;
    Ok(ExitCode::SUCCESS)
}

/// Refuses outputs that cannot be written, and inputs among them.
fn outputs(args: &Args, read: &[PathBuf]) -> Result<()> {
    let named = [args.scene.as_path()].into_iter().chain(args.reading.files());
    let mut outputs = Outputs::beside(named.chain(read.iter().map(PathBuf::as_path)));
    if let Some(path) = &args.record {
        outputs.file_of(path, &["csv"])?;
    }
    if let Some(path) = &args.cache {
        outputs.file(path)?;
    }
    Ok(())
}

fn engine_of(method: &Method) -> Engine {
    Engine { name: method.name().into(), cached: method.allowed(TOLERANCE).is_some() }
}

/// What the page offers.
fn menu(args: &Args, world: &World, denoiser: Option<String>) -> Menu {
    let name = |path: &PathBuf| path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let about = |method: &Method| method.to_possible_value().and_then(|v| v.get_help().map(ToString::to_string));
    let camera = &world.scene.camera;
    let window = camera.film.window();
    Menu {
        scene: name(&args.scene),
        methods: Method::value_variants().iter().map(|m| [m.name().into(), about(m).unwrap_or_default()]).collect(),
        interpolations: Interpolation::available(),
        denoiser,
        record: args.record.as_ref().map(name),
        taus: TAUS,
        size: [window.width, window.height],
        fov: match camera.projection {
            Projection::Perspective { fov_x } => fov_x,
            Projection::Orthographic { .. } => 0.0,
        },
    }
}

/// Decides on materials, and tells what it has not told before.
struct Decide<'a> {
    tables: Tables,
    world: &'a World,
    told: HashSet<String>,
}

impl Decide<'_> {
    fn policy(&mut self, engine: &Engine, tolerance: f32) -> Result<Policy, String> {
        let method = Method::from_str(&engine.name, false).ok();
        let allowed = method.and_then(|method| method.allowed(tolerance)).ok_or("this method keeps no records")?;
        let policy = Policy::new(&self.world.scene, allowed, |recipe| self.tables.find(recipe));
        let policy = policy.map_err(|error| error.to_string())?;
        for note in self.tables.notes.iter().chain(&policy.notes) {
            if self.told.insert(note.clone()) {
                eprintln!("render: {note}");
            }
        }
        Ok(policy)
    }
}
