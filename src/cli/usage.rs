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
    CommandLine(CommandLine),
}

/// Whether errors go out as JSON, known before the arguments are.
pub(super) fn asks_for_json(arguments: impl Iterator<Item = OsString>) -> bool {
    arguments.skip(1).take_while(|argument| argument != "--").any(|argument| argument == "--json")
}

pub(super) fn parse(arguments: impl Iterator<Item = OsString>) -> Result<Parsed, Failure> {
    CommandLine::try_parse_from(arguments).map(Parsed::CommandLine).or_else(|error| match error.kind() {
        ErrorKind::DisplayHelp | ErrorKind::DisplayVersion => Ok(Parsed::Text(error.render().to_string())),
        ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand => {
            Err(Failure::usage("a command is missing; `tirtouch --help` lists them"))
        }
        _ => Err(Failure::usage(one_line(&error.render().to_string()))),
    })
}

/// What clap says before it comes to the usage, as one line.
fn one_line(text: &str) -> String {
    let said = text.lines().take_while(|line| !line.starts_with("Usage:") && !line.starts_with("For more"));
    let lines: Vec<&str> = said.map(str::trim).filter(|line| !line.is_empty()).collect();
    let line = lines.join(" ");
    line.strip_prefix("error: ").unwrap_or(&line).replace(" tip: ", "; ")
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn refusal(arguments: &[&str]) -> String {
        let arguments = arguments.iter().map(OsString::from);
        match parse(arguments) {
            Err(failure) => failure.message().to_owned(),
            Ok(_) => String::new(),
        }
    }

    #[test]
    fn a_wrong_flag_is_one_line_without_the_usage() {
        let line = refusal(&["tirtouch", "compare", "a", "b", "--levle", "1"]);
        assert!(line.contains("'--levle'") && line.contains("'--level'"), "{line}");
        assert!(!line.contains('\n') && !line.contains("Usage") && !line.starts_with("error"), "{line}");
    }

    #[test]
    fn missing_arguments_are_named() {
        let line = refusal(&["tirtouch", "compare"]);
        assert!(line.contains("<A>") && line.contains("<B>"), "{line}");
    }

    #[test]
    fn json_is_seen_before_the_double_dash_only() {
        let asks = |arguments: &[&str]| asks_for_json(arguments.iter().map(OsString::from));
        assert!(asks(&["tirtouch", "--wrong", "--json"]));
        assert!(!asks(&["tirtouch", "compare", "--", "--json"]));
    }
}
