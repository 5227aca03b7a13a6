//! Emulators: fast stand-ins of a slow simulation, learnt from some of its results.

pub mod components;
pub mod gaussian_process;
mod trend;
pub(crate) mod weighted_points;
pub use components::Components;
pub use gaussian_process::{Evaluator, FitError, GaussianProcess, Predicted, Slopes, Variances};
