//! The press of a phantom against the sensor: from a description to forces, pressures and displacements.
//!
//! The phantom's base moves towards the sensor, whose glass stands still. The load factor is that motion in mm, or the
//! length of the path where the base is led in steps: at each of these the solver turns the motion of what is held.
//!
//! `setup.rs` describes what is pressed against what; `assembly.rs` meshes it and makes a
//! [`Problem`](super::problem::Problem) (one mesh with regions, supports, contacts); [`newton`](super::newton) finds
//! the [`State`](super::problem::State) at a load; [`path`](super::path) follows the loads; `run.rs` reads forces and
//! pressures. [`solid`](super::solid) is one element, [`contact`](super::contact) one pair of faces.
//!
//! A press starts at each depth from what another one found there, if there is one: that of a phantom much like it, or
//! that on a coarser mesh, which also estimates the error (`carry.rs`).

pub mod assembly;
mod assembly_error;
mod carry;
pub mod contact_curve;
mod cost;
mod error;
pub mod error_estimate;
mod face;
pub mod facets;
mod findings;
mod load;
mod pressed;
mod ready;
mod run;
mod setup;
mod tilt;

pub use super::problem::TIME_STEPS;
pub use super::read_out::{element_least_jacobian, element_pressure, element_stress};
pub use assembly::Assembly;
pub use assembly_error::AssemblyError;
pub use contact_curve::{ContactPoint, contact_points};
pub use cost::Cost;
pub use error::PressError;
pub use face::{Face, is_judged, pressure_facets};
pub use findings::Findings;
pub use pressed::{PressStep, Pressed, PressureError, Rounding};
pub use run::{PressSettings, press, press_near};
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
