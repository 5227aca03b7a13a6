//! Studies: true against estimated, for hundreds of phantoms that a calibration was not learnt from.
//!
//! Sweeps press and trace the phantoms and keep the radiance of each load; [`trials`] exposes it with the noise of the
//! camera and inverts the frames by the calibration; [`Summary`] says how far off estimates are and how often intervals
//! hold. [`readings`] reads a figure of the TSIS paper from the images instead.

mod file;
mod paper;
mod reader;
mod summary;
mod trial;

pub use file::{Parts, StudyFile};
pub use paper::{Paper, PaperFigure, PaperSummary, Phantom, Reading, readings};
pub use reader::Reader;
pub use summary::{Group, Quantity, Reason, Smallest, Summary, Told, UnknownSummary};
pub use trial::{How, Other, Trial, trials};

use crate::calibrate::CalibrateError;
use crate::camera::ExposureError;
use crate::estimate::{CalibrationError, GreyImageError};
use crate::mechanics::press::PressError;
use crate::statistics::StatisticsError;
use std::path::PathBuf;

/// Why there is no study.
#[derive(Debug, thiserror::Error)]
pub enum StudyError {
    /// A folder that is none of a sweep of phantoms that the calibration reads, an image or a calibration that cannot
    /// be read.
    #[error(transparent)]
    Sweep(#[from] CalibrateError),
    /// A calibration of the sensor that cannot be read.
    #[error(transparent)]
    Calibration(#[from] CalibrationError),
    /// One that a stiffness cannot be found by.
    #[error("{}: needs bottom_area_mm2 and force_n_from_sum_grey for a stiffness", file.display())]
    Lacking {
        /// Its file.
        file: PathBuf,
    },
    /// A depth whose frames are to be told, of no press that the calibration knows.
    #[error("study.depths_mm: {asked} mm is of no press that the calibration knows: {known} mm")]
    Depth {
        /// The depth, mm.
        asked: f64,
        /// Those that it knows.
        known: String,
    },
    /// The calibration that comes with the program is none.
    #[error("the calibration that comes with the program is damaged")]
    Damaged,
    /// A camera that makes no sense.
    #[error(transparent)]
    Exposure(#[from] ExposureError),
    /// A frame that is none.
    #[error(transparent)]
    Frame(#[from] GreyImageError),
    /// A phantom that makes no sense.
    #[error(transparent)]
    Phantom(#[from] PressError),
    /// Numbers that no statistic can be made of.
    #[error(transparent)]
    Statistics(#[from] StatisticsError),
}
