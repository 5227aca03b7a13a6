//! `frames`: pressure frames of a scanned indenter and their features.

mod source;

use super::command;
use super::flags::{finite, not_negative, positive};
use super::{Failure, Outcome, Talk, note, print};
use crate::output::OutputFolder;
use crate::pages::frames::{Pictures, Reading};
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
    /// Half width of the window of the parabola about the indenter's centre, mm [default: the scene's, or the contact].
    #[arg(long, value_name = "W", value_parser = positive, allow_negative_numbers = true)]
    window_mm: Option<f64>,
    /// Pressure up to which a place counts as not in contact, kPa: the noise of measured frames.
    #[arg(long, value_name = "P", default_value = "0", value_parser = not_negative, allow_negative_numbers = true)]
    noise_kpa: f64,
    /// Position of the frame that is shown by itself, mm; the nearest is taken.
    #[arg(long, value_name = "X", default_value = "0", value_parser = finite, allow_negative_numbers = true)]
    show_mm: f64,
    /// Folder to write, in whole or not at all [default: out/NAME].
    #[arg(short, long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Replace the folder, if this program wrote all that it holds.
    #[arg(long)]
    force: bool,
    #[command(flatten)]
    talk: Talk,
}

impl FramesCommand {
    pub(super) fn run(&self) -> Result<Outcome, Failure> {
        let input = source::read(self.scene.as_deref(), self.measured.as_deref())?;
        let place = self.out.clone().unwrap_or_else(|| PathBuf::from("out").join(input.name()));
        let folder = OutputFolder::create(&place, self.force)?;
        let window_mm = self.window_mm.or(input.window_mm());
        let source = input.frames(self.show_mm, self.talk.quiet)?;
        let features =
            source.features(window_mm, self.noise_kpa).map_err(|error| Failure::failed(error.to_string()))?;
        let shown = source.nearest(self.show_mm);
        let reading = Reading { source, features, window_mm, noise_kpa: self.noise_kpa, shown };
        if !self.talk.quiet {
            reading.notes().iter().for_each(|line| note(line));
        }
        let pictures = Pictures::draw(&reading)?;
        reading.write(&folder, &pictures)?;
        let done = command::commit(folder, reading.source.scene_text.as_deref(), reading.json())?;
        match self.talk.json {
            true => print(&done.json)?,
            false => print(&reading.text(&done.out))?,
        }
        Ok(Outcome::Done)
    }
}
