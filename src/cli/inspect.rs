//! `inspect`: what was understood of a scene, and what a render of it would do.

use super::flags::SceneFile;
use super::job::{check_light, watched};
use super::{Failure, Outcome, Talk};
use crate::pages::inspection::Inspection;
use crate::trace::{BackendChoice, Devices, Precision};
use clap::{Args, value_parser};
use std::sync::Arc;

/// Show what was understood of a scene: angles, regimes, kernel pieces, adapter.
#[derive(Debug, Args)]
pub(super) struct Inspect {
    #[command(flatten)]
    scene: SceneFile,
    /// Measure what it gains to leave out what the scene does not need: small images with each piece and without, in
    /// turn.
    #[arg(long)]
    gains: bool,
    /// Rounds of that.
    #[arg(long, value_name = "N", default_value_t = 5, requires = "gains")]
    #[arg(value_parser = value_parser!(u32).range(2..=100))]
    rounds: u32,
    #[command(flatten)]
    talk: Talk,
}

impl Inspect {
    pub(super) fn run(&self) -> Result<Outcome, Failure> {
        let (loaded, file) = self.scene.open()?;
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
