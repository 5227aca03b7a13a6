//! Error against run time: ladders of settings, each rung against an independent, finer reference.
//!
//! Light: a rung is rendered several times with seeds of its own. The mean square difference to the reference over the
//! lit pixels, less what the reference's own noise adds to it, is the rung's error, noise and bias together. Mechanics:
//! a rung is a mesh or a number of load steps, its error the difference to a finer mesh, and the interval what that
//! mesh itself may be off by.

mod climb;
pub mod light;
pub mod mechanics;
mod statistics;

pub use climb::{Climb, ClimbError, Part};
pub use statistics::{fitted_slope, is_lit, is_soft, pareto, square_error};

use serde::{Deserialize, Serialize};

/// An error with its 95 % interval.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ErrorEstimate {
    /// Best value; 0 where the difference does not exceed the reference's own error.
    pub value: f64,
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

/// A rung that was measured.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Rung {
    /// What the ladder varies.
    pub family: String,
    /// Which of several ladders of the family.
    pub series: String,
    /// The rung's setting, in words.
    pub setting: String,
    /// The value varied, where it is a number.
    pub level: Option<f64>,
    /// Name of the error: of the radiance, the force or the pressure.
    pub quantity: String,
    /// Error as a share of the quantity.
    pub error: ErrorEstimate,
    /// Run time: tracing after compilation, or the press; s.
    pub seconds: f64,
    /// Runs behind error and time.
    pub repeats: u32,
    /// Whether these are the settings that a run without flags takes.
    pub is_default: bool,
}

/// What a ladder is about.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Family {
    /// Its name, as in [`Rung::family`].
    pub name: &'static str,
    /// Title of its picture.
    pub title: &'static str,
    /// Slopes that theory gives for error against time, with their reasons.
    pub slopes: &'static [(f64, &'static str)],
}

/// All families.
pub const FAMILIES: [Family; 7] = [
    Family { name: "samples", title: "samples and integrator", slopes: &[(-0.5, "Monte Carlo, slope −1/2")] },
    Family { name: "map texel", title: "texels of the map", slopes: &[] },
    Family { name: "height field", title: "points of height fields", slopes: &[] },
    Family { name: "precision", title: "arithmetic", slopes: &[] },
    Family {
        name: "mesh",
        title: "finite elements",
        slopes: &[(-0.5, "first order in 2-D, slope −1/2"), (-1.0, "second order in 2-D, slope −1")],
    },
    Family {
        name: "element order",
        title: "order of the elements",
        slopes: &[(-0.5, "first order in 2-D, slope −1/2"), (-1.0, "second order in 2-D, slope −1")],
    },
    Family { name: "load steps", title: "load steps", slopes: &[] },
];

/// Ladders that were climbed.
#[derive(Debug, Clone)]
pub struct Ladders {
    /// All rungs.
    pub rungs: Vec<Rung>,
    /// What the light was compared with, or why there is no error of the light.
    pub light: Result<String, String>,
    /// The same of the mechanics.
    pub mechanics: Result<String, String>,
}
