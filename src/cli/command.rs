//! The command line as it was given, for results and reports.

use super::Failure;
use crate::output::{Finished, OutputFolder};
use serde_json::{Value, json};
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

/// How the command line was started, where not as a program of its own.
static STARTED: OnceLock<Started> = OnceLock::new();

struct Started {
    arguments: Vec<OsString>,
    program: PathBuf,
}

/// Takes the command line from another program, as that which is run by `program`. Called once, at the start.
pub(super) fn started_by(arguments: Vec<OsString>, program: PathBuf) {
    let _ = STARTED.set(Started { arguments, program });
}

/// The arguments, the program's name first.
pub(super) fn arguments() -> Vec<OsString> {
    STARTED.get().map_or_else(|| std::env::args_os().collect(), |started| started.arguments.clone())
}

/// What runs the command line again.
pub(super) fn program() -> Result<PathBuf, Failure> {
    match STARTED.get() {
        Some(started) => Ok(started.program.clone()),
        None => std::env::current_exe()
            .map_err(|error| Failure::failed(format!("the place of this program is not known: {error}"))),
    }
}

/// A result with what every command adds: where it is, what made it, and how it was asked for.
pub(super) fn described(result: Value, out: Option<&Path>) -> Value {
    with_command(crate::output::described(result, out))
}

/// A result with the command line.
pub(super) fn with_command(mut result: Value) -> Value {
    result["command"] = json!(command());
    result
}

/// The command line, the program's name first.
fn command() -> Vec<String> {
    arguments().iter().map(|argument| argument.to_string_lossy().into_owned()).collect()
}

/// The same in one line, for people.
pub(super) fn command_line() -> String {
    command().join(" ")
}

/// The command line without what changes no light (folder and talk) and without the program's own place: equal renders
/// then have equal headers.
pub(super) fn command_of_light() -> String {
    let mut said = vec!["tirtouch".to_owned()];
    let mut arguments = command().into_iter().skip(1);
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "-o" | "--out" => drop(arguments.next()),
            "--force" | "--quiet" | "--json" => {}
            out if out.starts_with("-o") || out.starts_with("--out=") => {}
            _ => said.push(argument),
        }
    }
    said.join(" ")
}

/// Puts a folder in its place, with the command line in its result, unless the user has asked to stop.
pub(super) fn commit(folder: OutputFolder, scene: Option<&str>, result: Value) -> Result<Finished, Failure> {
    Ok(folder.commit(scene, with_command(result), &|| !super::cancel::requested())?)
}
