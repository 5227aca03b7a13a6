//! From arguments to a command, or to one line that says what is wrong with them.

use super::{CommandLine, Failure, print};
use clap::error::ErrorKind;
use clap::{Command, CommandFactory, FromArgMatches};
use std::ffi::OsString;

/// Whether errors go out as JSON, known before the arguments are.
pub(super) fn asks_for_json(arguments: impl Iterator<Item = OsString>) -> bool {
    arguments.skip(1).take_while(|argument| argument != "--").any(|argument| argument == "--json")
}

/// The command that arguments ask for; none where they ask for help or the version, which is printed.
pub(super) fn parse(arguments: impl Iterator<Item = OsString>) -> Result<Option<CommandLine>, Failure> {
    let matches = signed(CommandLine::command()).try_get_matches_from(arguments);
    let error = match matches.and_then(|matches| CommandLine::from_arg_matches(&matches)) {
        Ok(line) => return Ok(Some(line)),
        Err(error) => error,
    };
    match error.kind() {
        ErrorKind::DisplayHelp | ErrorKind::DisplayVersion => print(&error.render().to_string()).map(|()| None),
        ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand => {
            Err(Failure::usage("a command is missing; `tirtouch --help` lists them"))
        }
        _ => Err(Failure::usage(one_line(&error.render().to_string()))),
    }
}

/// With numbers below 0 as values, never as flags: what is wrong with one is then said of its flag.
fn signed(command: Command) -> Command {
    command.allow_negative_numbers(true).mut_subcommands(signed)
}

/// What clap says before it comes to the usage, as one line.
fn one_line(text: &str) -> String {
    let said = text.lines().take_while(|line| !line.starts_with("Usage:") && !line.starts_with("For more"));
    let lines: Vec<&str> = said.map(str::trim).filter(|line| !line.is_empty()).collect();
    let line = lines.join(" ");
    line.strip_prefix("error: ").unwrap_or(&line).replace(" tip: ", "; ")
}
