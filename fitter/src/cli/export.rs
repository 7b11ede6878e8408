//! `fitter export`: a table on a plain grid, for programs that cannot link the library.

use super::{Outcome, arguments};
use crate::export::{self, Nodes};
use anyhow::{Context, ensure};
use clap::ValueEnum;
use kit::number::whole;
use kit::output::{self, Outputs};
use std::io::Write;
use std::path::PathBuf;

const EXAMPLES: &str = "\
Examples:
  fitter export ggx.tbl --to json -o ggx.json
      axes, values, kd and ks, and how to read them
  fitter export ggx.tbl --to npy -o ggx.npy
      the values alone; numpy.load gives theta_e x phi_e x omega x delta x psi
  fitter export ggx.tbl --to exr -o ggx.exr
      the same as a picture of one channel, Y: a row for each (theta_e, phi_e,
      omega), a column for each (delta, psi), the last of each the fastest

Axes, radian and sr (json has their values):
  theta_e  zenith angle of the cap, even steps from 0 to pi/2
  phi_e    its azimuth: one, or five from 0 to pi/2 where the material is anisotropic
  omega    solid angle, dense near 0, to 2 pi
  delta    angle of the view from the mirror direction of the cap, half of the
           nodes within two lobe widths, to pi
  psi      azimuth of the view about it, 0 to pi (2 pi where anisotropic); 0 leads
           away from the normal within the plane of incidence
The values are the specular mean BRDF at unit strength, 1/sr, and 0 where the view
is below the horizon. Bilinear look-ups in between are as good as the grid is
fine; the library itself has none of their error.";

/// Write a table on a plain grid, for shaders and scripts
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    /// Table, as `fitter fit` writes it
    file: PathBuf,
    /// Format
    #[arg(long, value_name = "FORMAT")]
    to: To,
    /// File to write
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Zenith angles of caps
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = whole(2..=64u16, ""))]
    theta: u16,
    /// Solid angles
    #[arg(long, value_name = "N", default_value_t = 12, value_parser = whole(2..=64u16, ""))]
    omega: u16,
    /// Angles from the mirror direction
    #[arg(long, value_name = "N", default_value_t = 24, value_parser = whole(2..=128u16, ""))]
    delta: u16,
    /// Azimuths about it
    #[arg(long, value_name = "N", default_value_t = 9, value_parser = whole(2..=64u16, ""))]
    psi: u16,
    #[command(flatten)]
    threads: arguments::Threads,
}

/// Formats.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum To {
    /// numpy
    Npy,
    /// OpenEXR
    Exr,
    /// axes and values as text
    Json,
}

/// Samples the table and writes it.
pub fn run(args: Args) -> anyhow::Result<Outcome> {
    args.threads.apply()?;
    let extension = match args.to {
        To::Npy => "npy",
        To::Exr => "exr",
        To::Json => "json",
    };
    Outputs::beside([args.file.as_path()]).file_of(&args.output, &[extension])?;
    let table = arguments::table(&args.file)?;
    let [theta, omega, delta, psi] = [args.theta, args.omega, args.delta, args.psi].map(usize::from);
    let phi = if table.specular().is_some_and(|s| !s.is_isotropic()) { 5 } else { 1 };
    let count = theta * phi * omega * delta * psi;
    const MOST: usize = 1 << 24;
    ensure!(count <= MOST, "{count} values, at most {MOST} are written; ask for fewer nodes");
    let grid = export::grid(&table, Nodes { theta, omega, delta, psi });
    let grid =
        grid.with_context(|| format!("{}: a diffuse material, whose mean BRDF is kd/pi", args.file.display()))?;
    let shape: Vec<usize> = grid.axes.iter().map(|(_, x)| x.len()).collect();
    let bytes = match args.to {
        To::Npy => export::npy(&shape, &grid.values),
        To::Json => export::json(&table, &grid).into_bytes(),
        To::Exr => export::exr(delta * psi, &grid.values)?,
    };
    output::write(&args.output, &bytes)?;
    let axes: Vec<String> = grid.axes.iter().map(|(name, x)| format!("{name} {}", x.len())).collect();
    writeln!(std::io::stdout().lock(), "{}: {}, {} bytes", args.output.display(), axes.join(" x "), bytes.len())?;
    Ok(Outcome::Done)
}
