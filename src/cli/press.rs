//! `press`: mechanics only.

use super::command::{self, command_line};
use super::flags::{Place, SceneFile};
use super::job::watched;
use super::{Failure, Outcome, PressFailure, Talk};
use crate::mechanics::press::{PressError, Pressed};
use crate::output::OutputFolder;
use crate::pages::facts::columns;
use crate::pages::press::{press_rows, write};
use crate::pipeline::{Order, PipelineError, Session, Truth};
use crate::scene::LoadedScene;
use crate::trace::{Devices, Precision};
use clap::Args;

/// Press a scene's phantom: forces, contact.csv, deformed.vtu and pictures.
///
/// A press that stops early keeps the loads that it reached, in the same files, and ends with exit code 3.
#[derive(Debug, Args)]
pub(super) struct Press {
    #[command(flatten)]
    scene: SceneFile,
    #[command(flatten)]
    place: Place,
    /// Press the phantom without its inclusions, on the same mesh.
    #[arg(long)]
    without_inclusions: bool,
    #[command(flatten)]
    talk: Talk,
}

impl Press {
    pub(super) fn run(&self) -> Result<Outcome, Failure> {
        let (loaded, file) = self.scene.open()?;
        if loaded.scene.press.is_none() {
            let message = format!("{}: {}", file.display(), PressError::NoPress);
            return Err(Failure::input(message).in_file(&file).at_key("press"));
        }
        let folder = self.place.take(&loaded.scene.name)?;
        let order = Order { without_inclusions: self.without_inclusions, ..Order::of(&loaded.scene) };
        let mut session = Session::from(Devices::cpu(Precision::F32));
        match watched(self.talk.quiet, |observe| session.press(&loaded, &order, observe)) {
            Ok(pressed) => self.finish(&loaded, &pressed, folder, None).map(|()| Outcome::Done),
            Err(PipelineError::Press(error)) => {
                let PressFailure { failure, reached } = PressFailure::of(error, &file);
                if let Some(reached) = reached.filter(|reached| !reached.steps.is_empty()) {
                    self.finish(&loaded, &reached, folder, Some(&failure))?;
                }
                Err(failure)
            }
            Err(error) => Err(Failure::of_scene(error, &file)),
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
        let truth = Truth::of(loaded.scene.phantom.as_ref(), &loaded.files, self.without_inclusions)?;
        let why = stopped.map(Failure::message);
        let mut result = write((loaded, pressed), &truth, why, command_line(), &folder)?;
        if let Some(failure) = stopped {
            result["error"] = failure.json()["error"].take();
        }
        let done = command::commit(folder, Some(&loaded.text), result)?;
        if stopped.is_some() {
            super::note(&format!("what was reached is in {}", done.out));
            return Ok(());
        }
        let mut rows = press_rows(pressed);
        rows.push(("folder".into(), format!("{}: contact.csv deformed.vtu pressure.svg report.html", done.out)));
        self.talk.tell(&done.json, format!("{}\n{}", loaded.scene.name, columns(&rows))).map(|_| ())
    }
}
