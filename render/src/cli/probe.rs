//! `render probe`.

use super::choices::{ESTIMATORS, choices};
use super::reading::Reading;
use crate::chart::setting::parse_tau;
use anyhow::{Context, Result};
use kit::{number::whole, output, with_progress};
use render::cache::Spacing;
use render::hemisphere::hemisphere_directions;
use render::image::{write_png, write_whole};
use render::inspect::disk::{Disk, exposure};
use render::inspect::{Compressed, DIRECTIONS, Place, chart, csv, exact, measure, sweep, tree};
use render::integrator::cached::policy::{Allowed, Policy};
use render::integrator::cached::{Builder, LightSplit, Quality, TOLERANCE};
use render::record::Record;
use render::record::eas::Estimator;
use render::scene::{Film, load};
use render::tables::Tables;
use render::world::World;
use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;

/// Width of the pictures of the disk.
const SIZE: u32 = 256;

/// Reflected radiance is smoother, and every pixel of it is a sum over all samples.
const REFLECTED_SIZE: u32 = 128;

/// Samples of the hemisphere (eas-2015, §3.2).
const SAMPLES: u32 = 4096;

/// Arguments of `render probe`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Writes into DIR, all on the projected disk of the hemisphere, in the record's frame:
  hemisphere.png            the samples (sRGB, exposed so that the brightest hundredth is white)
  tree.svg                  the cut: red outlines filled with mean radiance, grey the comparison level, blue the centroids
  reflected-eas.png         radiance reflected into all directions, from the EAS
  reflected-exact.png       the same from all samples
  reflected-difference.png  the relative difference in false colours: blue 0, green 25 %, red 100 %
  error.csv, error.svg      RMSE/mean over all directions against the number of EAS, both estimators")]
pub struct Args {
    /// Scene: Mitsuba XML or glTF; or a model (OBJ, PLY, STL), for a quick look.
    scene: PathBuf,
    /// Pixel of the whole film, from the top left: the record is made at the very point its middle shows.
    #[arg(long, value_name = "X,Y", value_parser = parse_pixel)]
    pixel: (u32, u32),
    /// Folder for the pictures and figures; made where it is missing.
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Folder of fitted tables; what is missing is fitted and kept there.
    #[arg(long, value_name = "DIR", default_value = "tables")]
    tables: PathBuf,
    /// Quality, the paper's tau: the error at which the cut stops.
    #[arg(long, value_name = "TAU", default_value_t = TOLERANCE, value_parser = parse_tau())]
    tau: f32,
    /// Estimator of the cut and of the reflected radiance; the error curves always show both.
    #[arg(long, value_parser = choices(&ESTIMATORS), default_value = "improved")]
    eas: Estimator,
    /// Width of the film in pixels; keeps the aspect.
    #[arg(long, value_parser = whole(1..=Film::MAX_SIZE, ""))]
    width: Option<u32>,
    /// Seed of the sample points.
    #[arg(long, default_value_t = 0, value_parser = whole(0..=u64::MAX, ""))]
    seed: u64,
    #[command(flatten)]
    reading: Reading,
}

fn parse_pixel(text: &str) -> Result<(u32, u32), String> {
    let pixel = text.split_once(',').and_then(|(x, y)| Some((x.trim().parse().ok()?, y.trim().parse().ok()?)));
    pixel.ok_or_else(|| "expected X,Y: two whole numbers ≥ 0".into())
}

