//! The command `tirtouch`, as the package brings it.

use pyo3::prelude::*;
use std::ffi::OsString;
use std::path::PathBuf;

/// Runs the command line; ``arguments`` begin with its name, and ``program`` starts it again. Gives the exit code.
#[pyfunction]
pub fn _command_line(py: Python<'_>, arguments: Vec<OsString>, program: PathBuf) -> u8 {
    py.detach(|| tirtouch::cli::run_as(arguments, program))
}
