//! `fitter`: from a material to a table of its mean BRDF, and the means to check, query, draw and chart it.

mod chart;
mod cli;
mod export;
mod plot;
mod report;

fn main() -> std::process::ExitCode {
    cli::main()
}
