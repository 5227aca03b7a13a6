//! The estimators of the tactile-sensation imaging system (TSIS; Biosensors 2026, 16(2):102) on any grey image.
//!
//! Each answer is a [`Value`]: a number with an interval, or "undefined" with the reason; never NaN, infinity or a
//! zero that stands for "nothing found". Pixel coordinates count from the upper left corner of the image, the centre of
//! the first pixel being (0.5, 0.5), as in [`crate::camera`].

pub mod calibration;
pub mod exposed;
pub mod image;
pub mod paper;
pub mod sensor;
mod spread;
pub mod stiffness;
mod threshold;
pub mod tissue;
mod told;
pub mod value;

pub use calibration::{Calibration, CalibrationError};
pub use exposed::Exposed;
pub use image::{GreyImage, GreyImageError};
pub use paper::{PaperEstimate, Settings, estimate, measure};
pub use spread::Subtracted;
pub use stiffness::{Stiffness, stiffness};
pub use threshold::Threshold;
pub use told::scattered;
pub use value::Value;

use serde::Serialize;

/// Whether there is an inclusion.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[serde(untagged)]
pub enum Detected {
    /// There is one, or none is told from noise.
    Known(bool),
    /// It cannot be said.
    Undefined {
        /// Why.
        undefined: String,
    },
}

/// What the inclusion is like, as far as a calibrated model can say.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Estimates {
    /// Width of the inclusion, mm.
    pub size_mm: Value,
    /// Depth of the inclusion's top, mm.
    pub depth_mm: Value,
    /// Young's modulus of the inclusion, kPa.
    pub youngs_kpa: Value,
    /// Whether there is an inclusion at all.
    pub detected: Detected,
}

impl Estimates {
    /// Without a calibration, for the reason given. The paper's figures are none: the lit area holds all that glows,
    /// which is wider than what presses, its depth indicator is a grey value and its stiffness relative.
    pub fn undefined(reason: &str) -> Self {
        let undefined = |why: &str| Value::undefined(format!("{reason}; {why}"));
        Self {
            size_mm: undefined("the diameter of the lit area (paper.diameter_mm) is not that of the inclusion"),
            depth_mm: undefined("the depth indicator (paper.h_grey) is a grey value"),
            youngs_kpa: undefined("the paper's stiffness is relative"),
            detected: Detected::Undefined { undefined: reason.to_owned() },
        }
    }

    /// Without a calibrated model.
    pub fn without_model() -> Self {
        Self::undefined("no calibrated model")
    }
}
