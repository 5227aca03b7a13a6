//! `frames`: pressure frames of a scanned indenter and their features.

use super::command;
use super::flags::{Place, finite, not_negative, positive};
use super::job::watching;
use super::{Failure, Outcome, Talk};
use crate::estimate::tissue::{self, Question, noisy};
use crate::mechanics::frames::FramesError;
use crate::pages::frames::{Input, Pictures, Reading};
use crate::scene::{LoadedScan, open_scan};
use clap::Args;
use std::path::PathBuf;

/// Pressure frames of an indenter scanned over tissue, computed from a scan scene or measured, and their features.
#[derive(Debug, Args)]
pub(super) struct FramesCommand {
    /// Scan scene file, or preset:NAME for one that comes with the program.
    #[arg(required_unless_present = "measured", conflicts_with = "measured")]
    scene: Option<PathBuf>,
    /// Measured frames in place of a scene: CSV of position_mm,x_mm,pressure_kpa.
    #[arg(long, value_name = "CSV")]
    measured: Option<PathBuf>,
    /// What is known beside measured frames, as a scan scene: indenter, depth of the press, depth of the inclusion.
    /// Then the tissue is estimated from them; the scene's own is the guess from which it is sought.
    #[arg(long, value_name = "SCAN", conflicts_with = "scene")]
    calibration: Option<PathBuf>,
    /// Estimate the tissue from the computed frames, with noise added: does the inverse find what the scene holds?
    #[arg(long, conflicts_with = "measured")]
    invert: bool,
    /// Noise that is added to computed frames before they are inverted, as a share of each pressure.
    #[arg(long, value_name = "S", default_value = "0.01", value_parser = not_negative, requires = "invert")]
    noise_share: f64,
    /// The depth of the press is not known: hold each frame's own force instead.
    #[arg(long)]
    by_force: bool,
    /// The depth of the inclusion is not known: seek it too.
    #[arg(long)]
    free_depth: bool,
    /// Seed of the added noise, and of the draws behind the intervals.
    #[arg(long, value_name = "N", default_value = "0")]
    seed: u32,
    /// Half width of the window of the parabola about the indenter's centre, mm [default: the scene's, or the contact].
    #[arg(long, value_name = "W", value_parser = positive)]
    window_mm: Option<f64>,
    /// Pressure up to which a place counts as not in contact, kPa: the noise of measured frames.
    #[arg(long, value_name = "P", default_value = "0", value_parser = not_negative)]
    noise_kpa: f64,
    /// Position of the frame that is shown by itself, mm; the nearest is taken.
    #[arg(long, value_name = "X", default_value = "0", value_parser = finite)]
    show_mm: f64,
    #[command(flatten)]
    place: Place,
    #[command(flatten)]
    talk: Talk,
}

impl FramesCommand {
    pub(super) fn run(&self) -> Result<Outcome, Failure> {
        let input = match (&self.scene, &self.measured) {
            (Some(scene), None) => Input::scene_of(scene)?,
            (None, Some(file)) => Input::measured(file)?,
            _ => return Err(Failure::usage("give either a scan scene or `--measured CSV`")),
        };
        let &Self { by_force, free_depth, noise_kpa, seed, .. } = self;
        let known = self.known(&input)?;
        let folder = self.place.take(&input.name())?;
        let window_mm = self.window_mm.or(known.as_ref().map_or(input.window_mm(), |known| known.scene.scan.window_mm));
        let mut source = input.frames(self.show_mm, &watching(self.talk.quiet))?;
        if let (Some(file), Some(known)) = (&self.calibration, &known) {
            source.know(file, known);
        }
        let failed = |error: FramesError| Failure::failed(error.to_string());
        let features = source.features(window_mm, noise_kpa).map_err(failed)?;
        let shown = source.nearest(self.show_mm);
        let noisy = self.invert.then(|| noisy(&source.frames, self.noise_share, seed)).transpose().map_err(failed)?;
        let frames = noisy.as_ref().unwrap_or(&source.frames);
        let seek = |scene: &LoadedScan| {
            let question = Question { scene, by_force, free_depth, window_mm, noise_kpa, seed };
            tissue::invert(frames, &question, &watching(self.talk.quiet))
        };
        let tissue = known.as_ref().map(seek).transpose()?;
        let reading = Reading { source, features, window_mm, noise_kpa, shown, tissue, noisy };
        reading.notes().iter().for_each(|line| self.talk.note(line));
        let pictures = Pictures::draw(&reading)?;
        reading.write(&folder, &pictures)?;
        let done = command::commit(folder, reading.source.scene_text.as_deref(), reading.json())?;
        self.talk.tell(&done.json, reading.text(&done.out))
    }

    /// What is known beside the frames, where the tissue is to be estimated.
    fn known(&self, input: &Input) -> Result<Option<LoadedScan>, Failure> {
        let known = match &self.calibration {
            Some(file) => Some(open_scan(file)?),
            None => input.scene().filter(|_| self.invert).map(|(scene, file)| (scene.clone(), file.to_path_buf())),
        };
        if known.is_none() && (self.by_force || self.free_depth) {
            return Err(Failure::usage("give `--calibration SCAN` with measured frames, or `--invert` with a scene"));
        }
        let Some((known, file)) = known else { return Ok(None) };
        tissue::check(&known, self.by_force).map_err(|error| Failure::from(error).in_file(&file))?;
        Ok(Some(known))
    }
}
