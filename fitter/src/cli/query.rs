//! `fitter query`: the whole mean BRDF from a table, row by row.

use super::{Outcome, arguments};
use fitter::rows;
use std::io::{stdin, stdout};
use std::path::PathBuf;

const EXAMPLES: &str = "\
Examples:
  fitter query phong.tbl < caps.csv > values.csv
  (echo theta_e,phi_e,omega,wo_x,wo_y,wo_z; echo 0.8,0,0.1,-0.6,0,0.8) |
      fitter query phong.tbl";

/// Look up caps and directions from CSV
///
/// Reads CSV on standard input and writes the same columns and r,g,b: the whole mean BRDF, diffuse part included, in 1/sr.
#[derive(clap::Args)]
#[command(after_help = format!("{}\n\n{EXAMPLES}", rows::HELP))]
pub struct Args {
    /// Table, as `fitter fit` writes it
    file: PathBuf,
}

/// Answers standard input.
pub fn run(args: Args) -> anyhow::Result<Outcome> {
    let table = arguments::table(&args.file)?;
    rows::answer(stdin().lock(), stdout().lock(), ["r", "g", "b"], |_, cap, wo| table.value(cap, wo))?;
    Ok(Outcome::Done)
}
