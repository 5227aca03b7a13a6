//! Where frames come from: a scene that is computed, or a measured table.

use super::super::{Failure, Progress, cancel};
use crate::mechanics::frames::scan::ScanSetup;
use crate::mechanics::frames::{Frames, read_frames};
use crate::pages::frames::{Source, setup_of};
use crate::scene::{LoadedScan, open_scan};
use std::path::{Path, PathBuf};

/// What the command line names, read and found in order.
pub(super) enum Input {
    /// A scan scene.
    Scene(Box<(LoadedScan, ScanSetup, PathBuf)>),
    /// Measured frames and their file.
    Measured(Frames, PathBuf),
}

/// Reads what the command line names.
pub(super) fn read(scene: Option<&Path>, measured: Option<&Path>) -> Result<Input, Failure> {
    match (scene, measured) {
        (Some(scene), None) => {
            let (loaded, file) = open_scan(scene)?;
            let place = |failure: Failure| match failure.names_a_file() {
                true => failure,
                false => failure.prefixed(&file.display().to_string()).in_file(&file),
            };
            let setup = setup_of(&loaded).map_err(|error| place(error.into()))?;
            Ok(Input::Scene(Box::new((loaded, setup, file))))
        }
        (None, Some(file)) => Ok(Input::Measured(read_frames(file)?, file.to_path_buf())),
        _ => Err(Failure::usage("give either a scan scene or `--measured CSV`")),
    }
}

impl Input {
    /// Name of the output folder.
    pub fn name(&self) -> String {
        match self {
            Self::Scene(scene) => scene.0.scene.name.clone(),
            Self::Measured(_, file) => file.file_stem().unwrap_or(file.as_os_str()).to_string_lossy().into_owned(),
        }
    }

    /// The scene and its file.
    pub fn scene(&self) -> Option<(&LoadedScan, &Path)> {
        match self {
            Self::Scene(scene) => Some((&scene.0, &scene.2)),
            Self::Measured(..) => None,
        }
    }

    /// The scene's window, mm.
    pub fn window_mm(&self) -> Option<f64> {
        self.scene().and_then(|(loaded, _)| loaded.scene.scan.window_mm)
    }

    /// Computes the frames where they are not measured. Ctrl-C stops it.
    pub fn frames(self, shown_mm: f64, quiet: bool) -> Result<Source, Failure> {
        let name = self.name();
        let (loaded, setup, _) = match self {
            Self::Scene(scene) => *scene,
            Self::Measured(frames, file) => return Ok(Source::measured(name, frames, &file)),
        };
        let progress = Progress::new(quiet);
        Ok(Source::scan(loaded, setup, shown_mm, &|stage| {
            progress.observe(stage.done, stage.what);
            !cancel::requested()
        })?)
    }
}
