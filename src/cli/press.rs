//! `press`: mechanics only.

use super::command::{self, command_line};
use super::job::{open_with, press_scene};
use super::{Failure, Outcome, PressFailure, Talk, print};
use crate::mechanics::press::{PressError, Pressed};
use crate::output::OutputFolder;
use crate::pages::facts::columns;
use crate::pages::press::press_report;
use crate::pages::press::press_rows;
use crate::pages::press_files::write_press;
use crate::pipeline::{PressSummary, Truth};
use crate::scene::LoadedScene;
use crate::vary::Set;
use clap::Args;
use serde_json::json;
use std::path::PathBuf;

/// Press a scene's phantom: forces, contact.csv, deformed.vtu and pictures.
///
/// A press that stops early keeps the loads that it reached, in the same files, and ends with exit code 3.
#[derive(Debug, Args)]
pub(super) struct Press {
    /// Scene file, or preset:NAME for a scene that comes with the program.
    scene: PathBuf,
    /// Output folder; out/NAME if not given.
    #[arg(short, long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Replace the folder, if this program wrote all that it holds.
    #[arg(long)]
    force: bool,
    /// Press the phantom without its inclusions, on the same mesh.
    #[arg(long)]
    without_inclusions: bool,
    /// Set a key of the scene, as in `stack.layer[0].n=1.42`; may be given again.
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<Set>,
    #[command(flatten)]
    talk: Talk,
}

impl Press {
    pub(super) fn run(&self) -> Result<Outcome, Failure> {
        let (loaded, file) = open_with(&self.scene, &self.set)?;
        if loaded.scene.press.is_none() {
            let message = format!("{}: {}", file.display(), PressError::NoPress);
            return Err(Failure::input(message).in_file(&file).at_key("press"));
        }
        let name = loaded.scene.name.clone();
        let place = self.out.clone().unwrap_or_else(|| PathBuf::from("out").join(&name));
        let folder = OutputFolder::create(&place, self.force)?;
        match press_scene(&loaded, &file, self.without_inclusions, self.talk.quiet) {
            Ok(pressed) => self.finish(&loaded, &pressed, folder, None).map(|()| Outcome::Done),
            Err(PressFailure { failure, reached: Some(reached) }) if !reached.steps.is_empty() => {
                self.finish(&loaded, &reached, folder, Some(&failure))?;
                Err(failure)
            }
            Err(PressFailure { failure, .. }) => Err(failure),
        }
    }

    /// Writes what was reached; with a reason, marked as cut short.
    fn finish(
        &self,
        loaded: &LoadedScene,
        pressed: &Pressed,
        folder: OutputFolder,
        stopped: Option<&Failure>,
    ) -> Result<(), Failure> {
        let name = &loaded.scene.name;
        let lift_mm = loaded.scene.stack.height_mm();
        let truth = Truth::of(loaded.scene.phantom.as_ref(), &loaded.files, self.without_inclusions)?;
        let pictures = write_press(name, pressed, lift_mm, &folder)?;
        if let Some(failure) = stopped {
            folder.write("STOPPED.txt", &format!("{}\nThe files hold the loads before that.\n", failure.message()))?;
        }
        folder.write(
            "report.html",
            &press_report(loaded, pressed, &truth, &pictures, stopped.map(Failure::message), command_line()).to_html(),
        )?;
        let mut result =
            json!({"scene": name, "inputs": loaded.inputs(), "truth": truth, "mechanics": PressSummary::of(pressed)});
        if let Some(failure) = stopped {
            result["error"] = failure.json()["error"].take();
        }
        let done = command::commit(folder, Some(&loaded.text), result)?;
        let out = done.out;
        if stopped.is_some() {
            super::note(&format!("what was reached is in {out}"));
            return Ok(());
        }
        if self.talk.json {
            return print(&done.json);
        }
        let mut rows = press_rows(pressed);
        rows.push(("folder".into(), format!("{out}: contact.csv deformed.vtu pressure.svg report.html")));
        print(&format!("{name}\n{}", columns(&rows)))
    }
}
