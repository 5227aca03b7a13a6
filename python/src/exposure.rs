//! Another frame of light that is traced already.

use crate::array::{frame_of, picture};
use crate::json::to_dict;
use crate::scene::Scene;
use crate::trouble::Trouble;
use crate::value::Value;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::PyDict;
use std::path::PathBuf;
use tirtouch::camera::Suited;
use tirtouch::film::Film;
use tirtouch::image_io::Provenance;
use tirtouch::pages::exposure::{Exposure as Exposed, changed};

/// A camera's frame of light that is traced already.
#[pyclass(frozen, module = "tirtouch")]
pub struct Exposure {
    exposed: Exposed,
    frame: PyOnceLock<Py<PyAny>>,
}

/// What of a frame is wanted other than its scene says.
#[derive(Clone, Copy)]
pub struct Wanted {
    pub exposure_ms: Option<f64>,
    pub bit_depth: Option<u32>,
    pub seed: Option<u32>,
}

impl Exposure {
    /// Exposes a film with a scene's camera.
    ///
    /// # Errors
    /// `ValueError` for numbers that no camera has, `SceneError` for a scene of another size.
    pub fn of(
        py: Python<'_>,
        scene: &Scene,
        film: &Film,
        origin: Option<&Provenance>,
        wanted: Wanted,
    ) -> Result<Self, Trouble> {
        let Wanted { exposure_ms, bit_depth, seed } = wanted;
        let loaded = changed((*scene.loaded).clone(), exposure_ms, bit_depth);
        let loaded = loaded.map_err(|broken| PyValueError::new_err(broken.to_string()))?;
        let exposed = py.detach(|| Exposed::of(loaded, film, origin, seed));
        let exposed = exposed.map_err(|error| Trouble::of_scene(error.into(), &scene.file))?;
        Ok(Self { exposed, frame: PyOnceLock::new() })
    }
}

#[pymethods]
impl Exposure {
    /// Grey levels: of shape (height, width), uint8 for a camera of 8 bits, else uint16.
    #[getter]
    fn frame(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        Ok(self.frame.get_or_try_init(py, || frame_of(py, &self.exposed.frame))?.clone_ref(py))
    }

    /// Exposure time, ms.
    #[getter]
    fn exposure_ms(&self) -> f64 {
        self.exposed.loaded.scene.camera.sensor.exposure_ms
    }

    /// Bits of a grey level.
    #[getter]
    fn bit_depth(&self) -> u32 {
        self.exposed.frame.bit_depth
    }

    /// Seed of the sensor's noise.
    #[getter]
    fn seed(&self) -> u32 {
        self.exposed.seed
    }

    /// Pixels at the top grey level.
    #[getter]
    fn saturated_pixels(&self) -> u64 {
        self.exposed.frame.saturated_pixels() as u64
    }

    /// The exposure time that would suit the light, ms; undefined for a dark image.
    #[getter]
    fn suggested_ms(&self) -> Value {
        match &self.exposed.suited {
            Suited::Filled { suggested_ms, .. } => Value::known(*suggested_ms),
            Suited::Undefined(reason) => Value::undefined(reason),
        }
    }

    /// Writes the frame as ``.png``.
    ///
    /// Raises TirtouchError where it cannot be written, ValueError for another ending.
    fn write(&self, py: Python<'_>, path: PathBuf) -> Result<(), Trouble> {
        picture(&path)?;
        Ok(py.detach(|| self.exposed.frame.write_png(&path))?)
    }

    /// What ``tirtouch expose --json`` says, less what is about files: ``scene``, ``seed``, ``exposure_ms``,
    /// ``bit_depth``, ``camera``.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        to_dict(py, &self.exposed.json())
    }

    fn __repr__(&self) -> String {
        format!("<tirtouch.Exposure of {:?}, {} ms>", self.exposed.loaded.scene.name, self.exposure_ms())
    }
}
