//! What the folder of a sweep holds.

use crate::COMMAND;
use crate::json::{json, to_dict};
use crate::sweep::{Sweep, file_in};
use crate::trouble::Trouble;
use numpy::PyArray1;
use pyo3::exceptions::PyIndexError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use tirtouch::failure::Failure;
use tirtouch::output::Records;
use tirtouch::pages::sweep::{Points, points, write};
use tirtouch::sweep::{self, NoScene, Status};
use tirtouch::vary::Scalar;

/// The folder of a sweep: what its records say, from whatever is there.
#[pyclass(frozen, module = "tirtouch")]
pub struct SweepResults {
    sweep: Arc<sweep::Sweep>,
    folder: PathBuf,
    /// What the run said that made it.
    told: Option<serde_json::Value>,
}

/// How far a sweep is.
#[pyclass(frozen, module = "tirtouch")]
pub struct SweepStatus {
    status: Status,
    name: String,
}

impl SweepResults {
    pub fn of(sweep: Arc<sweep::Sweep>, folder: PathBuf, told: Option<serde_json::Value>) -> Self {
        Self { sweep, folder, told }
    }

    /// The records, if they are of this sweep.
    fn records(&self) -> Result<Records, Trouble> {
        let (records, order) = Records::read(&self.folder)?;
        match order == self.sweep.order() {
            true => Ok(records),
            false => {
                let message = format!("{}: holds the records of another sweep", self.folder.display());
                Err(Failure::input(message).in_file(&self.folder).into())
            }
        }
    }

    pub fn known_status(&self) -> Result<SweepStatus, Trouble> {
        let status = Status::of(&self.sweep, &self.records()?);
        Ok(SweepStatus { status, name: self.sweep.name.clone() })
    }
}

#[pymethods]
impl SweepResults {
    /// The results of a folder that ``Sweep.run`` or ``tirtouch sweep run`` made.
    ///
    /// Raises TirtouchError for a folder of something else.
    #[staticmethod]
    fn open(folder: PathBuf) -> Result<Self, Trouble> {
        let (sweep, _) = sweep::Sweep::of_folder(&folder)?;
        Ok(Self::of(Arc::new(sweep), folder, None))
    }

    /// The folder.
    #[getter]
    fn folder(&self) -> &Path {
        &self.folder
    }

    /// The sweep.
    #[getter]
    fn sweep(&self) -> Sweep {
        Sweep::of((*self.sweep).clone(), file_in(&self.folder))
    }

    /// Time that the run took, s; None where it was not this one.
    #[getter]
    fn seconds(&self) -> Option<f64> {
        self.told.as_ref()?.get("seconds")?.as_f64()
    }

    /// How far the sweep is.
    ///
    /// Raises TirtouchError for a folder without its records.
    fn status(&self) -> Result<SweepStatus, Trouble> {
        self.known_status()
    }

    /// All points in the order of the design, as columns of one length by the names of points.csv: ``row`` (int64, from
    /// 0), ``status`` (``"done"``, ``"rejected"``, ``"failed"``, ``"missing"``), what varies by its names, each figure
    /// with its ``_low`` and ``_high`` (95 %), ``relative_error``, ``note``. Numbers are float64, NaN where there is
    /// none; columns of texts are lists, with None.
    ///
    /// Raises TirtouchError for a folder without records of the sweep.
    fn points<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyDict>, Trouble> {
        let records = self.records()?;
        let Points { head, rows } = py.detach(|| points(&self.sweep, &records));
        let columns = PyDict::new(py);
        for (k, name) in head.into_iter().enumerate() {
            let cells: Vec<Option<&Scalar>> = rows.iter().map(|row| row.get(k).and_then(Option::as_ref)).collect();
            let is_text = |cell: &Option<&Scalar>| matches!(cell, Some(Scalar::Text(_) | Scalar::Flag(_)));
            if k == 0 {
                columns.set_item(name, PyArray1::from_iter(py, 0..rows.len() as i64))?;
            } else if ["status", "note"].contains(&name.as_str()) || cells.iter().any(is_text) {
                let cells = cells.into_iter().map(|cell| python(py, cell)).collect::<PyResult<Vec<_>>>()?;
                columns.set_item(name, cells)?;
            } else {
                let numbers = cells.into_iter().map(|cell| cell.and_then(Scalar::number).unwrap_or(f64::NAN));
                columns.set_item(name, PyArray1::from_iter(py, numbers))?;
            }
        }
        Ok(columns)
    }

    /// ``points`` as a pandas.DataFrame. Raises ImportError without pandas.
    fn to_pandas<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("tirtouch._tables")?.call_method1("points_to_pandas", (slf,))
    }

    /// The scene of a point; ``row`` counts from 0.
    ///
    /// Raises IndexError for a row that there is not, SceneError for a point that makes no scene.
    fn scene(&self, py: Python<'_>, row: usize) -> PyResult<Py<PyAny>> {
        Ok(Bound::new(py, self.sweep())?.call_method1("scene", (row,))?.unbind())
    }

    /// Writes the tables and the report of whatever records the folder has.
    ///
    /// Raises TirtouchError for a folder without records of the sweep, or that cannot be written.
    fn collect(&self, py: Python<'_>) -> Result<SweepStatus, Trouble> {
        let records = self.records()?;
        let status = py.detach(|| write(&self.sweep, &records, COMMAND))?;
        Ok(SweepStatus { status, name: self.sweep.name.clone() })
    }

    /// What ``tirtouch sweep run --json`` says, less what is about files; what ``tirtouch sweep status --json`` says
    /// where the run was not this one.
    fn to_dict<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyDict>, Trouble> {
        match &self.told {
            Some(told) => Ok(to_dict(py, told)?),
            None => self.known_status()?.to_dict(py),
        }
    }

    fn __repr__(&self) -> String {
        format!("<tirtouch.SweepResults of {:?} in {}>", self.sweep.name, self.folder.display())
    }
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
    fn to_dict<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyDict>, Trouble> {
        let mut said = json(&self.status)?;
        said["name"] = serde_json::json!(self.name);
        Ok(to_dict(py, &said)?)
    }

    fn __repr__(&self) -> String {
        let Status { points, done, rejected, failed, .. } = self.status;
        format!("<tirtouch.SweepStatus, {done} of {points} done, {rejected} rejected, {failed} failed>")
    }
}

/// Why there is no scene of a point.
pub fn no_scene(error: &NoScene, file: &Path) -> Trouble {
    let words = format!("{}: {error}", file.display());
    match error {
        NoScene::Row { .. } => PyIndexError::new_err(words).into(),
        NoScene::Rejected { .. } => Trouble::scene(Failure::input(words).in_file(file)),
    }
}

fn python<'py>(py: Python<'py>, cell: Option<&Scalar>) -> PyResult<Bound<'py, PyAny>> {
    Ok(match cell {
        None => py.None().into_bound(py),
        Some(Scalar::Text(text)) => text.into_pyobject(py)?.into_any(),
        Some(Scalar::Flag(flag)) => flag.into_pyobject(py)?.to_owned().into_any(),
        Some(Scalar::Number(number)) => number.into_pyobject(py)?.into_any(),
    })
}
