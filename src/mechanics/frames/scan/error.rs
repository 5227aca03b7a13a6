//! What can go wrong, and how exact a frame is.

use crate::mechanics::frames::FramesError;
use crate::mechanics::material::MaterialError;
use crate::mechanics::mesh::MeshError;
use crate::mechanics::path::PathError;
use crate::mechanics::press::PressError;
use crate::scene::DataFileError;
use serde::Serialize;
use thiserror::Error;

/// Why there are no frames.
#[derive(Debug, Error)]
pub enum ScanError {
    /// The geometry.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// A material.
    #[error(transparent)]
    Material(#[from] MaterialError),
    /// A file that the scene names.
    #[error(transparent)]
    File(#[from] DataFileError),
    /// A tissue whose truth cannot be told.
    #[error(transparent)]
    Truth(Box<PressError>),
    /// One position did not come to its end.
    #[error("the indenter at {position_mm} mm, {tissue}: {cause}")]
    Position {
        /// Position of the indenter, mm.
        position_mm: f64,
        /// Which tissue: with or without its inclusions.
        tissue: &'static str,
        /// Why.
        cause: PathError,
    },
    /// No depth was found at which the indenter carries the force.
    #[error("the indenter at {position_mm} mm: no depth within the tissue has the force of the frame there")]
    Force {
        /// Position of the indenter, mm.
        position_mm: f64,
    },
    /// The frames do not belong together.
    #[error(transparent)]
    Frames(#[from] FramesError),
    /// The caller stopped it.
    #[error("stopped")]
    Stopped,
}

/// Estimated discretisation error of one frame, from a mesh of twice the element size.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct FrameError {
    /// Position of the frame, mm.
    pub position_mm: f64,
    /// Root mean square of the pressure's error over the contact, as a share of the pressure's own.
    pub rms: f64,
    /// Error of the highest pressure, as a share of it.
    pub peak: f64,
}
