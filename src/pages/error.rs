//! Why there is no page.

use crate::camera::ProjectionError;
use crate::image_io::ImageError;
use crate::output::OutputError;
use crate::report::{PictureError, VtuError};
use crate::stability::StabilityError;
use thiserror::Error;

/// The error of what a page is made of.
#[derive(Debug, Error)]
pub enum PageError {
    #[error(transparent)]
    Picture(#[from] PictureError),
    #[error(transparent)]
    Projection(#[from] ProjectionError),
    #[error(transparent)]
    Image(#[from] ImageError),
    #[error(transparent)]
    Output(#[from] OutputError),
    #[error(transparent)]
    Case(#[from] StabilityError),
    /// A file of the press.
    #[error("{file}: {error}")]
    Vtu { file: String, error: VtuError },
    /// A table.
    #[error("{file}: {error}")]
    Table { file: &'static str, error: csv::Error },
}
