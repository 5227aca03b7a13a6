//! Calibrations: what a sensor's frames say of an inclusion.

use crate::json::{json, to_dict};
use crate::scene::Scene;
use crate::trouble::Trouble;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::PathBuf;
use std::sync::Arc;
use tirtouch::calibrate::{FrameModel, ready};

/// What a sensor's frames say of an inclusion, learnt from simulated frames of many phantoms.
#[pyclass(frozen, module = "tirtouch")]
pub struct Calibration {
    pub model: Arc<FrameModel>,
}

/// An unknown of a calibration, and where it was learnt.
#[pyclass(frozen, module = "tirtouch", get_all)]
#[derive(Clone)]
pub struct Unknown {
    /// Its name.
    name: String,
    /// The keys of the scene that take its value; in their unit are ``low`` and ``high``.
    keys: Vec<String>,
    /// The least value that it was learnt for.
    low: f64,
    /// The greatest.
    high: f64,
}

impl Unknown {
    fn said(&self) -> serde_json::Value {
        let Self { name, keys, low, high } = self;
        serde_json::json!({"name": name, "keys": keys, "low": low, "high": high})
    }
}

#[pymethods]
impl Unknown {
    /// The same as a dictionary.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        to_dict(py, &self.said())
    }

    fn __repr__(&self) -> String {
        format!("<tirtouch.Unknown {:?}, {} to {}>", self.name, self.low, self.high)
    }
}

impl From<FrameModel> for Calibration {
    fn from(model: FrameModel) -> Self {
        Self { model: Arc::new(model) }
    }
}

#[pymethods]
impl Calibration {
    /// Reads a file that ``calibrate`` or ``tirtouch calibrate`` learnt.
    ///
    /// Raises TirtouchError for a file that is none.
    #[staticmethod]
    fn open(py: Python<'_>, path: PathBuf) -> Result<Self, Trouble> {
        Ok(py.detach(|| FrameModel::load(&path))?.into())
    }

    /// The calibration of the paper's sensor and phantoms, which comes with the program.
    ///
    /// Raises TirtouchError where it is damaged.
    #[staticmethod]
    fn ready() -> Result<Self, Trouble> {
        let model = ready().ok_or_else(|| Trouble::input("the calibration that comes with it is damaged".into()))?;
        Ok(model.clone().into())
    }

    /// Writes it as a file, whole or not at all.
    ///
    /// Raises TirtouchError where it cannot be written.
    fn write(&self, py: Python<'_>, path: PathBuf) -> Result<(), Trouble> {
        Ok(py.detach(|| self.model.write(&path))?)
    }

    /// Version of the program that learnt it.
    #[getter]
    fn version(&self) -> &str {
        &self.model.version
    }

    /// Depths of the loads whose frames it reads, mm.
    #[getter]
    fn depths_mm(&self) -> Vec<f64> {
        self.model.depths_mm.clone()
    }

    /// What it infers or integrates away, each with the range in which it was learnt.
    #[getter]
    fn unknowns(&self) -> Vec<Unknown> {
        let of = |(one, keys): (&tirtouch::infer::Unknown, &[String])| {
            let [low, high] = one.prior.bounds().map(|end| one.prior.value(end));
            Unknown { name: one.name.clone(), keys: keys.to_vec(), low, high }
        };
        self.model.unknowns().map(of).collect()
    }

    /// Numbers by which it tells frames apart.
    #[getter]
    fn scores(&self) -> usize {
        self.model.scores()
    }

    /// Whether it can use measured forces.
    #[getter]
    fn knows_forces(&self) -> bool {
        self.model.knows_forces()
    }

    /// Whether it can tell that there is no inclusion.
    #[getter]
    fn knows_empty(&self) -> bool {
        self.model.knows_empty()
    }

    /// The scene of the sensor that it is of.
    #[getter]
    fn scene(&self) -> Result<Scene, Trouble> {
        Ok(Scene::of(self.model.own_scene()?, "calibration.toml".into()))
    }

    /// Why it does not suit a scene; None where it does.
    fn unsuited(&self, scene: &Bound<'_, Scene>) -> Option<String> {
        self.model.suits(&scene.get().loaded).err()
    }

    /// What it is valid for: ``version``, ``depths_mm``, ``unknowns``, ``scores``, ``knows_forces``, ``knows_empty``.
    fn to_dict<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyDict>, Trouble> {
        let unknowns: Vec<_> = self.unknowns().iter().map(Unknown::said).collect();
        let said = serde_json::json!({
            "version": self.model.version,
            "depths_mm": json(&self.model.depths_mm)?,
            "unknowns": unknowns,
            "scores": self.model.scores(),
            "knows_forces": self.model.knows_forces(),
            "knows_empty": self.model.knows_empty(),
        });
        Ok(to_dict(py, &said)?)
    }

    fn __repr__(&self) -> String {
        let names: Vec<_> = self.model.unknowns().map(|(one, _)| one.name.as_str()).collect();
        format!("<tirtouch.Calibration of {}>", names.join(", "))
    }
}

/// A calibration, or the file of one.
#[derive(FromPyObject)]
pub enum Given {
    Known(Py<Calibration>),
    File(PathBuf),
}

impl Given {
    /// # Errors
    /// A file that is no calibration.
    pub fn model(self) -> Result<Arc<FrameModel>, Trouble> {
        match self {
            Self::Known(calibration) => Ok(calibration.get().model.clone()),
            Self::File(file) => Ok(Arc::new(FrameModel::load(&file)?)),
        }
    }
}
