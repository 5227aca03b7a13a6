//! Why a result is not on disk.

use crate::image_io::ImageError;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Why a folder was not written.
#[derive(Debug, Error)]
pub enum OutputError {
    /// The place is not taken; nothing there has changed.
    #[error("{}: {why}", place.display())]
    Refused {
        /// The folder, or the file in it.
        place: PathBuf,
        /// What is wrong with it.
        why: String,
        /// What would help.
        remedy: Remedy,
    },
    /// The system refused.
    #[error("{}: {why}", place.display())]
    Failed {
        /// The folder, or the file in it.
        place: PathBuf,
        /// What it said.
        why: String,
    },
    /// An image could not be written.
    #[error(transparent)]
    Image(#[from] ImageError),
    /// The user stopped it.
    #[error("stopped")]
    Stopped,
}

/// What helps where a place is refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Remedy {
    /// Only what the reason says.
    Mend,
    /// Another folder.
    Elsewhere,
    /// That, or to replace the folder.
    Replace,
    /// That, or to go on with its records.
    GoOn,
}

impl OutputError {
    pub(crate) fn refused(place: &Path, why: impl Into<String>, remedy: Remedy) -> Self {
        Self::Refused { place: place.into(), why: why.into(), remedy }
    }

    /// Of an image that was to come to a place by way of another.
    pub(super) fn of_image(error: ImageError, place: &Path) -> Self {
        match error {
            ImageError::Write { source, .. } => Self::failed(place, format!("cannot be written: {source}")),
            error => Self::Image(error),
        }
    }

    pub(super) fn failed(place: &Path, why: impl Into<String>) -> Self {
        Self::Failed { place: place.into(), why: why.into() }
    }
}
