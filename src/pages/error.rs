//! Why there is no page.

use crate::camera::ProjectionError;
use crate::image_io::ImageError;
use crate::output::OutputError;
use crate::report::{PictureError, VtuError};
use crate::stability::StabilityError;
use crate::study::StudyError;
use thiserror::Error;

/// The error of what a page is made of.
#[derive(Debug, Error)]
pub enum PageError {
    /// A picture that cannot be drawn.
    #[error(transparent)]
    Picture(#[from] PictureError),
    /// A camera that does not see the face.
    #[error(transparent)]
    Projection(#[from] ProjectionError),
    /// An image that cannot be read or written.
    #[error(transparent)]
    Image(#[from] ImageError),
    /// A file that cannot be written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// An extreme case that cannot be computed.
    #[error(transparent)]
    Case(#[from] StabilityError),
    /// A study whose sweeps cannot be read.
    #[error(transparent)]
    Study(Box<StudyError>),
    /// A file of the press.
    #[error("{file}: {error}")]
    Vtu {
        /// Its name.
        file: String,
        /// Why it cannot be made.
        error: VtuError,
    },
    /// A table.
    #[error("{file}: {error}")]
    Table {
        /// Its name.
        file: &'static str,
        /// Why it cannot be made.
        error: Box<dyn std::error::Error + Send + Sync>,
    },
}

impl From<StudyError> for PageError {
    fn from(error: StudyError) -> Self {
        Self::Study(Box::new(error))
    }
}
