//! `calibrate`: learn what a sensor's frames say of an inclusion.

use super::command::described;
use super::sweep::How;
use super::{Failure, Outcome, note, print};
use crate::calibrate::{CalibrateError, CalibrationFile, FrameModel, Training};
use crate::sweep::Sweep;
use clap::Args;
use serde_json::json;
use std::path::{Path, PathBuf};

/// Name of the file that is learnt.
const FILE: &str = "calibration.json";

/// Learn what a sensor's frames say of an inclusion, from phantoms that sweeps press and trace; `estimate
/// --calibration` and `run --calibration` read frames by it.
#[derive(Debug, Args)]
pub(super) struct Calibrate {
    /// Calibration file: the sweeps to learn from.
    calibration: PathBuf,
    #[command(flatten)]
    how: How,
}

impl Calibrate {
    pub(super) fn run(&self) -> Result<Outcome, Failure> {
        let parts = CalibrationFile::load(&self.calibration)?.calibrate;
        let name = self.calibration.file_stem().unwrap_or_default();
        let out = self.how.place_or(|| PathBuf::from("out").join(name));
        let mut whole = true;
        let mut part = |part: &Path, name: &str| -> Result<PathBuf, Failure> {
            if part.is_dir() {
                return Ok(part.to_path_buf());
            }
            let folder = out.join(name);
            whole &= self.how.part(&Sweep::load(part)?, &folder)?;
            Ok(folder)
        };
        let design = part(&parts.design, "design")?;
        let leds = parts.leds.as_deref().map(|leds| part(leds, "leds")).transpose()?;
        let empty = parts.empty.as_deref().map(|empty| part(empty, "empty")).transpose()?;
        if !whole {
            return self.wait(&out);
        }
        let design = Training::read(&design)?;
        let leds = leds.as_deref().map(Training::read).transpose()?;
        let empty = empty.as_deref().map(Training::read).transpose()?;
        if !self.how.is_quiet() {
            note(&format!("learning from {} phantoms", design.points.len()));
        }
        let model = FrameModel::learn(&design, leds.as_ref(), empty.as_ref())?;
        let failed = |error: &dyn std::fmt::Display| Failure::failed(format!("{}: {error}", out.display()));
        std::fs::create_dir_all(&out).map_err(|error| failed(&error))?;
        let text = serde_json::to_string(&model).map_err(|error| failed(&error))?;
        let file = out.join(FILE);
        FrameModel::parse(&text, &file)?;
        // There in whole or not at all.
        let partial = out.join(format!("{FILE}.partial"));
        std::fs::write(&partial, text + "\n").map_err(|error| failed(&error))?;
        std::fs::rename(&partial, &file).map_err(|error| failed(&error))?;
        let told = json!({"phantoms": design.points.len(), "scores": model.scores(), "file": file});
        match self.how.is_json() {
            true => print(&described(told, Some(&out)).to_string())?,
            false => print(&format!(
                "learnt from {} phantoms, by {} scores\n{}",
                design.points.len(),
                model.scores(),
                file.display()
            ))?,
        }
        Ok(Outcome::Done)
    }

    /// Says that others have points to compute yet.
    fn wait(&self, out: &Path) -> Result<Outcome, Failure> {
        let told = json!({"phantoms": null, "scores": null, "file": null});
        match self.how.is_json() {
            true => print(&described(told, Some(out)).to_string())?,
            false => print(&format!(
                "{}: not all points are there yet; the same command without --engine and --shard goes on, and learns",
                out.display()
            ))?,
        }
        Ok(Outcome::Done)
    }
}

impl From<CalibrateError> for Failure {
    fn from(error: CalibrateError) -> Self {
        match error {
            CalibrateError::Folder(error) => error.into(),
            CalibrateError::Image(error) => error.into(),
            CalibrateError::Fit(_) => Self::failed(error.to_string()),
            CalibrateError::Unsuited { ref folder, .. } => {
                let folder = folder.clone();
                Self::input(error.to_string()).in_file(&folder)
            }
            CalibrateError::File { ref file, .. } => {
                let file = file.clone();
                Self::input(error.to_string()).in_file(&file)
            }
        }
    }
}
