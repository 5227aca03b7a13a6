//! tirtouch for Python: classes and functions of the module `tirtouch._tirtouch`, which the package `tirtouch` exports.
//!
//! Python's lock is let go while something is computed, so other threads run on. Work hears Python about ten times a
//! second: signals, and the caller's `progress` (`watch.rs`). What goes wrong is an exception with the words of the
//! command line (`trouble.rs`). Figures become objects, and what `--json` prints becomes dictionaries (`json.rs`).
#![forbid(unsafe_code)]

mod arguments;
mod array;
mod calibrate;
mod calibration;
mod command_line;
mod comparison;
mod estimates;
mod exposure;
mod frames;
mod image;
mod inspection;
mod json;
mod press;
mod radiance;
mod reading;
mod run;
mod scan;
mod scene;
mod session;
mod sweep;
mod sweep_status;
mod taken;
mod trouble;
mod value;
mod watch;

use pyo3::prelude::*;

/// The command in files that are written: radiance.exr, reports.
const COMMAND: &str = "tirtouch for Python";

/// Simulator of the multilayer total-internal-reflection tactile sensor.
#[pymodule]
mod _tirtouch {
    use super::*;

    #[pymodule_export]
    use super::calibrate::calibrate;
    #[pymodule_export]
    use super::calibration::{Calibration, Unknown};
    #[pymodule_export]
    use super::command_line::_command_line;
    #[pymodule_export]
    use super::comparison::{Comparison, compare};
    #[pymodule_export]
    use super::estimates::{Estimates, estimate};
    #[pymodule_export]
    use super::exposure::Exposure;
    #[pymodule_export]
    use super::frames::{Frames, Tissue};
    #[pymodule_export]
    use super::image::Image;
    #[pymodule_export]
    use super::inspection::Inspection;
    #[pymodule_export]
    use super::press::{Load, Press};
    #[pymodule_export]
    use super::radiance::{Radiance, read_radiance};
    #[pymodule_export]
    use super::reading::Reading;
    #[pymodule_export]
    use super::run::Run;
    #[pymodule_export]
    use super::scan::Scan;
    #[pymodule_export]
    use super::scene::{Scene, schema};
    #[pymodule_export]
    use super::session::Session;
    #[pymodule_export]
    use super::sweep::{Sweep, SweepResults};
    #[pymodule_export]
    use super::sweep_status::SweepStatus;
    #[pymodule_export]
    use super::value::Value;

    /// Variables of the environment by which drivers do better; set before the first session is opened.
    #[pyfunction]
    fn _drivers_environment() -> Vec<(&'static str, &'static str)> {
        tirtouch::trace::drivers::environment()
    }

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        // Without it arrays could not be made: better to know at once.
        module.py().import("numpy")?;
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
