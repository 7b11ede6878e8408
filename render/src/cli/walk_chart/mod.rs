//! `render walk-chart`: how the frames of a walk compare, drawn in several ways at equal time.

mod bars;
mod curves;
mod frame;
mod page;
mod runs;

use anyhow::{Result, ensure};
use clap::Parser;
use frame::Measured;
use kit::number::{number, whole};
use kit::output::{check_folder, write};
use render::walk::FrameNumbers;
use runs::{METHODS, Work};
use std::path::PathBuf;
use std::process::ExitCode;

/// What `--help` says at its end.
const EXAMPLES: &str = "\
Example:
  render walk-chart tests/scenes/cornell-glossy.xml --path tests/scenes/cornell-walk.csv --frames 9,10,39,40 \\
      --time-per-frame 0.5,1 -o chart -- --width 320
      draws these frames from caches and by path tracing, each with a denoiser and without, in half a second and in one;
      prints error, bias and flicker of each; open chart/index.html

Writes into DIR: index.html (all of it in one file), walk.csv, error.svg, bias.svg, flicker.svg, the frames of each method, and
references, which are kept. The caches are filled for the whole path, and have their share of the time.";

/// Options that the chart sets itself.
const SET: [&str; 11] = [
    "-o",
    "--output",
    "--path",
    "--frames",
    "--method",
    "--denoise",
    "--time-per-frame",
    "--spp",
    "--seed",
    "--stats",
    "--tables",
];

/// Arguments of `render walk-chart`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    /// Scene: Mitsuba XML or glTF.
    scene: PathBuf,
    /// The path of the camera: a CSV file, or camera:NAME@FPS.
    #[arg(long, value_name = "FILE")]
    path: PathBuf,
    /// Frames to measure, as 1-60 or 9,10,39,40: flicker needs some that follow each other.
    #[arg(long, value_name = "A-B")]
    frames: FrameNumbers,
    /// Mean seconds for a frame, the fill of the caches included; several are charted apart.
    #[arg(long, value_name = "SECONDS,…", value_delimiter = ',', required = true,
        value_parser = number(1e-3..=1e6f64, "a number of seconds from 0.001 to 1000000"))]
    time_per_frame: Vec<f64>,
    /// Folder for the results; made where it is missing.
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Samples per pixel of each of the two references.
    #[arg(long, value_name = "N", default_value_t = 256, value_parser = whole(2..=1u32 << 22, ""))]
    reference_spp: u32,
    /// Folder of fitted tables, for caches; what is missing is fitted and kept there [default: tables].
    #[arg(long, value_name = "DIR")]
    tables: Option<PathBuf>,
    /// Options of `render walk` for every frame, after `--`: --width 320 -D max_depth=16 --threads 2.
    #[arg(last = true, value_name = "OPTIONS")]
    options: Vec<String>,
}

/// A command line of `render walk`.
#[derive(Debug, Parser)]
#[command(name = "render walk", no_binary_name = true)]
struct WalkLine {
    #[command(flatten)]
    args: super::walk::Args,
}

/// Draws, measures, and writes the page.
pub fn run(args: &Args) -> Result<ExitCode> {
    let mut frames = args.frames.as_slice().to_vec();
    frames.sort_unstable();
    let named = |option: &String| option.split('=').next().unwrap_or_default().to_owned();
    let set = args.options.iter().map(named).find(|o| SET.contains(&o.as_str()));
    ensure!(set.is_none(), "{} is set by the chart: leave it out after --", set.unwrap_or_default());
    check_folder(&args.output)?;
    let work = Work { args, frames };
    work.line(&args.output, &[])?;
    let references = work.references()?;
    let mut measured: Vec<Measured> = Vec::new();
    for &seconds in &args.time_per_frame {
        for method in &METHODS {
            measured.push(work.measure(method, seconds, &references)?);
        }
    }
    write(&args.output.join("walk.csv"), frame::csv(&measured).as_bytes())?;
    page::write(args, &work.frames, &measured, &references)?;
    super::compare::print(&bars::table(&measured))?;
    eprintln!("render: {}", args.output.join("index.html").display());
    Ok(ExitCode::SUCCESS)
}
