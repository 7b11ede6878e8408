//! `fitter report`: which model explains measured data, as a page.

use super::{Outcome, arguments};
use crate::report::{Page, page};
use anyhow::{bail, ensure};
use fitter::explain::{explain, symmetry};
use fitter::measured;
use kit::output::{self, Outputs};
use kit::text::percent;
use std::io::Write;
use std::path::PathBuf;

const EXAMPLES: &str = "\
Examples:
  fitter report gold-metallic-paint.binary -o gold.html
      which model to use for it, and what is lost with it
  fitter report acryl_blue.brdf -o acryl.html
      whether the measurements are enough to draw with

The page says, of each model (lambert, phong, ward, beckmann, ggx, sheen, sgd, abc, lobes):
  its recipe, for fitter fit and scenes, and its relative error, as a whole and by
  the angle of the view; the five errors of its mean BRDF (fitter fit --help);
  the energy by the angle, above 1 in red; a sphere beside that of the data.
Of the data: energy, what changes when directions are exchanged or mirrored, and
how far what a table keeps is from them.";

/// Say which model explains measured data best, and how well, as a page
///
/// One HTML file with its figures and pictures in it.
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    /// Measured data: .binary, .bsdf, .brdf, .csv, .sgd, .abc or .openpbr, as for fitter fit
    file: PathBuf,
    /// Page to write
    #[arg(short, long, value_name = "PAGE.html")]
    output: PathBuf,
    #[command(flatten)]
    threads: arguments::Threads,
}

/// Writes the page, and the ranking to standard output.
pub fn run(args: Args) -> anyhow::Result<Outcome> {
    args.threads.apply()?;
    let name = args.file.display().to_string();
    ensure!(
        measured::is_data(&name),
        "{name}: not measured data (.binary, .bsdf, .brdf, .csv, .sgd, .abc or .openpbr)"
    );
    Outputs::beside([args.file.as_path()]).file_of(&args.output, &["html"])?;
    let (reading, material, notes) = measured::load(&args.file)?;
    let candidates = explain(reading.source.as_ref(), &material);
    let title = args.file.file_name().map_or(name.clone(), |n| n.to_string_lossy().into_owned());
    let symmetry = symmetry(reading.source.as_ref());
    let content =
        Page { title: &title, notes: &notes, data: reading.source.as_ref(), candidates: &candidates, symmetry };
    output::write(&args.output, page(&content)?.as_bytes())?;
    let Some((data, models)) = candidates.split_first() else { bail!("{name}: no model") };
    let mut text = format!("{}: kept to {} %\n", args.output.display(), percent(data.relative));
    for model in models {
        text.push_str(&format!(
            "  {:<9} {:>6} %  {}\n",
            model.name,
            percent(model.relative),
            model.recipe.replace('\n', "; ")
        ));
    }
    std::io::stdout().lock().write_all(text.as_bytes())?;
    Ok(Outcome::Done)
}
