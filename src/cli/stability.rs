//! `stability`: the extreme cases, each with its reference and its error.

use super::command::{self, described};
use super::flags::one_of;
use super::job::watched;
use super::{Failure, Outcome, Talk};
use crate::output::OutputFolder;
use crate::pages::stability::{pictures, table};
use crate::stability::{Context, Tracer, membrane, run};
use crate::trace::BackendChoice;
use clap::Args;
use std::path::PathBuf;

/// Check the extreme cases of tracer, finite elements and estimators against their references.
///
/// Exit code 1 if a row fails.
#[derive(Debug, Args)]
pub(super) struct Stability {
    /// Fewer and smaller cases: some seconds.
    #[arg(long)]
    quick: bool,
    /// Folder to write: stability.csv and pictures [default: none].
    #[arg(short, long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Replace the folder, if this program wrote all that it holds.
    #[arg(long)]
    force: bool,
    /// What is checked: the CPU twin, and the GPU where there is one (auto), the GPU or fail (gpu), the twin alone
    /// (cpu).
    #[arg(long, value_parser = one_of::<BackendChoice, 3>(["auto", "gpu", "cpu"]), default_value = "auto")]
    backend: BackendChoice,
    #[command(flatten)]
    talk: Talk,
}

impl Stability {
    pub(super) fn run(&self) -> Result<Outcome, Failure> {
        let folder = self.out.as_ref().map(|out| OutputFolder::create(out, self.force)).transpose()?;
        let (tracers, adapter) = Tracer::all(self.backend)?;
        if self.backend == BackendChoice::Auto && adapter.is_none() {
            self.talk.note("no GPU adapter found: only the CPU tracer is checked");
        }
        let context = Context { tracers, membrane: membrane::deflection, quick: self.quick };
        let rows = watched(self.talk.quiet, |observe| run(&context, observe)).ok_or_else(Failure::cancelled)?;
        let passed = rows.iter().all(|row| row.passed);
        let result = table::all_json(&rows, adapter.as_deref());
        let (out, json) = match folder {
            Some(folder) => {
                folder.write("stability.csv", &table::csv(&rows)?)?;
                pictures::write(&context, &folder)?;
                let done = command::commit(folder, None, result)?;
                (Some(done.out), done.json)
            }
            None => (None, described(result, None).to_string()),
        };
        self.talk.tell(&json, table::text(&rows, adapter.as_deref(), out.as_deref()))?;
        Ok(if passed { Outcome::Done } else { Outcome::CheckFailed })
    }
}
