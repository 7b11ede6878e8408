//! `render cache`.

use anyhow::{Result, anyhow};
use clap::Subcommand;
use kit::output::{Outputs, write};
use render::integrator::cached::file::{self, Chosen, Info};
use std::fmt::Write;
use std::path::PathBuf;
use std::process::ExitCode;

/// Arguments of `render cache`.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Say what a cache file holds, and for which frames of a walk it was filled.
    Info {
        /// A file of `--cache`.
        file: PathBuf,
        /// Print it as JSON.
        #[arg(long)]
        json: bool,
    },
    /// Make one cache of several that were filled for the same scene with the same settings, each for a part of a walk.
    ///
    /// The result does not depend on the order of the files.
    Merge {
        /// Files of `--cache`.
        #[arg(required = true, value_name = "FILE")]
        files: Vec<PathBuf>,
        /// The cache of all of them.
        #[arg(short, long, value_name = "OUT")]
        output: PathBuf,
    },
}

/// Looks into caches, or joins them.
pub fn run(args: &Args) -> Result<ExitCode> {
    match &args.command {
        Command::Info { file, json } => {
            let info = file::info(file).map_err(|e| anyhow!("{}: {e}", file.display()))?;
            let text = if *json { serde_json::to_string(&info)? + "\n" } else { in_words(&info) };
            super::compare::print(&text)?;
        }
        Command::Merge { files, output } => {
            Outputs::beside(files.iter().map(PathBuf::as_path)).file(output)?;
            write(output, &file::merge(files)?)?;
            let info = file::info(output).map_err(|e| anyhow!("{}: {e}", output.display()))?;
            eprintln!("render: {} records of {} files", info.records(), files.len());
        }
    }
    Ok(ExitCode::SUCCESS)
}

/// What a file says of itself, for people.
fn in_words(info: &Info) -> String {
    let Info { bytes, tau, coarse, irradiance, glossy, walk } = info;
    let mut text = format!("tau        {tau}\nrecords    {}, {} KB\n", info.records(), bytes / 1000);
    // Writing to a string does not fail.
    let _ = writeln!(text, "  irradiance {irradiance}, coarse {coarse}");
    for (kind, count) in glossy.iter().filter(|(_, count)| *count > 0) {
        let _ = writeln!(text, "  {kind} {count}");
    }
    if let Some(walk) = walk {
        let ranges: Vec<String> =
            walk.filled.iter().map(|[first, last]| format!("{} to {}", first + 1, last + 1)).collect();
        let ranges = if ranges.is_empty() { "none".into() } else { ranges.join(", ") };
        let _ = writeln!(text, "walk       of {} frames, filled: {ranges} (counted from 1)", walk.frames);
        if let Some((range, done)) = walk.current {
            let _ = writeln!(text, "  in work  {done} of {} frames", range[1] - range[0] + 1);
        }
        if let Some(Chosen { spp, .. }) = walk.chosen {
            let _ = writeln!(text, "  samples  {spp} per pixel, chosen by --time-per-frame");
        }
    }
    text
}
