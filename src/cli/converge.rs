//! `converge`: error against run time.

use super::command::described;
use super::flags::{Backend, Place, one_of};
use super::job::{check_light, watched};
use super::{Failure, Outcome, Talk};
use crate::converge::{Climb, Part};
use crate::output::leftovers::leftovers;
use crate::output::{RESULT, Records, SCENE};
use crate::pages::converge::{table, write};
use crate::pipeline::Session;
use crate::scene::open;
use crate::trace::Settings;
use clap::Args;
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
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(16..=16_384))]
    spp: Option<u32>,
    /// Divide the camera's pixels along each side by this [default: 1, quick: 8].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=64))]
    shrink: Option<u32>,
    /// Only the ladders of the light, for which a press is run once, or of the mechanics.
    #[arg(long, value_parser = one_of::<Part, 2>(["light", "mechanics"]))]
    only: Option<Part>,
    #[command(flatten)]
    place: Place,
    /// Go on with the rungs that the folder does not have yet.
    #[arg(long, conflicts_with = "force")]
    resume: bool,
    /// Seed of all random numbers: the reference and each run of the rungs draw their own [default: the scene's].
    #[arg(long, value_name = "N")]
    seed: Option<u32>,
    #[command(flatten)]
    backend: Backend,
    #[command(flatten)]
    talk: Talk,
}

impl Converge {
    pub(super) fn run(&self) -> Result<Outcome, Failure> {
        let (mut loaded, file) = open(&self.scene)?;
        if self.only == Some(Part::Mechanics) && loaded.scene.press.is_none() {
            let message = format!("{}: --only mechanics needs a scene with a [press]", file.display());
            return Err(Failure::usage(message).in_file(&file));
        }
        if self.only != Some(Part::Mechanics) {
            check_light(&loaded, &file)?;
        }
        let shrink = self.shrink.unwrap_or(if self.quick { 8 } else { 1 });
        loaded.scene.camera.shrink(shrink);
        let mut session = Session::from(self.backend.open(self.talk.quiet)?);
        let own = Settings::of(&loaded.scene.render);
        let mut climb = Climb {
            loaded: &loaded,
            settings: Settings { seed: self.seed.unwrap_or(own.seed), ..own },
            session: &mut session,
            most_spp: self.spp.unwrap_or_else(|| Climb::usual_spp(&loaded, self.quick)),
            quick: self.quick,
            only: self.only,
        };
        let name = &loaded.scene.name;
        let place = self.place.named(&format!("{name}-converge"));
        let records = Records::open(&place, &climb.order(shrink), self.place.force, self.resume)?;
        leftovers().keep(format!("what was done is in {}: go on with --resume", place.display()));
        records.write(SCENE, &loaded.text)?;
        let found = watched(self.talk.quiet, |observe| climb.run(&records, observe))
            .map_err(|error| Failure::of_climb(error, &file))?;
        write(name, &found, &records)?;
        let result = described(table::json(name, &found), Some(&place));
        records.write(RESULT, &format!("{result:#}\n"))?;
        self.talk.tell(&result, table::text(name, &found, &place.display().to_string()))
    }
}
