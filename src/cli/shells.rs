//! `completions` and `man`: what shells and readers of manuals know of the program.

use super::{CommandLine, Failure, Outcome, print};
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
        let failed = |error: std::io::Error| Failure::failed(format!("{}: {error}", self.folder.display()));
        std::fs::create_dir_all(&self.folder).map_err(failed)?;
        // All pages or none: a disk may be full.
        let pages = tempfile::Builder::new().prefix(".tirtouch").tempdir_in(&self.folder).map_err(failed)?;
        clap_mangen::generate_to(CommandLine::command(), pages.path()).map_err(failed)?;
        for page in std::fs::read_dir(pages.path()).map_err(failed)? {
            let page = page.map_err(failed)?;
            std::fs::rename(page.path(), self.folder.join(page.file_name())).map_err(failed)?;
        }
        Ok(Outcome::Done)
    }
}
