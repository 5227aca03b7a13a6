//! `inspect`: what was understood of a scene, and what a render of it would do.

use super::job::{check_light, open_with, watched};
use super::{Failure, Outcome, Talk};
use crate::pages::inspection::Inspection;
use crate::trace::{BackendChoice, Devices, Precision};
use crate::vary::Set;
use clap::Args;
use std::path::PathBuf;
use std::sync::Arc;

/// Show what was understood of a scene: angles, regimes, kernel pieces, adapter.
#[derive(Debug, Args)]
pub(super) struct Inspect {
    /// Scene file, or preset:NAME for a scene that comes with the program.
    scene: PathBuf,
    /// Measure what it gains to leave out what the scene does not need: small images with each piece and without, in
    /// turn.
    #[arg(long)]
    gains: bool,
    /// Rounds of that.
    #[arg(long, value_name = "N", default_value_t = 5, requires = "gains", value_parser = clap::value_parser!(u32).range(2..=100), allow_negative_numbers = true)]
    rounds: u32,
    /// Set a key of the scene, as in `stack.layer[0].n=1.42`; may be given again.
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<Set>,
    #[command(flatten)]
    talk: Talk,
}

impl Inspect {
    pub(super) fn run(&self) -> Result<Outcome, Failure> {
        let (loaded, file) = open_with(&self.scene, &self.set)?;
        if self.gains {
            check_light(&loaded, &file)?;
        }
        let of_scene = |error| Failure::of_scene(error, &file);
        let devices = Devices::open(BackendChoice::Auto, Precision::F32);
        let seen = watched(true, |observe| Inspection::of(Arc::new(loaded), devices.as_ref(), observe));
        let mut seen = seen.map_err(of_scene)?;
        let mut same = true;
        if self.gains {
            let devices = devices?;
            let measured = watched(self.talk.quiet, |observe| seen.measure_gains(&devices, self.rounds, observe));
            same = measured.map_err(of_scene)?;
        }
        self.talk.tell(&seen.json()?, &seen.text()?)?;
        Ok(if same { Outcome::Done } else { Outcome::CheckFailed })
    }
}
