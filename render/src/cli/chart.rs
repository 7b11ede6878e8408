//! `render chart`.

use super::denoise::Denoising;
use super::reading::Reading;
use crate::chart::method::{Engine, METHODS, Method, Size, find};
use crate::chart::plan::{Plan, Reference};
use crate::chart::setting::{Setting, parse_tau, parse_time};
use anyhow::{Context, Result, bail, ensure};
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use kit::number::{number, whole};
use render::integrator::cached::TOLERANCE;
use render::record::harmonics::MAX_ORDER;
use render::scene::Film;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// What is charted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Suite {
    /// Every method at one quality over the scenes in which caches tend to fail, and a verdict on each.
    Stability,
}

const EXAMPLES: &str = "\
Examples:
  render chart tests/scenes/cornell-glossy.xml -o chart
      a reference, then path tracing and the caches at several times and qualities; open chart/index.html
  render chart a.xml b.xml --reference a.exr --reference b.exr --methods path,eas --times 1,10 -o chart
  render chart --suite stability -o stability
      the scenes of tests/scenes/failure

Writes into DIR: index.html (all of it in one file), chart.csv, figures/*.svg, pictures/*.png, references/*.exr.
A run that was interrupted goes on where it stopped: what chart.csv has is not run again.";

/// Arguments of `render chart`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    /// Scenes: Mitsuba XML or glTF, or folders of them.
    #[arg(required_unless_present = "suite")]
    scenes: Vec<PathBuf>,
    /// Folder for the results; made where it is missing.
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// A set of scenes and settings.
    #[arg(long, value_enum)]
    suite: Option<Suite>,
    /// Converged picture of a scene, once for each in their order [default: path traced, and kept in DIR].
    #[arg(long, value_name = "REF.exr")]
    reference: Vec<PathBuf>,
    /// Where the reference does not come from a file: the relative error at which it ends, the root of its rel_mse
    /// [default: 0.015].
    #[arg(long, value_name = "RELATIVE", conflicts_with = "reference", value_parser = number(f64::MIN_POSITIVE..=f64::MAX, "a number > 0"))]
    reference_error: Option<f64>,
    /// About the most seconds for such a reference [default: 240].
    #[arg(long, value_name = "SECONDS", conflicts_with = "reference", value_parser = parse_time())]
    reference_time: Option<f64>,
    /// Methods [default: all but auto, and at the time budgets their denoised twins; all but those for a suite].
    #[arg(long, value_name = "NAME,…", value_delimiter = ',', value_parser = methods())]
    methods: Vec<&'static Method>,
    /// Budgets in seconds, kept by every method [default: 0.5,1,2,4; none for a suite].
    #[arg(long, value_name = "SECONDS,…", value_delimiter = ',', value_parser = parse_time())]
    times: Option<Vec<f64>>,
    /// Qualities of the cached methods, the paper's tau [default: 0.16,0.08,0.04,0.02,0.01; 0.04 for a suite].
    #[arg(long, value_name = "TAU,…", value_delimiter = ',', value_parser = parse_tau())]
    taus: Option<Vec<f32>>,
    /// Orders of harmonics, each for all records of a run at the tau nearest to 0.04 [default: 5,10,15,20,29; none for a suite].
    #[arg(long, value_name = "N,…", value_delimiter = ',', value_parser = whole(1..=MAX_ORDER as u8, ""))]
    orders: Option<Vec<u8>>,
    /// Numbers of EAS, each for all records of a run at the tau nearest to 0.04 [default: 10,16,31,64,127; none for a suite].
    #[arg(long, value_name = "N,…", value_delimiter = ',', value_parser = whole(7..=4096u16, ""))]
    sources: Option<Vec<u16>>,
    /// Samples per pixel of the runs that have no time budget [default: 64].
    #[arg(long, value_name = "N", value_parser = whole(1..=1u32 << 16, ""))]
    spp: Option<u32>,
    /// Width of the film in pixels; keeps the aspect [default: the scene's; 64 for a suite].
    #[arg(long, value_parser = whole(1..=Film::MAX_SIZE, ""))]
    width: Option<u32>,
    #[command(flatten)]
    denoising: Denoising,
    #[command(flatten)]
    reading: Reading,
    /// Folder of fitted tables; what is missing is fitted and kept there [default: tables].
    #[arg(long, value_name = "DIR")]
    tables: Option<PathBuf>,
    /// Leave out light that is scattered less than twice.
    #[arg(long)]
    indirect_only: bool,
    /// Number of threads [default: all cores].
    #[arg(long, value_name = "N", value_parser = whole(1..=1024u16, ""))]
    threads: Option<u16>,
    /// Seed of the sample points.
    #[arg(long, default_value_t = 0, value_parser = whole(0..=u64::MAX, ""))]
    seed: u64,
}

/// Names of methods.
fn methods() -> impl TypedValueParser<Value = &'static Method> {
    let names = METHODS.iter().map(|m| PossibleValue::new(m.name).help(m.about));
    PossibleValuesParser::new(names).map(|name| find(&name).expect("one of the names"))
}

/// Scenes of the suite, from the project's folder.
const FAILURE: &str = "tests/scenes/failure";

/// Checks, runs.
pub fn run(args: Args) -> Result<ExitCode> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(args.threads.unwrap_or(0).into()).build()?;
    let plan = plan(args)?;
    pool.install(|| crate::chart::run(&plan))?;
    println!("{}", plan.output.join("index.html").display());
    Ok(ExitCode::SUCCESS)
}

fn plan(args: Args) -> Result<Plan> {
    let stability = args.suite == Some(Suite::Stability);
    let mut named = args.scenes;
    if named.is_empty() {
        ensure!(
            Path::new(FAILURE).is_dir(),
            "{FAILURE}: there is no such folder here; run in the project's folder, or name scenes"
        );
        named.push(FAILURE.into());
    }
    let mut scenes = Vec::new();
    for path in named {
        if path.is_dir() {
            scenes.extend(scenes_of(&path)?);
        } else {
            scenes.push(path);
        }
    }
    ensure!(
        args.reference.is_empty() || args.reference.len() == scenes.len(),
        "--reference: {} given for {} scenes",
        args.reference.len(),
        scenes.len()
    );
    let methods = match args.methods {
        m if !m.is_empty() => m,
        _ if stability => METHODS.iter().filter(|m| !m.denoised).collect(),
        _ => METHODS.iter().filter(|m| m.swept && !(m.denoised && args.denoising.is_off())).collect(),
    };
    let twin = methods.iter().find(|m| m.denoised);
    ensure!(
        twin.is_some() || !args.denoising.is_given(),
        "--denoise and --oidn need one of the --methods whose names end in -denoised"
    );
    let denoiser = match twin {
        Some(twin) => {
            ensure!(!args.denoising.is_off(), "--denoise off: {} is denoised", twin.name);
            args.denoising.open(true, args.threads.unwrap_or(0).into())?
        }
        None => None,
    };
    for (i, method) in methods.iter().enumerate() {
        ensure!(methods[..i].iter().all(|m| m.name != method.name), "--methods: {} is there twice", method.name);
    }
    let times = args.times.unwrap_or_else(|| if stability { Vec::new() } else { vec![0.5, 1.0, 2.0, 4.0] });
    let taus =
        args.taus.clone().unwrap_or_else(|| if stability { vec![0.04] } else { vec![0.16, 0.08, 0.04, 0.02, 0.01] });
    ensure!(!(stability && taus.len() > 1), "--taus: the suite compares the methods at one quality");
    let given = Given {
        taus: args.taus.is_some(),
        orders: args.orders.is_some(),
        sources: args.sources.is_some(),
        spp: args.spp.is_some(),
        tables: args.tables.is_some(),
    };
    let plan = Plan {
        orders: args.orders.unwrap_or_else(|| if stability { Vec::new() } else { vec![5, 10, 15, 20, 29] }),
        sources: args.sources.unwrap_or_else(|| if stability { Vec::new() } else { vec![10, 16, 31, 64, 127] }),
        scenes,
        references: args.reference,
        reference: Reference {
            error: args.reference_error.unwrap_or(0.015),
            seconds: args.reference_time.unwrap_or(240.0),
        },
        methods,
        times,
        taus,
        spp: args.spp.unwrap_or(64),
        stability,
        width: args.width.or(stability.then_some(64)),
        load: args.reading.options()?,
        denoiser,
        tables: args.tables.unwrap_or("tables".into()),
        seed: args.seed,
        indirect_only: args.indirect_only,
        output: args.output,
        command: command(),
    };
    refuse_unused(&plan, given)?;
    Ok(plan)
}

/// Options that not every method uses, and whether they were given.
struct Given {
    taus: bool,
    orders: bool,
    sources: bool,
    spp: bool,
    tables: bool,
}

/// Refuses options that no run of the plan would use.
fn refuse_unused(plan: &Plan, given: Given) -> Result<()> {
    let cached = |m: &Method| matches!(m.engine, Engine::Cached(..));
    let tabled = |m: &Method| match m.engine {
        Engine::Cached(allowed, ..) => allowed(Setting::Tau(TOLERANCE)).needs_tables(),
        Engine::Traced => false,
    };
    type Uses<'a> = &'a dyn Fn(&Method) -> bool;
    let rules: [(bool, &str, Uses); 4] = [
        (given.taus, "--taus", &cached),
        (given.tables, "--tables", &tabled),
        (given.orders, "--orders", &|m| m.size == Some(Size::Order)),
        (given.sources, "--sources", &|m| m.size == Some(Size::Sources)),
    ];
    for (given, option, uses) in rules {
        if given && !plan.methods.iter().any(|m| uses(m)) {
            let names: Vec<_> = METHODS.iter().filter(|m| uses(m)).map(|m| m.name).collect();
            bail!("{option} needs one of the --methods {}", names.join(", "));
        }
    }
    if given.spp && plan.cells().iter().all(|(_, setting)| matches!(setting, Setting::Time(_))) {
        bail!("--spp needs runs without a time budget, such as those of --taus");
    }
    Ok(())
}

/// Scenes of a folder, by name.
fn scenes_of(folder: &Path) -> Result<Vec<PathBuf>> {
    let place = || folder.display().to_string();
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).with_context(place)? {
        let path = entry.with_context(place)?.path();
        if path.extension().is_some_and(|e| ["xml", "gltf", "glb"].iter().any(|x| e.eq_ignore_ascii_case(x))) {
            found.push(path);
        }
    }
    ensure!(!found.is_empty(), "{}: no scenes in this folder", folder.display());
    found.sort();
    Ok(found)
}

/// What was typed.
fn command() -> String {
    let words = std::env::args_os().skip(1).map(|w| w.to_string_lossy().into_owned());
    let words = words.map(|w| if w.contains([' ', '"']) { format!("{w:?}") } else { w });
    std::iter::once("render".to_owned()).chain(words).collect::<Vec<_>>().join(" ")
}
