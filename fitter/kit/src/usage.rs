//! Arguments as typed: mistakes in one line.

use clap::error::ErrorKind;
use clap::{Arg, Parser};
use core::any::TypeId;
use std::process::ExitCode;

/// Exit code of bad usage.
const REFUSED: u8 = 2;

/// Parses the command line of the command `name`. Numbers may be negative, so that their own parser refuses them.
///
/// # Errors
/// The exit code, after help, version or a mistake is printed: help and version as clap does, mistakes in one line.
pub fn parse<C: Parser>(name: &str) -> Result<C, ExitCode> {
    let command = C::command().mut_subcommands(|command| command.mut_args(signed));
    command
        .try_get_matches()
        .and_then(|mut matches| C::from_arg_matches_mut(&mut matches))
        .map_err(|e| refuse(name, &e))
}

/// Lets a number start with a minus.
fn signed(arg: Arg) -> Arg {
    let parsed = arg.get_value_parser().type_id();
    let number = [
        TypeId::of::<f32>(),
        TypeId::of::<f64>(),
        TypeId::of::<u8>(),
        TypeId::of::<u16>(),
        TypeId::of::<u32>(),
        TypeId::of::<u64>(),
    ]
    .into_iter()
    .any(|t| parsed == t);
    // Where the number may be left out, what follows may as well be the next option.
    let optional = arg.get_num_args().is_some_and(|n| n.min_values() == 0);
    match (number && arg.get_action().takes_values(), optional) {
        (true, false) => arg.allow_hyphen_values(true),
        (true, true) => arg.allow_negative_numbers(true),
        (false, _) => arg,
    }
}

fn refuse(name: &str, error: &clap::Error) -> ExitCode {
    if matches!(
        error.kind(),
        ErrorKind::DisplayHelp | ErrorKind::DisplayVersion | ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand
    ) {
        // Nothing is left to do when standard output is closed.
        let _ = error.print();
        return ExitCode::from(error.exit_code() as u8);
    }
    let text = error.to_string();
    let end = text.find("\n\nUsage:").or_else(|| text.find("\n\nFor more")).unwrap_or(text.len());
    let message = text[..end].trim_start_matches("error:").replace("\n\n  tip: ", "; ");
    let words: Vec<_> = message.split_whitespace().collect();
    eprintln!("{name}: {} (see --help)", words.join(" "));
    ExitCode::from(REFUSED)
}
