//! What is understood of a scene.

use crate::json::{to_dict, to_python};
use crate::scene::Scene;
use crate::trouble::Trouble;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use tirtouch::pages::inspection::Inspection as Seen;

/// What is understood of a scene, and what a render of it would do. ``str`` gives what ``tirtouch inspect`` prints.
#[pyclass(frozen, module = "tirtouch")]
pub struct Inspection {
    said: serde_json::Value,
    text: String,
}

impl Inspection {
    /// # Errors
    /// A camera that does not see the face.
    pub fn of(seen: &Seen, scene: &Scene) -> Result<Self, Trouble> {
        let of_scene = |error: tirtouch::camera::ProjectionError| Trouble::of_scene(error.into(), &scene.file);
        Ok(Self { said: seen.json().map_err(of_scene)?, text: seen.text().map_err(of_scene)? })
    }

    fn words(&self, key: &str) -> Option<&str> {
        self.said.get(key)?.as_str()
    }
}

#[pymethods]
impl Inspection {
    /// The full cone that every layer traps, degrees; None where an indenter presses, which guides no light.
    #[getter]
    fn launch_cone_deg(&self) -> Option<f64> {
        self.said.get("launch_cone_deg")?.as_f64()
    }

    /// What the numbers mean for the light, in sentences.
    #[getter]
    fn regimes(&self) -> Vec<&str> {
        let said = self.said.get("regimes").and_then(serde_json::Value::as_array);
        said.into_iter().flatten().filter_map(serde_json::Value::as_str).collect()
    }

    /// The method that a render takes; None where there is no light.
    #[getter]
    fn integrator(&self) -> Option<&str> {
        self.words("integrator")
    }

    /// Why that method.
    #[getter]
    fn why(&self) -> Option<&str> {
        self.words("why")
    }

    /// What the press will take: ``elements``, ``dofs``, ``method``, ``memory_gib`` (at most, about),
    /// ``memory_limit_gib``, ``seconds`` (all loads, to a factor of 3, on 2 cores); None where nothing is pressed.
    #[getter]
    fn press<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        to_python(py, self.said.get("press").unwrap_or(&serde_json::Value::Null))
    }

    /// What each piece costs where nothing needs it: dictionaries of ``piece``, ``slower`` (run time with it over that
    /// without), ``low``, ``high`` (95 %), ``same_image``; None where that was not asked.
    #[getter]
    fn gains<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        to_python(py, self.said.get("gains").unwrap_or(&serde_json::Value::Null))
    }

    /// What ``tirtouch inspect --json`` says: ``layers`` with their angles, ``kernel``, ``memory``, ``truth`` and more.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        to_dict(py, &self.said)
    }

    fn __str__(&self) -> &str {
        &self.text
    }

    fn __repr__(&self) -> String {
        format!("<tirtouch.Inspection of {:?}>", self.words("scene").unwrap_or_default())
    }
}
