//! `fitter fit-family`: from a model to the tables of all its members.

use super::{Outcome, arguments, report};
use anyhow::Context;
use brdf_tables::family::{Family, Kin, Store};
use clap::builder::{PossibleValuesParser, TypedValueParser};
use fitter::family::{Options, Plan, fit};
use fitter::fit::TOLERANCE;
use kit::Progress;
use kit::number::{number, whole};
use kit::output::{self, Outputs};
use std::io::Write;
use std::path::PathBuf;
use std::time::Instant;

const EXAMPLES: &str = "\
Examples:
  fitter fit-family ggx -o families
      to families/ggx.fam and families/ggx-anisotropic.fam
  fitter fit-family all -o families
      of every model
  fitter check families/ggx.fam
      whether it keeps its promise, at roughnesses and caps off its nodes";

/// Fit the tables of a model at any roughness (or exponent), and measure their errors
///
/// Writes one file for lobes that are equally wide both ways and, where the model has two roughnesses, another for those
/// that are not. Such a file stands for the tables of all materials of its model, whatever their Fresnel term: `render` needs
/// no fit for them. Each is written at once when it is done.
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    /// Model, or all of them
    #[arg(value_parser = models())]
    model: Models,
    /// Folder to write to, made if it is not there
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Root mean square error over the lobe to reach, as a fraction of the peak
    #[arg(long, value_name = "T", default_value_t = TOLERANCE, value_parser = number(1e-5..=0.5, "a fraction from 0.00001 to 0.5, 0.005 for 0.5 %"))]
    tolerance: f64,
    /// Seed of the members and caps at which errors are measured
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = whole(0..=u64::MAX, ""))]
    seed: u64,
    #[command(flatten)]
    threads: arguments::Threads,
}

/// What is to be fitted.
#[derive(Clone, Debug)]
struct Models(Vec<Kin>);

fn models() -> impl TypedValueParser<Value = Models> {
    let names = Kin::ALL.map(Kin::name).into_iter().chain(["all"]);
    PossibleValuesParser::new(names)
        .map(|name| Models(Kin::ALL.into_iter().filter(|kin| name == "all" || name == kin.name()).collect()))
}

/// Fits, writes and reports one after the other.
pub fn run(args: Args) -> anyhow::Result<Outcome> {
    args.threads.apply()?;
    let plans: Vec<Plan> = (args.model.0.iter())
        .flat_map(|kin| [false, true].into_iter().filter_map(|two_widths| Plan::new(*kin, two_widths)))
        .collect();
    let path = |plan: &Plan| {
        let stem = Family::file_stem(plan.kin, plan.lattice.has_two_widths());
        args.output.join(stem).with_extension(Family::EXTENSION)
    };
    output::check_folder(&args.output)?;
    if args.output.exists() {
        let mut outputs = Outputs::default();
        plans.iter().try_for_each(|plan| outputs.file(&path(plan)))?;
    }
    std::fs::create_dir_all(&args.output).with_context(|| args.output.display().to_string())?;
    for plan in &plans {
        let path = path(plan);
        let progress = Progress::new(format!("fit {}", path.display()));
        let start = Instant::now();
        let family = fit(plan, &options(&args, plan, &|fraction| progress.set(fraction)));
        let seconds = start.elapsed().as_secs_f64();
        drop(progress);
        let bytes = family.to_bytes().with_context(|| path.display().to_string())?;
        output::write(&path, &bytes)?;
        let title = format!("{}: {}, {} bytes, {seconds:.1} s\n", path.display(), representation(&family), bytes.len());
        std::io::stdout().lock().write_all((title + &text(&family)).as_bytes())?;
    }
    Ok(Outcome::Done)
}

/// With the command line of the one family, every argument in it that shapes the bytes.
fn options<'a>(args: &Args, plan: &Plan, progress: &'a (dyn Fn(f64) + Sync)) -> Options<'a> {
    let tolerance =
        if args.tolerance == TOLERANCE { String::new() } else { format!(" --tolerance {}", args.tolerance) };
    let command = format!("fitter fit-family {}{tolerance} --seed {}", plan.kin.name(), args.seed);
    Options { tolerance: args.tolerance, seed: args.seed, command, progress }
}

/// Model and widths.
pub fn name(family: &Family) -> String {
    let lattice = &family.header.lattice;
    let ends = format!("{} to {}", lattice.widths[0], lattice.widths[lattice.intervals()]);
    let of = if family.header.kin == Kin::Phong { "exponent" } else { "roughness" };
    match lattice.reach {
        Some(_) => format!("{}, anisotropic, {of} {ends}, {} cells", family.header.kin.name(), lattice.cells()),
        None => format!("{}, {of} {ends}, {} cells", family.header.kin.name(), lattice.cells()),
    }
}

/// How its tables are stored.
pub fn representation(family: &Family) -> &'static str {
    match family.parts().2 {
        Store::Rules(_) => "cubature",
        Store::Zonal(_) => "zonal",
    }
}

/// Notes and errors.
pub fn text(family: &Family) -> String {
    let header = &family.header;
    let mut text: String = header.notes.iter().map(|note| format!("  {note}\n")).collect();
    let sets = [("at nodes", &header.at_nodes), ("off nodes", &header.off_nodes), ("across horizon", &header.clipped)];
    text.push_str(&report::errors_table(&sets));
    text
}
