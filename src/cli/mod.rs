//! The command line: one file per command.
//!
//! To add a command: a file with a struct of its arguments (`clap::Args`, with [`Common`] or [`Talk`] flattened in) and
//! a `run` that returns an [`Outcome`] or a [`Failure`]; a line in `commands`. `compare` is a short example. Long work
//! polls [`cancel::check`], reports to a [`Progress`] and writes into an [`crate::output::OutputFolder`].

mod calibrate;
mod calibrate_sensor;
pub mod cancel;
mod command;
mod compare;
mod converge;
mod demo;
mod environment;
mod estimate;
mod expose;
mod flags;
mod frames;
mod inspect;
mod job;
mod measure;
mod new;
mod press;
mod progress;
mod render;
mod run;
mod schema;
mod shells;
mod stability;
mod study;
mod sweep;
mod usage;
mod view;

pub use flags::{Backend, Common, Place, SceneFile, Talk};
pub use progress::Progress;

use crate::failure::{Failure, PressFailure};
use clap::{Parser, Subcommand};
use std::ffi::OsString;
use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;

/// Simulator of the multilayer total-internal-reflection tactile sensor.
#[derive(Debug, Parser)]
#[command(
    name = "tirtouch",
    version,
    after_help = "Exit codes: 0 done, 1 a check did not hold, 2 wrong use or bad input, 3 it failed."
)]
struct CommandLine {
    #[command(subcommand)]
    command: Command,
}

/// How a command ended that did not fail.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// Done (exit code 0).
    Done,
    /// It ran, and the check it makes did not hold (exit code 1).
    CheckFailed,
}

/// All commands, each run by its own file.
macro_rules! commands {
    ($($name:ident($command:ty)),* $(,)?) => {
        #[derive(Debug, Subcommand)]
        enum Command {
            $($name($command)),*
        }

        impl Command {
            fn run(&self) -> Result<Outcome, Failure> {
                match self {
                    $(Self::$name(command) => command.run()),*
                }
            }
        }
    };
}

commands! {
    Demo(demo::Demo),
    Run(run::Run),
    Press(press::Press),
    Render(render::Render),
    Expose(expose::Expose),
    Estimate(estimate::Estimate),
    Compare(compare::Compare),
    Frames(frames::FramesCommand),
    Converge(converge::Converge),
    Stability(stability::Stability),
    Sweep(sweep::SweepCommand),
    Calibrate(calibrate::Calibrate),
    Study(study::Study),
    Inspect(inspect::Inspect),
    View(view::View),
    Schema(schema::Schema),
    New(new::New),
    Completions(shells::Completions),
    Man(shells::Man),
}

/// Runs the command line of this process.
pub fn main() -> ExitCode {
    environment::settle();
    ExitCode::from(run())
}

/// Runs a command line in a process of another program, which then does nothing else; gives the exit code. `arguments`
/// begin with a name, as those of a process do; `program` starts the same again (jobs of a cluster do).
pub fn run_as(arguments: Vec<OsString>, program: PathBuf) -> u8 {
    command::started_by(arguments, program);
    run()
}

fn run() -> u8 {
    let arguments = command::arguments();
    let json = usage::asks_for_json(arguments.iter().cloned());
    let outcome = usage::parse(arguments.into_iter()).and_then(|parsed| match parsed {
        None => Ok(Outcome::Done),
        Some(line) => {
            cancel::install(json)?;
            environment::check()?;
            line.command.run()
        }
    });
    match outcome {
        Ok(Outcome::Done) => 0,
        Ok(Outcome::CheckFailed) => 1,
        Err(failure) => {
            cancel::last_word();
            report(&failure, json)
        }
    }
}

/// Says a failure, on standard error and for `--json` as an object on standard output, and gives the exit code.
fn report(failure: &Failure, json: bool) -> u8 {
    note(failure.message());
    if !failure.others().is_empty() {
        note(&format!("and {} more:", failure.others().len()));
    }
    failure.others().iter().for_each(|other| note(other.message()));
    if json {
        // Standard error has said it already, so a closed standard output hides nothing.
        let _ = write_line(&failure.json().to_string());
    }
    failure.code()
}

/// Writes `text` and a line's end to standard output, unless the user has asked to stop. A reader that has gone away is
/// no failure.
///
/// # Errors
/// When standard output cannot be written, or on that request.
pub fn print(text: &str) -> Result<(), Failure> {
    cancel::check()?;
    write_line(text)
}

fn write_line(text: &str) -> Result<(), Failure> {
    write_exactly(&format!("{}\n", text.trim_end()))
}

/// Writes a file's text to standard output, as it is. Whoever closes it has seen enough.
///
/// # Errors
/// When it cannot be written.
fn write_exactly(text: &str) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(Failure::failed(format!("standard output cannot be written: {error}")))
        }
        _ => Ok(()),
    }
}

/// Writes one line to standard error; where that is closed, nobody is told.
fn note(line: &str) {
    let _ = writeln!(std::io::stderr().lock(), "tirtouch: {line}");
}
