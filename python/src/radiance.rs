//! Radiance images from files.

use crate::json::{json, to_dict};
use crate::trouble::Trouble;
use numpy::{PyArray1, PyArray2, PyArrayMethods as _};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::PathBuf;

/// A radiance image from a file.
#[pyclass(frozen, module = "tirtouch")]
pub struct Radiance {
    /// Mean radiance, W/(m^2 sr): float32 of shape (height, width), row 0 at positive y.
    #[pyo3(get)]
    radiance: Py<PyArray2<f32>>,
    /// Variance of that mean, the square of its unit: float32 of the same shape.
    #[pyo3(get)]
    variance: Py<PyArray2<f32>>,
    /// What made it: unit, scene, seed, samples, adapter, version; None where the file does not say.
    #[pyo3(get)]
    provenance: Option<Py<PyDict>>,
}

#[pymethods]
impl Radiance {
    fn __repr__(&self, py: Python<'_>) -> String {
        let [height, width] = self.radiance.bind(py).readonly().as_array().dim().into();
        format!("<tirtouch.Radiance, {width} x {height} pixels>")
    }
}

/// Reads a radiance.exr.
///
/// Raises TirtouchError where it cannot be read or is none.
#[pyfunction]
pub fn read_radiance(py: Python<'_>, path: PathBuf) -> Result<Radiance, Trouble> {
    let (film, provenance) = py.detach(|| tirtouch::image_io::read_radiance(&path))?;
    let shape = [film.height as usize, film.width as usize];
    let array = |values| Ok::<_, PyErr>(PyArray1::from_vec(py, values).reshape(shape)?.unbind());
    let provenance = match provenance {
        Some(provenance) => Some(to_dict(py, &json(&provenance)?)?.unbind()),
        None => None,
    };
    Ok(Radiance { radiance: array(film.mean)?, variance: array(film.variance)?, provenance })
}
