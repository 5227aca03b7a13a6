//! How far sweeps are.

use crate::json::{json, to_dict};
use crate::trouble::Trouble;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use tirtouch::sweep::Status;

/// How far a sweep is.
#[pyclass(frozen, module = "tirtouch")]
pub struct SweepStatus {
    pub status: Status,
    pub name: String,
}

#[pymethods]
impl SweepStatus {
    /// Points of the design.
    #[getter]
    fn points(&self) -> usize {
        self.status.points
    }

    /// Points with figures.
    #[getter]
    fn done(&self) -> usize {
        self.status.done
    }

    /// Points that break a constraint or a rule of scenes.
    #[getter]
    fn rejected(&self) -> usize {
        self.status.rejected
    }

    /// Points that could not be computed.
    #[getter]
    fn failed(&self) -> usize {
        self.status.failed
    }

    /// Records that cannot be read; they are computed again.
    #[getter]
    fn damaged(&self) -> usize {
        self.status.damaged
    }

    /// Workers in the folder.
    #[getter]
    fn workers(&self) -> usize {
        self.status.workers
    }

    /// What ``tirtouch sweep status --json`` says, less what is about files.
    pub fn to_dict<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyDict>, Trouble> {
        let mut said = json(&self.status)?;
        said["name"] = serde_json::json!(self.name);
        Ok(to_dict(py, &said)?)
    }

    fn __repr__(&self) -> String {
        let Status { points, done, rejected, failed, .. } = self.status;
        format!("<tirtouch.SweepStatus, {done} of {points} done, {rejected} rejected, {failed} failed>")
    }
}
