//! `fitter export`: a table on a plain grid, or as a shader, for programs that cannot link the library.

use super::{Outcome, arguments};
use crate::export::{self, Nodes};
use anyhow::{Context, bail, ensure};
use brdf_tables::table::Table;
use clap::ValueEnum;
use kit::number::whole;
use kit::output::{self, Outputs};
use std::io::Write;
use std::path::{Path, PathBuf};

const EXAMPLES: &str = "\
Examples:
  fitter export ggx.tbl --to json -o ggx.json
      axes, values, kd and ks, and how to read them
  fitter export ggx.tbl --to npy -o ggx.npy
      the values alone; numpy.load gives theta_e x phi_e x omega x delta x psi
  fitter export ggx.tbl --to exr -o ggx.exr
      the same as a picture of one channel, Y: a row for each (theta_e, phi_e,
      omega), a column for each (delta, psi), the last of each the fastest
  fitter export ggx.tbl --to wgsl -o ggx.wgsl
      the look-up itself as WGSL functions, and beside it ggx.bin, the storage
      buffer that they read; the first lines say how to call and bind them

Axes of the grid, radian and sr (json has their values):
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

/// Write a table on a plain grid, or as a shader, for programs that cannot link the library
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
    /// Zenith angles of caps [default: 10]
    #[arg(long, value_name = "N", value_parser = whole(2..=64u16, ""))]
    theta: Option<u16>,
    /// Solid angles [default: 12]
    #[arg(long, value_name = "N", value_parser = whole(2..=64u16, ""))]
    omega: Option<u16>,
    /// Angles from the mirror direction [default: 24]
    #[arg(long, value_name = "N", value_parser = whole(2..=128u16, ""))]
    delta: Option<u16>,
    /// Azimuths about it [default: 9]
    #[arg(long, value_name = "N", value_parser = whole(2..=64u16, ""))]
    psi: Option<u16>,
    /// Bind group of the buffer, for wgsl [default: 0]
    #[arg(long, value_name = "N", value_parser = whole(0..=15u32, ""))]
    group: Option<u32>,
    /// Binding of the buffer, for wgsl [default: 0]
    #[arg(long, value_name = "N", value_parser = whole(0..=1000u32, ""))]
    binding: Option<u32>,
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
    /// shader functions, and the buffer that they read
    Wgsl,
}

/// Samples the table and writes it.
pub fn run(args: Args) -> anyhow::Result<Outcome> {
    args.threads.apply()?;
    let extension = match args.to {
        To::Npy => "npy",
        To::Exr => "exr",
        To::Json => "json",
        To::Wgsl => "wgsl",
    };
    check_options(&args)?;
    let mut outputs = Outputs::beside([args.file.as_path()]);
    outputs.file_of(&args.output, &[extension])?;
    let buffer = args.output.with_extension("bin");
    if args.to == To::Wgsl {
        ensure!(args.output.extension().is_some(), "{}: a device cannot hold text and buffer", args.output.display());
        outputs.file(&buffer)?;
    }
    let table = arguments::table(&args.file)?;
    if args.to == To::Wgsl {
        return write_shader(&args, &table, &buffer);
    }
    let nodes = [(args.theta, 10), (args.omega, 12), (args.delta, 24), (args.psi, 9)];
    let [theta, omega, delta, psi] = nodes.map(|(asked, default)| usize::from(asked.unwrap_or(default)));
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
        To::Exr | To::Wgsl => export::exr(delta * psi, &grid.values)?,
    };
    output::write(&args.output, &bytes)?;
    let axes: Vec<String> = grid.axes.iter().map(|(name, x)| format!("{name} {}", x.len())).collect();
    writeln!(std::io::stdout().lock(), "{}: {}, {} bytes", args.output.display(), axes.join(" x "), bytes.len())?;
    Ok(Outcome::Done)
}

/// Refuses options that the format has no use for.
fn check_options(args: &Args) -> anyhow::Result<()> {
    let grid = [("--theta", args.theta), ("--omega", args.omega), ("--delta", args.delta), ("--psi", args.psi)];
    let bind = [("--group", args.group), ("--binding", args.binding)];
    if args.to == To::Wgsl {
        if let Some((option, _)) = grid.iter().find(|(_, given)| given.is_some()) {
            bail!("{option} has no use with --to wgsl: a shader looks up the table itself, not a grid of its values");
        }
    } else if let Some((option, _)) = bind.iter().find(|(_, given)| given.is_some()) {
        bail!("{option} needs --to wgsl: only a shader binds a buffer");
    }
    Ok(())
}

/// Writes the functions and the buffer.
fn write_shader(args: &Args, table: &Table, buffer: &Path) -> anyhow::Result<Outcome> {
    let (group, binding) = (args.group.unwrap_or(0), args.binding.unwrap_or(0));
    let name = buffer.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let shader = export::wgsl(table, (group, binding), &name).with_context(|| args.file.display().to_string())?;
    output::write(buffer, &shader.buffer)?;
    output::write(&args.output, shader.text.as_bytes())?;
    let (text, bytes) = (args.output.display(), shader.buffer.len());
    writeln!(std::io::stdout().lock(), "{text}: mean_brdf, and {}: {bytes} bytes to bind", buffer.display())?;
    Ok(Outcome::Done)
}
