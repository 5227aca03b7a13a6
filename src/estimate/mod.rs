//! The estimators of the tactile-sensation imaging system (TSIS; Biosensors 2026, 16(2):102) on any grey image.
//!
//! Each answer is a [`Value`]: a number with an interval, or "undefined" with the reason; never NaN, infinity or a
//! zero that stands for "nothing found". Pixel coordinates count from the upper left corner of the image, the centre of
//! the first pixel being (0.5, 0.5), as in [`crate::camera`].

pub mod calibration;
pub mod image;
pub mod paper;
pub mod stiffness;
pub mod value;

pub use calibration::{Calibration, CalibrationError};
pub use image::{GreyImage, ImageError};
pub use paper::{PaperEstimate, Settings, estimate};
pub use stiffness::{Stiffness, stiffness};
pub use value::Value;

use serde::Serialize;

/// What the inclusion is like, as far as one image and a calibration can say.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Estimates {
    /// Diameter of the lit area, mm.
    pub size_mm: Value,
    /// Depth of the inclusion, mm.
    pub depth_mm: Value,
    /// Young's modulus of the inclusion, kPa.
    pub youngs_kpa: Value,
}

impl Estimates {
    /// Converts the paper's figures. The paper calibrates only the scale: depth and modulus stay undefined, its depth
    /// indicator being a grey value and its stiffness relative.
    pub fn from_paper(paper: &PaperEstimate, calibration: Option<&Calibration>) -> Self {
        let size_mm = match calibration {
            Some(calibration) => paper.diameter_px.scaled(calibration.mm_per_pixel),
            None => Value::undefined("no calibration gives the millimetres per pixel"),
        };
        Self {
            size_mm,
            depth_mm: Value::undefined("the depth indicator h is a grey value; no model relates it to millimetres"),
            youngs_kpa: Value::undefined("the paper's stiffness is relative; no model relates it to a modulus"),
        }
    }
}
