//! A press that failed, and what one takes.

use super::Failure;
use crate::mechanics::from_scene::press_setup;
use crate::mechanics::path::PathError;
use crate::mechanics::press::{Cost, PressError, Pressed};
use crate::scene::LoadedScene;
use std::path::Path;

/// What the press of a scene will take, if it has one.
pub(super) fn press_cost(loaded: &LoadedScene, file: &Path) -> Result<Option<Cost>, Failure> {
    let cost = match press_setup(loaded) {
        Err(PressError::NoPress) => return Ok(None),
        setup => setup.and_then(|setup| Cost::of(&setup, None)),
    };
    cost.map(Some).map_err(|error| PressFailure::of(error, file).failure)
}

/// A press that failed, and what it reached.
pub(super) struct PressFailure {
    pub failure: Failure,
    pub reached: Option<Box<Pressed>>,
}

impl PressFailure {
    /// What a scene's press says, with the scene's file.
    pub fn of(error: PressError, file: &Path) -> Self {
        let words = format!("{}: {error}", file.display());
        let (failure, reached) = match error {
            PressError::Stopped { cause: PathError::Stopped, .. } => {
                return Self { failure: Failure::cancelled(), reached: None };
            }
            PressError::Stopped { reached, .. } => (Failure::failed(words), Some(reached)),
            _ => (Failure::input(words), None),
        };
        Self { failure: failure.in_file(file), reached }
    }
}
