//! Calibrations: what a sensor's frames say of an inclusion, learnt from simulated frames of many.
//!
//! A sweep draws phantoms and keeps the radiance of each load. [`FrameModel::learn`] learns from it how the frames
//! follow the unknowns ([`crate::infer`]); a second sweep of phantoms without an inclusion tells what is seen where
//! there is none, a third one, of one LED at a time, what each LED's power does. Frames of a camera are then inverted:
//! size, depth and modulus of the inclusion with intervals, all else integrated away, or "undefined" with the reason.

mod blocks;
mod bound;
mod estimates;
mod file;
mod frames;
mod left_out;
mod model;
mod reader;
mod ready;
mod suits;
mod training;

pub use blocks::Blocks;
pub use bound::{Bounds, Inclusion, Limits, Protocol};
pub use estimates::{Inferred, InferredUnknown, LedPower};
pub use file::{CalibrationFile, Folders, Parts, Trainings};
pub(crate) use frames::same_depth;
pub use frames::{FORCE_ERROR, Frames, PressFrame, Presses, check_depths, check_forces};
pub use left_out::{Held, LeftOut, left_out_text};
pub use model::{FrameModel, Odd, odd_text};
pub use ready::{estimates_of, ready};
pub use training::Training;
pub(crate) use training::sweep_of;

use crate::image_io::ImageError;
use crate::infer::FitError;
use crate::output::OutputError;
use crate::sweep::SweepFolderError;
use std::path::PathBuf;

/// Why there is no calibration.
#[derive(Debug, thiserror::Error)]
pub enum CalibrateError {
    /// A folder that is none of a sweep.
    #[error(transparent)]
    Folder(#[from] SweepFolderError),
    /// A sweep that nothing can be learnt from.
    #[error("{}: {why}", .folder.display())]
    Unsuited {
        /// Its folder.
        folder: PathBuf,
        /// Why.
        why: String,
    },
    /// An image that cannot be read.
    #[error(transparent)]
    Image(#[from] ImageError),
    /// A file that cannot be written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// Points that tell too little.
    #[error(transparent)]
    Fit(#[from] FitError),
    /// A file that is no calibration.
    #[error("{}: is no calibration: {why}", .file.display())]
    File {
        /// The file.
        file: PathBuf,
        /// Why.
        why: String,
    },
}
