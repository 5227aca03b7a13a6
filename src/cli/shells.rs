//! `completions` and `man`: what shells and readers of manuals know of the program.

use super::{CommandLine, Failure, Outcome, print};
use crate::output::fill_whole;
use clap::{Args, CommandFactory};
use clap_complete::{Shell, generate};
use std::path::PathBuf;

/// Print what a shell needs to complete commands and flags.
///
/// bash: `source <(tirtouch completions bash)`; other shells: into a file of theirs.
#[derive(Debug, Args)]
pub(super) struct Completions {
    /// Which shell.
    #[arg(value_enum)]
    shell: Shell,
}

/// Write manual pages, one for each command.
#[derive(Debug, Args)]
pub(super) struct Man {
    /// Folder for the pages; it is made where it is not there.
    folder: PathBuf,
}

impl Completions {
    pub(super) fn run(&self) -> Result<Outcome, Failure> {
        let mut text = Vec::new();
        generate(self.shell, &mut CommandLine::command(), "tirtouch", &mut text);
        print(&String::from_utf8_lossy(&text))?;
        Ok(Outcome::Done)
    }
}

impl Man {
    pub(super) fn run(&self) -> Result<Outcome, Failure> {
        if self.folder.exists() && !self.folder.is_dir() {
            let message = format!("{}: is no folder; give one for the pages", self.folder.display());
            return Err(Failure::usage(message).in_file(&self.folder));
        }
        fill_whole(&self.folder, |place| clap_mangen::generate_to(CommandLine::command(), place))?;
        Ok(Outcome::Done)
    }
}
