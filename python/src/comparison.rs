//! Comparison of two images.

use crate::json::{json, to_dict};
use crate::trouble::Trouble;
use crate::value::Value;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::{Path, PathBuf};
use tirtouch::estimate;
use tirtouch::failure::Failure;
use tirtouch::film;
use tirtouch::image_io::Pair;

/// Whether two images show the same light; ``bool(comparison)`` is ``passed``.
#[pyclass(frozen, module = "tirtouch")]
pub struct Comparison {
    found: film::Comparison,
}

#[pymethods]
impl Comparison {
    /// Whether they do, as far as their variances can tell.
    #[getter]
    fn passed(&self) -> bool {
        self.found.passed
    }

    /// Mean of the second image over that of the first.
    #[getter]
    fn ratio(&self) -> Value {
        match &self.found.ratio {
            Some(ratio) => (&estimate::Value::known(ratio.value, ratio.low, ratio.high)).into(),
            None => Value::undefined("the first image is dark"),
        }
    }

    /// What ``tirtouch compare --json`` says, less what is about files: ``passed``, ``level``, ``tests``, ``paired``,
    /// ``mean_a``, ``mean_b`` (W/(m^2 sr)), ``ratio``.
    fn to_dict<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyDict>, Trouble> {
        Ok(to_dict(py, &json(&self.found)?)?)
    }

    fn __bool__(&self) -> bool {
        self.found.passed
    }

    fn __repr__(&self) -> String {
        format!("<tirtouch.Comparison {}>", if self.found.passed { "same" } else { "different" })
    }
}

/// Compares two radiance.exr, or folders with one, by their variances. ``level`` is the chance of calling equal images
/// different, all tests together; ``replicates`` stand behind the variances of an image that does not say.
///
/// Raises TirtouchError for files that cannot be read or compared, ValueError for arguments that make no sense.
#[pyfunction]
#[pyo3(signature = (a, b, *, level = 0.001, replicates = 16))]
pub fn compare(py: Python<'_>, a: PathBuf, b: PathBuf, level: f64, replicates: u32) -> Result<Comparison, Trouble> {
    if !(level > 0.0 && level < 1.0) {
        return Err(PyValueError::new_err("level must lie between 0 and 1").into());
    }
    if replicates < 2 {
        return Err(PyValueError::new_err("replicates must be at least 2").into());
    }
    let found = py.detach(|| compared(&a, &b, level, replicates))?;
    Ok(Comparison { found })
}

fn compared(a: &Path, b: &Path, level: f64, replicates: u32) -> Result<film::Comparison, Trouble> {
    let found = Pair::read(a, b, replicates).map_err(Failure::from)?.compare(level);
    found.map_err(|error| {
        let files = format!("{} and {}", a.display(), b.display());
        Failure::input(format!("{files}: {error}")).in_file(b).into()
    })
}
