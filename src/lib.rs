//! Simulator of the multilayer total-internal-reflection tactile sensor.
//!
//! ```text
//! scene.toml -> Scene -> Surface -> Film -> Frame -> Estimate -> Report
//!               scene    surface    trace   camera   estimate    report
//! ```
//!
//! One folder a stage, in the order of the data; a stage imports only earlier ones.

pub mod camera;
pub mod cli;
pub mod estimate;
pub mod film;
pub mod image_io;
pub mod optics;
pub mod report;
pub mod scene;
pub mod surface;
pub mod trace;
