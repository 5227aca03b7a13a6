//! `schema`: the JSON schema of the scene file.

use super::{Failure, Outcome, print};
use clap::Args;

/// Print the JSON schema of the scene file, for editors.
#[derive(Debug, Args)]
pub(super) struct Schema {}

impl Schema {
    pub(super) fn run(&self) -> Result<Outcome, Failure> {
        // Alternate Display of a JSON value is indented.
        print(&format!("{:#}", crate::scene::schema()))?;
        Ok(Outcome::Done)
    }
}
