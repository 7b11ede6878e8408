//! The command line: arguments, and one file per command.

mod cache;
mod caching;
mod chart;
mod choices;
mod compare;
mod completions;
mod denoise;
mod image;
mod info;
mod job;
mod lens;
mod live;
mod look;
mod method;
mod options;
mod outputs;
mod probe;
mod reading;
mod stats;
mod view;
mod walk;
mod walk_chart;

use anyhow::Result;
use clap::{CommandFactory, Parser, Subcommand};
use std::process::ExitCode;

/// Renders glossy global illumination.
#[derive(Debug, Parser)]
#[command(name = "render", version, about)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Render a scene.
    Image(image::Args),
    /// Draw the frames of a walk through a scene, from caches that are filled once.
    #[command(long_about = walk::LONG_ABOUT)]
    Walk(Box<walk::Args>),
    /// Walk through a scene in a browser, while its caches fill.
    #[command(long_about = live::LONG_ABOUT)]
    View(Box<live::Args>),
    /// Draw frames of a walk from caches and by path tracing, with a denoiser and without, at equal time: errors, flicker, a page.
    WalkChart(walk_chart::Args),
    /// Look into files of records, and join those that were filled apart.
    Cache(cache::Args),
    /// List what a scene holds: cameras, lamps, meshes, materials, textures, and what is drawn differently.
    Info(info::Args),
    /// Look into the record of equivalent area lights at a pixel: pictures, tree, errors.
    Probe(probe::Args),
    /// Measure how far a picture is from its reference.
    Compare(compare::Args),
    /// Chart speed against accuracy of all methods: a table, figures, and one page to read.
    Chart(chart::Args),
    /// Print what a shell completes when the tabulator is pressed, or write pages for man.
    Completions(completions::Args),
}

/// Runs the command; 0 done, 1 a check failed, 2 bad input or usage.
pub fn run() -> ExitCode {
    kit::watch();
    let cli: Cli = match kit::parse("render") {
        Ok(cli) => cli,
        Err(code) => return code,
    };
    let result: Result<ExitCode> = match cli.command {
        Command::Image(args) => image::run(&args),
        Command::Walk(mut args) => walk::run(&mut args),
        Command::View(args) => live::run(&args),
        Command::WalkChart(args) => walk_chart::run(&args),
        Command::Cache(args) => cache::run(&args),
        Command::Info(args) => info::run(&args),
        Command::Probe(args) => probe::run(&args),
        Command::Compare(args) => compare::run(&args),
        Command::Chart(args) => chart::run(args),
        Command::Completions(args) => completions::run(&args, Cli::command()),
    };
    result.unwrap_or_else(|error| {
        eprintln!("render: {}", kit::one_line(&error));
        ExitCode::from(2)
    })
}
