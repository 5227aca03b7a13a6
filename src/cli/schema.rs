//! `schema`: the JSON schema of the scene file.

use super::{Failure, Outcome, print};
use clap::Args;

/// Print the JSON schema of the scene file, for editors.
#[derive(Debug, Args)]
pub(super) struct Schema {
    /// Print it as text to read (docs/SCENES.md) in place of JSON.
    #[arg(long)]
    markdown: bool,
    /// That of the sweep file.
    #[arg(long, conflicts_with = "markdown")]
    sweep: bool,
}

impl Schema {
    pub(super) fn run(&self) -> Result<Outcome, Failure> {
        match self.markdown {
            _ if self.sweep => print(&format!("{:#}", crate::sweep::schema()))?,
            true => print(&crate::scene::reference::reference())?,
            // Alternate Display of a JSON value is indented.
            false => print(&format!("{:#}", crate::scene::schema()))?,
        }
        Ok(Outcome::Done)
    }
}
