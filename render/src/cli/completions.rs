//! `render completions`: what a shell completes, and pages for `man`.

use anyhow::{Context, Result, bail, ensure};
use clap::{Command, ValueEnum};
use clap_complete::Shell;
use clap_mangen::Man;
use kit::output::{check_folder, write};
use std::ffi::OsStr;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// For whom.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum For {
    Bash,
    Elvish,
    Fish,
    Powershell,
    Zsh,
    /// Pages for `man`, one for each command, into the folder --output.
    Man,
}

const EXAMPLES: &str = "\
Examples:
  render completions bash > ~/.local/share/bash-completion/completions/render
  render completions zsh > ~/.zfunc/_render
  render completions fish > ~/.config/fish/completions/render.fish
  render completions man -o ~/.local/share/man/man1";

/// Arguments of `render completions`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    /// The shell, or man.
    #[arg(value_enum, value_name = "SHELL")]
    shell: For,
    /// Folder for the pages of man, made if it is not there.
    #[arg(short, long, value_name = "DIR", required_if_eq("shell", "man"))]
    output: Option<PathBuf>,
}

/// Prints what a shell sources, or writes pages.
pub fn run(args: &Args, mut command: Command) -> Result<ExitCode> {
    let shell = match args.shell {
        For::Man => {
            let Some(folder) = &args.output else { bail!("--output is needed: the folder for the pages of man") };
            pages(&mut command, folder)?;
            return Ok(ExitCode::SUCCESS);
        }
        For::Bash => Shell::Bash,
        For::Elvish => Shell::Elvish,
        For::Fish => Shell::Fish,
        For::Powershell => Shell::PowerShell,
        For::Zsh => Shell::Zsh,
    };
    ensure!(args.output.is_none(), "--output is for man: what a shell completes goes to standard output");
    let name = command.get_name().to_owned();
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut command, name, &mut script);
    std::io::stdout().write_all(&script).context("standard output")?;
    Ok(ExitCode::SUCCESS)
}

/// Writes a page for a command and each of those below it.
fn pages(command: &mut Command, folder: &Path) -> Result<()> {
    check_folder(folder)?;
    std::fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
    command.build();
    page(command, folder)
}

fn page(command: &Command, folder: &Path) -> Result<()> {
    // Of a command below another, `build` has made this of both names.
    let name = command.get_display_name().unwrap_or(command.get_name()).to_owned();
    let man = Man::new(command.clone().name(name.clone().leak() as &str));
    let mut text = Vec::new();
    man.render(&mut text).context("a page of man")?;
    write(&folder.join(OsStr::new(&format!("{name}.1"))), &text)?;
    command.get_subcommands().filter(|c| c.get_name() != "help").try_for_each(|below| page(below, folder))
}
