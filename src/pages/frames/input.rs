//! Where frames come from: a scene that is computed, or a measured table.

use super::source::{Source, setup_of};
use crate::mechanics::frames::scan::{ScanError, ScanSetup};
use crate::mechanics::frames::{Frames, read_frames};
use crate::progress::Stage;
use crate::scene::{DataFileError, LoadedScan, SceneError, open_scan};
use std::path::{Path, PathBuf};
use thiserror::Error;

/// What frames are of, read and found in order.
pub enum Input {
    /// A scan scene.
    Scene(Box<(LoadedScan, ScanSetup, PathBuf)>),
    /// Measured frames and their file.
    Measured(Frames, PathBuf),
}

/// Why there are none.
#[derive(Debug, Error)]
pub enum InputError {
    /// A scene that is none.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A table that is none.
    #[error(transparent)]
    Table(#[from] DataFileError),
    /// A scene that cannot be scanned.
    #[error("{}: {error}", file.display())]
    Scan {
        /// The scene.
        file: PathBuf,
        /// Why.
        error: Box<ScanError>,
    },
}

impl Input {
    /// A scan scene, which must make sense.
    ///
    /// # Errors
    /// Where it makes none.
    pub fn scene_of(scene: &Path) -> Result<Self, InputError> {
        let (loaded, file) = open_scan(scene)?;
        let failed = |error| InputError::Scan { file: file.clone(), error: Box::new(error) };
        let setup = setup_of(&loaded).map_err(failed)?;
        Ok(Self::Scene(Box::new((loaded, setup, file))))
    }

    /// Measured frames.
    ///
    /// # Errors
    /// A table that is none.
    pub fn measured(file: &Path) -> Result<Self, InputError> {
        Ok(Self::Measured(read_frames(file)?, file.into()))
    }

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

    /// Computes the frames where they are not measured, and hears meanwhile whether to go on.
    ///
    /// # Errors
    /// What the solver says, a stop.
    pub fn frames(self, shown_mm: f64, observe: &(dyn Fn(Stage) -> bool + Sync)) -> Result<Source, ScanError> {
        let name = self.name();
        match self {
            Self::Scene(scene) => {
                let (loaded, setup, _) = *scene;
                Source::scan(loaded, setup, shown_mm, observe)
            }
            Self::Measured(frames, file) => Ok(Source::measured(name, frames, &file)),
        }
    }
}
