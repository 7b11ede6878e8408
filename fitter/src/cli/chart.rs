//! `fitter chart`: speed against accuracy of every way to evaluate the mean BRDF.

use super::{Outcome, arguments, fit};
use crate::chart::{Measurement, csv, figure, measure};
use anyhow::ensure;
use fitter::recipe;
use fitter::solver::SolverKind;
use kit::Progress;
use kit::{number::whole, output};
use std::path::{Path, PathBuf};

const EXAMPLES: &str = "\
Examples:
  fitter chart -o chart.svg
      phong:exponent=100 and ggx:alpha=0.1; the numbers go to chart.csv
  fitter chart tables/beckmann-0.2.toml -o beckmann.svg --solvers lm
  fitter chart phong:exponent=20 -o solvers.svg --lobes 3 \\
      --solvers lm,ga,ga-lm,nelder-mead,gauss-newton,bfgs";

/// Chart speed and size against accuracy
///
/// Every point is one method at one setting: its error (rmse_lobe) at random caps of the main domain against a
/// deterministic quadrature, the measured time of one evaluation (batched, one thread, preparation included, median of
/// several runs), and the bytes that its representation takes in a table. One curve per representation and solver, beside
/// exact quadrature and Monte Carlo, as SVG and as CSV of the same name. Times are this machine's: run it on an idle one.
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    /// Materials, one row of the figure each: inline recipes or TOML files
    #[arg(default_values_t = ["phong:exponent=100".to_string(), "ggx:alpha=0.1".to_string()])]
    materials: Vec<String>,
    /// SVG file to write
    #[arg(short, long, value_name = "FIG.svg")]
    output: PathBuf,
    /// Solvers of the lobe curves
    #[arg(long, value_name = "NAME,…", value_delimiter = ',', default_value = "lm,ga,ga-lm", value_parser = fit::solvers())]
    solvers: Vec<SolverKind>,
    /// Most lobes per cell; each lobe curve goes through 1 to this many
    #[arg(long, value_name = "K", default_value_t = 4, value_parser = whole(1..=16u8, ""))]
    lobes: u8,
    /// Random caps at which errors are measured
    #[arg(long, value_name = "N", default_value_t = 60, value_parser = whole(1..=10_000u32, ""))]
    points: u32,
    /// Seed of the caps and of the random solvers
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = whole(0..=u64::MAX, ""))]
    seed: u64,
    #[command(flatten)]
    threads: arguments::Threads,
}

/// Measures and draws.
pub fn run(args: Args) -> anyhow::Result<Outcome> {
    args.threads.apply()?;
    let table = args.output.with_extension("csv");
    arguments::figure(&args.output, args.materials.iter().map(Path::new))?.file(&table)?;
    let mut materials = Vec::new();
    for argument in &args.materials {
        let material = recipe::material(argument)?;
        ensure!(material.specular.is_some(), "{argument}: a diffuse material, whose mean BRDF is the constant kd/pi");
        materials.push((argument, material));
    }
    let progress = Progress::new("chart");
    let mut charts = Vec::new();
    for (i, (argument, material)) in materials.iter().enumerate() {
        let measurement = Measurement {
            material: *material,
            solvers: &args.solvers,
            lobes: usize::from(args.lobes),
            points: args.points as usize,
            seed: args.seed,
            progress: &|fraction| progress.set((i as f64 + fraction) / materials.len() as f64),
            step: &|name| progress.name(format!("chart {argument}: {name}")),
        };
        charts.push(measure(&measurement)?);
    }
    drop(progress);
    // The figure is tried, whatever becomes of the numbers.
    let numbers = output::write(&table, csv(&charts).as_bytes());
    output::write(&args.output, figure(&charts)?.as_bytes())?;
    numbers?;
    Ok(Outcome::Done)
}
