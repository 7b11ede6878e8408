//! The command `render`.

mod chart;
mod cli;

use std::process::ExitCode;

fn main() -> ExitCode {
    cli::run()
}
