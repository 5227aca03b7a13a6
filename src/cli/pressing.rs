//! A press that failed.

use super::Failure;
use crate::mechanics::path::PathError;
use crate::mechanics::press::{PressError, Pressed};
use std::path::Path;

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
