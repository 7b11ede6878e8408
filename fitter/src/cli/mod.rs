//! The command line: one file per subcommand, each with its arguments as typed and what they mean once validated.

mod albedo;
mod arguments;
mod chart;
mod check;
mod export;
mod family;
mod fit;
mod info;
mod integrate;
mod page;
mod plot;
mod query;
mod report;

use clap::{Parser, Subcommand};
use std::io::{self, ErrorKind::BrokenPipe};
use std::process::ExitCode;

/// Exit code of a check that failed.
const FAILED: u8 = 1;
/// Exit code of bad input or usage.
const REFUSED: u8 = 2;

const EXAMPLES: &str = "\
Examples:
  fitter fit phong:exponent=100 -o phong.tbl     fit, and measure the errors
  fitter check phong.tbl                         measure again, independently
  fitter info phong.tbl                          what is in it, how good it is
  fitter fit-family ggx -o families              the tables of GGX of any roughness
  fitter plot phong.tbl -o phong.svg             polar cuts, exact against table
  fitter chart phong:exponent=100 -o chart.svg   speed against accuracy
  fitter report gold.binary -o gold.html         which model explains measured data
  fitter export phong.tbl --to npy -o phong.npy  values on a grid, for shaders and scripts
  fitter albedo ggx -o split-sum.exr             directional albedo over roughness

  (echo theta_e,phi_e,omega,wo_x,wo_y,wo_z; echo 0.8,0,0.1,-0.6,0,0.8) |
      fitter query phong.tbl

Angles are in radians unless a name ends in -deg, solid angles in steradians.
Directions are unit vectors in the local frame, z along the surface normal, and
point away from the surface.

Exit codes: 0 done, 1 a check failed, 2 bad input or usage.";

/// Turn a material into a small table of its mean BRDF over spherical caps, and prove how good it is
#[derive(Parser)]
#[command(name = "fitter", version, subcommand_required = true, arg_required_else_help = true, after_help = EXAMPLES)]
#[command(max_term_width = 100)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Fit(fit::Args),
    FitFamily(family::Args),
    Check(check::Args),
    Query(query::Args),
    Integrate(integrate::Args),
    Info(info::Args),
    Plot(plot::Args),
    Chart(chart::Args),
    Report(page::Args),
    Export(export::Args),
    Albedo(albedo::Args),
}

/// How a command that did its work ended.
enum Outcome {
    Done,
    CheckFailed,
}

/// Parses the command line, runs it, and reports an error in one line.
pub fn main() -> ExitCode {
    kit::watch();
    let cli: Cli = match kit::parse("fitter") {
        Ok(cli) => cli,
        Err(code) => return code,
    };
    match run(cli.command) {
        Ok(Outcome::Done) => ExitCode::SUCCESS,
        Ok(Outcome::CheckFailed) => ExitCode::from(FAILED),
        // The reader of a pipe has seen enough.
        Err(error) if error.downcast_ref::<io::Error>().is_some_and(|e| e.kind() == BrokenPipe) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("fitter: {}", kit::one_line(&error));
            ExitCode::from(REFUSED)
        }
    }
}

fn run(command: Command) -> anyhow::Result<Outcome> {
    match command {
        Command::Fit(args) => fit::run(args),
        Command::FitFamily(args) => family::run(args),
        Command::Check(args) => check::run(args),
        Command::Query(args) => query::run(args),
        Command::Integrate(args) => integrate::run(args),
        Command::Info(args) => info::run(args),
        Command::Plot(args) => plot::run(args),
        Command::Chart(args) => chart::run(args),
        Command::Report(args) => page::run(args),
        Command::Export(args) => export::run(args),
        Command::Albedo(args) => albedo::run(args),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn definition_is_consistent() {
        Cli::command().debug_assert();
    }
}
