//! `converge`: error against run time.

use super::command::described;
use super::flags::Backend;
use super::job::{check_light, watched};
use super::{Failure, Outcome, PressFailure, Talk, note};
use crate::converge::{Climb, ClimbError, Part};
use crate::output::leftovers::leftovers;
use crate::output::{RESULT, Records, SCENE};
use crate::pages::converge::{pictures, table};
use crate::scene::open;
use crate::trace::{Devices, Precision, Settings};
use clap::Args;
use serde_json::json;
use std::path::PathBuf;

/// Measure error against run time on ladders of settings, each against a finer reference.
///
/// Light: samples and integrator, texels of the map, points of height fields, arithmetic. A scene with a press: meshes
/// and load steps as well. Every rung is kept when it is done: `--resume` goes on where it was stopped.
#[derive(Debug, Args)]
pub(super) struct Converge {
    /// Scene file, or preset:NAME for a scene that comes with the program.
    scene: PathBuf,
    /// A small version: an eighth of the camera's pixels along each side, few and low rungs.
    #[arg(long)]
    quick: bool,
    /// Highest samples a pixel; the reference has four times as many [default: 4 times the scene's, quick: 64].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(16..=16_384), allow_negative_numbers = true)]
    spp: Option<u32>,
    /// Divide the camera's pixels along each side by this [default: 1, quick: 8].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=64), allow_negative_numbers = true)]
    shrink: Option<u32>,
    /// Only the ladders of the light, or of the mechanics.
    #[arg(long, value_enum)]
    only: Option<Only>,
    /// Folder to write [default: out/NAME-converge].
    #[arg(short, long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Replace the folder, if this program wrote all that it holds.
    #[arg(long, conflicts_with = "resume")]
    force: bool,
    /// Go on with the rungs that the folder does not have yet.
    #[arg(long)]
    resume: bool,
    /// Seed of all random numbers: the reference and each run of the rungs draw their own [default: the scene's].
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    seed: Option<u32>,
    /// Where to compute.
    #[arg(long, value_enum, default_value_t)]
    backend: Backend,
    #[command(flatten)]
    talk: Talk,
}

/// Which ladders.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Only {
    /// Light alone; a press is run once.
    Light,
    /// Mechanics alone.
    Mechanics,
}

impl Only {
    fn part(self) -> Part {
        match self {
            Self::Light => Part::Light,
            Self::Mechanics => Part::Mechanics,
        }
    }
}

impl Converge {
    pub(super) fn run(&self) -> Result<Outcome, Failure> {
        let (mut loaded, file) = open(&self.scene)?;
        if self.only == Some(Only::Mechanics) && loaded.scene.press.is_none() {
            let message = format!("{}: --only mechanics needs a scene with a [press]", file.display());
            return Err(Failure::usage(message).in_file(&file));
        }
        if self.only != Some(Only::Mechanics) {
            check_light(&loaded, &file)?;
        }
        let shrink = self.shrink.unwrap_or(if self.quick { 8 } else { 1 });
        loaded.scene.camera.shrink(shrink);
        let devices = self.devices()?;
        let seed = self.seed.unwrap_or(loaded.scene.render.seed);
        let settings = Settings { seed, ..Settings::of(&loaded.scene.render) };
        let most_spp = self.spp.unwrap_or(match self.quick {
            true => 64,
            false => loaded.scene.render.spp.saturating_mul(4).clamp(64, 16_384),
        });
        let name = loaded.scene.name.clone();
        let place = self.out.clone().unwrap_or_else(|| PathBuf::from("out").join(format!("{name}-converge")));
        // Whatever changes a rung belongs to the order.
        let order = json!({
            "scene_sha256": loaded.sha256,
            "inputs": loaded.inputs(),
            "quick": self.quick,
            "most_spp": most_spp,
            "shrink": shrink,
            "seed": settings.seed,
            "backend": if devices.is_gpu() { "Gpu" } else { "Cpu" },
            "version": env!("CARGO_PKG_VERSION"),
        });
        let records = Records::open(&place, &order, self.force, self.resume)?;
        leftovers().keep(format!("what was done is in {}: go on with --resume", place.display()));
        records.write(SCENE, &loaded.text)?;
        let climb = Climb {
            loaded: &loaded,
            settings,
            devices: &devices,
            most_spp,
            quick: self.quick,
            only: self.only.map(Only::part),
        };
        let found = watched(self.talk.quiet, |observe| climb.run(&records, observe)).map_err(|error| match error {
            ClimbError::Press(error) => PressFailure::of(error, &file).failure,
            ClimbError::Light(error) => error.into(),
            ClimbError::Output(error) => error.into(),
        })?;
        records.write("converge.csv", &table::csv(&found.rungs)?)?;
        for (file, svg) in pictures::draw(&name, &found.rungs)? {
            records.write(&file, &svg)?;
        }
        let result = described(table::json(&name, &found), Some(&place));
        records.write(RESULT, &format!("{result:#}\n"))?;
        self.talk.tell(&result, table::text(&name, &found, &place.display().to_string()))
    }

    /// What traces.
    fn devices(&self) -> Result<Devices, Failure> {
        let devices = Devices::open(self.backend.choice(), Precision::F32)?;
        if let (Some(notice), false) = (devices.notice(), self.talk.quiet) {
            note(notice);
        }
        Ok(devices)
    }
}
