//! The press of a phantom against the sensor: from a description to forces, pressures and displacements.
//!
//! The phantom's base moves towards the sensor, whose glass stands still; the load factor is that motion in mm.

pub mod assembly;
mod carry;
pub mod contact_curve;
mod cost;
mod error;
pub mod error_estimate;
mod load;
mod run;
mod setup;
mod tilt;

pub use super::read_out::{element_least_jacobian, element_pressure, element_stress};
pub use assembly::Assembly;
pub use contact_curve::{ContactPoint, contact_points};
pub use cost::Cost;
pub use error::PressError;
pub use error_estimate::{PressureError, Rounding};
pub use run::{PressSettings, PressStep, Pressed, press, press_near};
pub use setup::{Load, Pose, SensorBody, Setup};

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod path_tests;
#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod placed_tests;
#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod solid_tests;
#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;
