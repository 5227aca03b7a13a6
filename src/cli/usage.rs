//! From arguments to a command, or to one line that says what is wrong with them.

use super::{CommandLine, Failure};
use clap::Parser;
use clap::error::ErrorKind;
use std::ffi::OsString;

/// What the arguments ask for.
pub(super) enum Parsed {
    /// Help or the version, to be printed.
    Text(String),
    /// A command.
    CommandLine(Box<CommandLine>),
}

/// Whether errors go out as JSON, known before the arguments are.
pub(super) fn asks_for_json(arguments: impl Iterator<Item = OsString>) -> bool {
    arguments.skip(1).take_while(|argument| argument != "--").any(|argument| argument == "--json")
}

pub(super) fn parse(arguments: impl Iterator<Item = OsString>) -> Result<Parsed, Failure> {
    let error = match CommandLine::try_parse_from(arguments) {
        Ok(line) => return Ok(Parsed::CommandLine(Box::new(line))),
        Err(error) => error,
    };
    match error.kind() {
        ErrorKind::DisplayHelp | ErrorKind::DisplayVersion => Ok(Parsed::Text(error.render().to_string())),
        ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand => {
            Err(Failure::usage("a command is missing; `tirtouch --help` lists them"))
        }
        _ => Err(Failure::usage(one_line(&error.render().to_string()))),
    }
}

/// What clap says before it comes to the usage, as one line.
fn one_line(text: &str) -> String {
    let said = text.lines().take_while(|line| !line.starts_with("Usage:") && !line.starts_with("For more"));
    let lines: Vec<&str> = said.map(str::trim).filter(|line| !line.is_empty()).collect();
    let line = lines.join(" ");
    line.strip_prefix("error: ").unwrap_or(&line).replace(" tip: ", "; ")
}
