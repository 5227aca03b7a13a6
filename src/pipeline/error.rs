//! Why there is no image, or no reading of it.

use crate::camera::ProjectionError;
use crate::camera::exposure::ExposureError;
use crate::estimate::GreyImageError;
use crate::mechanics::press::PressError;
use crate::surface::SurfaceError;
use crate::trace::TraceError;
use thiserror::Error;

/// The error of one stage.
#[derive(Debug, Error)]
#[allow(missing_docs)] // each variant but one is the error of one stage
pub enum PipelineError {
    #[error(transparent)]
    Press(#[from] PressError),
    #[error(transparent)]
    Surface(#[from] SurfaceError),
    #[error(transparent)]
    Trace(#[from] TraceError),
    #[error(transparent)]
    Exposure(#[from] ExposureError),
    #[error(transparent)]
    Projection(#[from] ProjectionError),
    #[error(transparent)]
    Image(#[from] GreyImageError),
    /// An indenter presses in the sensor's place: there is no light.
    #[error("press.indenter: an indenter guides no light; it is for presses alone")]
    NoLight,
    /// The press has no such load.
    #[error("load {load} (counted from 0) of a press that has {of}")]
    NoLoad {
        /// Which was asked for.
        load: usize,
        /// How many there are.
        of: usize,
    },
    /// What is wanted needs a press.
    #[error("there is no baseline to subtract, since the scene presses nothing")]
    NoBaseline,
}
