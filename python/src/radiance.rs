//! Radiance images from files.

use crate::array::array_of;
use crate::exposure::{Exposure, Wanted};
use crate::json::{json, to_dict};
use crate::scene::Scene;
use crate::trouble::Trouble;
use numpy::PyArray2;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::PathBuf;
use tirtouch::film::Film;
use tirtouch::image_io::Provenance;

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
    film: Film,
    origin: Option<Provenance>,
}

#[pymethods]
impl Radiance {
    /// A frame of it by a scene's camera: with the exposure time, the bits of a grey level (8 to 16) and the seed of
    /// the sensor's noise that are given, else with those of the scene and of the frame that was made when it was
    /// traced.
    ///
    /// Raises SceneError for a camera of another size, ValueError for numbers that no camera has.
    #[pyo3(signature = (scene, *, exposure_ms = None, bit_depth = None, seed = None))]
    fn expose(
        &self,
        scene: &Bound<'_, Scene>,
        exposure_ms: Option<f64>,
        bit_depth: Option<u32>,
        seed: Option<u32>,
    ) -> Result<Exposure, Trouble> {
        let wanted = Wanted { exposure_ms, bit_depth, seed };
        Exposure::of(scene.py(), scene.get(), &self.film, self.origin.as_ref(), wanted)
    }

    fn __repr__(&self) -> String {
        format!("<tirtouch.Radiance, {} x {} pixels>", self.film.width, self.film.height)
    }
}

/// Reads a radiance.exr.
///
/// Raises TirtouchError where it cannot be read or is none.
#[pyfunction]
pub fn read_radiance(py: Python<'_>, path: PathBuf) -> Result<Radiance, Trouble> {
    let (film, origin) = py.detach(|| tirtouch::image_io::read_radiance(&path))?;
    let array = |values: &Vec<f32>| Ok::<_, PyErr>(array_of(py, values.clone(), [film.width, film.height])?.unbind());
    let provenance = match &origin {
        Some(origin) => Some(to_dict(py, &json(origin)?)?.unbind()),
        None => None,
    };
    Ok(Radiance { radiance: array(&film.mean)?, variance: array(&film.variance)?, provenance, film, origin })
}
