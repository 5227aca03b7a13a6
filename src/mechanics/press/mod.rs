//! The press of a phantom against the sensor: from a description to forces, pressures and displacements.
//!
//! The phantom's base moves towards the sensor, whose glass stands still; the load factor is that motion in mm.

pub mod assembly;
pub mod contact_curve;
mod cost;
pub mod error_estimate;
mod load;
mod run;
mod setup;

pub use super::read_out::{element_least_jacobian, element_pressure};
pub use assembly::Assembly;
pub use contact_curve::{ContactPoint, contact_points};
pub use cost::Cost;
pub use error_estimate::PressureError;
pub use run::{PressSettings, PressStage, PressStep, Pressed, press};
pub use setup::{Load, SensorBody, Setup};

use super::material::MaterialError;
use super::memory;
use super::mesh::MeshError;
use super::path::PathError;
use crate::scene::DataFileError;
use thiserror::Error;

/// Why a press did not come to its end.
#[derive(Debug, Error)]
pub enum PressError {
    /// The scene has no press.
    #[error("the scene has no [press]")]
    NoPress,
    /// What cannot be computed, and what can.
    #[error("{0}")]
    Unsupported(String),
    /// More than there is memory for.
    #[error(
        "the press of {unknowns} unknowns takes about {memory_gib:.1} GiB, the limit is {limit_gib:.1} GiB ({}): {}",
        memory::VARIABLE,
        match fits {
            Some(share) => format!("press.resolution times {share} fits"),
            None => "a quarter of press.resolution is still too much".to_owned(),
        }
    )]
    TooLarge {
        /// Displacement unknowns.
        unknowns: usize,
        /// What it takes, GiB.
        memory_gib: f64,
        /// What it may take, GiB.
        limit_gib: f64,
        /// Share of the resolution that would fit.
        fits: Option<f64>,
    },
    /// The geometry.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// A material.
    #[error(transparent)]
    Material(#[from] MaterialError),
    /// A file that the scene names.
    #[error(transparent)]
    File(#[from] DataFileError),
    /// A load was not reached; the steps before it are kept.
    #[error("{cause}")]
    Stopped {
        /// Why.
        cause: PathError,
        /// What was reached.
        reached: Box<Pressed>,
    },
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod solid_tests;
#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;