/// Gathers, measures, writes.
pub fn run(args: &Args) -> Result<ExitCode> {
    output::check_folder(&args.output)?;
    let (mut scene, warnings) = load::load(&args.scene, &args.reading.options()?)?;
    for warning in warnings {
        eprintln!("render: warning: {warning}");
    }
    scene.camera.film.resize(args.width, None);
    let world = World::new(scene).with_context(|| args.scene.display().to_string())?;
    let mut tables = Tables::open(&args.tables)?;
    let policy = Policy::new(&world.scene, Allowed::Eas, |recipe| tables.find(recipe))?;
    tables.notes.iter().for_each(|note| eprintln!("render: {note}"));
    let split = LightSplit::new(&world, false);
    let builder = Builder::new(
        &world,
        &world.scene.camera,
        &policy,
        split.held.as_ref(),
        Quality::new(args.tau, Estimator::Improved, Spacing::default()),
        args.seed,
    );
    let probe = with_progress("probe", |progress| builder.probe(args.pixel, SAMPLES, progress))
        .with_context(|| args.scene.display().to_string())?;
    let reflector = probe.reflector();
    let place = Place { position: probe.point.at.p, frame: probe.frame, reflector, albedo: &probe.lobe.albedo };

    // Error against #EAS.
    let quality = Quality::new(args.tau, args.eas, Spacing::default());
    let directions = hemisphere_directions(DIRECTIONS);
    let truth = exact(&probe.uniform, &reflector, &directions, &|_| ());
    let curve = |e| sweep(&place, &tree(&probe.uniform, e), e, quality.directions, &directions, &truth);
    let (paper, improved) = (curve(Estimator::Paper), curve(Estimator::Improved));
    let guided_truth = exact(&probe.guided_samples, &reflector, &directions, &|_| ());
    let most = Quality::new(args.tau, Estimator::Improved, Spacing::default()).cut.max_eas;
    let guided = measure(&probe.guided, &place, Estimator::Improved, most, &directions, &guided_truth);

    // The record of this tolerance.
    let made = Compressed::new(&place, tree(&probe.uniform, args.eas), args.eas, &quality.cut, quality.directions);
    let own = measure(&made.record, &place, args.eas, quality.cut.max_eas, &directions, &truth);
    let radiances: Vec<_> = probe.uniform.iter().map(|s| s.radiance).collect();
    let light = exposure(&radiances);
    let disk = Disk::new(REFLECTED_SIZE);
    let exact_values =
        with_progress("probe", |progress| exact(&probe.uniform, &reflector, &disk.directions(), progress));
    let shown = exposure(&exact_values);
    let exact_image = disk.image(&exact_values, shown);
    let eas_image = disk.image(&made.reflected(&place, &disk.directions()), shown);

    let folder = &args.output;
    std::fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
    let large = Disk::new(SIZE);
    write_png(&folder.join("hemisphere.png"), &large.image(&large.nearest(&probe.uniform), light))?;
    write_whole(&folder.join("tree.svg"), chart::cut_svg(&made, light)?.as_bytes())?;
    write_png(&folder.join("reflected-eas.png"), &eas_image)?;
    write_png(&folder.join("reflected-exact.png"), &exact_image)?;
    write_png(&folder.join("reflected-difference.png"), &disk.difference(&eas_image, &exact_image)?)?;
    write_whole(&folder.join("error.csv"), csv(&paper, &improved).as_bytes())?;
    write_whole(&folder.join("error.svg"), chart::error_svg(&paper, &improved, guided)?.as_bytes())?;

    let name = world.scene.material_names.get(probe.point.material.0 as usize).filter(|n| !n.is_empty());
    let model = reflector.table.header.material.recipe_text();
    let vector = |v: glam::Vec3A| format!("{:.4} {:.4} {:.4}", v.x, v.y, v.z);
    let text = format!(
        "record    made at the point itself\nposition  {}\nnormal    {}\nmaterial  {} ({model})\nsamples   {}\neas       \
        {}\nbytes     {}\neps_g     {:.5}\nerror     {:.5}\nguided    {} EAS, {} bytes, {} samples, error {:.5} against \
        its own samples\n",
        vector(place.position),
        vector(place.frame.normal()),
        name.map_or("unnamed", String::as_str),
        probe.uniform.len(),
        own.eas,
        made.record.bytes(),
        made.cut.error,
        own.error,
        guided.eas,
        guided.bytes,
        probe.guided_samples.len(),
        guided.error,
    );
    // A reader that has seen enough is no error.
    match std::io::stdout().write_all(text.as_bytes()) {
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => Err(e).context("standard output"),
        _ => Ok(ExitCode::SUCCESS),
    }
}
