//! Presses.

use crate::json::{json, to_dict};
use crate::scene::Scene;
use crate::trouble::Trouble;
use crate::value::Value;
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::sync::Arc;
use tirtouch::mechanics::kinematics::Kinematics;
use tirtouch::mechanics::path::PathError;
use tirtouch::mechanics::press::{ContactPoint, PressError, PressStep, Pressed};
use tirtouch::pipeline::{PipelineError, PressSummary, StepSummary, Truth};
use tirtouch::scene::LoadedScene;

/// A phantom pressed against its sensor, at each load.
#[pyclass(frozen, module = "tirtouch")]
pub struct Press {
    pressed: Arc<Pressed>,
    loaded: Arc<LoadedScene>,
    truth: serde_json::Value,
}

impl Press {
    /// # Errors
    /// A phantom whose truth cannot be told.
    pub fn of(pressed: Arc<Pressed>, scene: &Scene, without_inclusions: bool) -> Result<Self, Trouble> {
        let loaded = scene.loaded.clone();
        let truth = truth_of(scene, without_inclusions)?;
        Ok(Self { pressed, loaded, truth })
    }
}

/// Of a scene that was to be pressed: with the loads that a press reached which stopped early.
pub fn stopped(error: PipelineError, scene: &Scene, without_inclusions: bool) -> Trouble {
    let reached = match &error {
        PipelineError::Press(PressError::Stopped { cause: PathError::Stopped, .. }) => None,
        PipelineError::Press(PressError::Stopped { reached, .. }) => Some(Arc::new((**reached).clone())),
        _ => None,
    };
    let object = |pressed| {
        let press = Press::of(pressed, scene, without_inclusions)?;
        Python::attach(|py| Ok::<_, Trouble>(Py::new(py, press)?.into_any()))
    };
    match (Trouble::of_scene(error, &scene.file), reached.map(object)) {
        (Trouble::Said(failure, _), Some(Ok(press))) => Trouble::Press(failure, press),
        (trouble, _) => trouble,
    }
}

/// What the scene's phantom holds.
///
/// # Errors
/// A file of the scene that cannot be read, a material that makes no sense.
pub fn truth_of(scene: &Scene, without_inclusions: bool) -> Result<serde_json::Value, Trouble> {
    json(&truth(scene, without_inclusions)?)
}

/// The same as the library's type.
///
/// # Errors
/// As [`truth_of`].
pub fn truth(scene: &Scene, without_inclusions: bool) -> Result<Truth, Trouble> {
    let truth = Truth::of(scene.loaded.scene.phantom.as_ref(), &scene.loaded.files, without_inclusions);
    truth.map_err(|error| Trouble::of_scene(error.into(), &scene.file))
}

#[pymethods]
impl Press {
    /// The loads that were reached, in their order.
    #[getter]
    fn loads(&self) -> Vec<Load> {
        let summary = PressSummary::of(&self.pressed);
        let load = |(number, step)| Load { pressed: self.pressed.clone(), number, step };
        summary.steps.into_iter().enumerate().map(load).collect()
    }

    /// What ``tirtouch press --json`` says, less what is about files: ``scene``, ``inputs``, ``truth``, ``mechanics``.
    fn to_dict<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyDict>, Trouble> {
        let said = serde_json::json!({
            "scene": self.loaded.scene.name,
            "inputs": json(&self.loaded.inputs())?,
            "truth": self.truth,
            "mechanics": json(&PressSummary::of(&self.pressed))?,
        });
        Ok(to_dict(py, &said)?)
    }

    /// The contact of all loads as a pandas.DataFrame: ``load`` (from 0), ``depth_mm``, ``slide_x_mm``, ``slide_y_mm``,
    /// ``hold_s``, and the columns of ``Load.contact``. Raises ImportError without pandas.
    fn to_pandas<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("tirtouch._tables")?.call_method1("press_to_pandas", (slf,))
    }

    fn __repr__(&self) -> String {
        let (name, loads) = (&self.loaded.scene.name, self.pressed.steps.len());
        format!("<tirtouch.Press of {name:?}, {loads} loads>")
    }
}

/// A press at one load. Errors are relative.
#[pyclass(frozen, module = "tirtouch")]
pub struct Load {
    pressed: Arc<Pressed>,
    number: usize,
    step: StepSummary,
}

#[pymethods]
impl Load {
    /// Motion of the phantom's base along z, mm.
    #[getter]
    fn depth_mm(&self) -> f64 {
        self.step.depth_mm
    }

    /// Its motion along x and y, mm.
    #[getter]
    fn slide_mm(&self) -> (f64, f64) {
        self.step.slide_mm.into()
    }

    /// How long it was held, s.
    #[getter]
    fn hold_s(&self) -> f64 {
        self.step.hold_s
    }

    /// Force along z, N.
    #[getter]
    fn force_n(&self) -> f64 {
        self.step.force_n
    }

    /// Largest pressure within 0.8 of the footprint's radius, kPa; under an indenter over all of the face.
    #[getter]
    fn peak_pressure_kpa(&self) -> f64 {
        self.step.peak_pressure_kpa
    }

    /// Its place on the undeformed face, x and y (r and 0 where axisymmetric), mm; None where nothing is borne.
    #[getter]
    fn peak_at_mm(&self) -> Option<(f64, f64)> {
        self.step.peak_at_mm.map(Into::into)
    }

    /// Error of the force by the mesh, as a share of it.
    #[getter]
    fn force_error(&self) -> Value {
        (&self.step.force_error).into()
    }

    /// Error of the pressure by the mesh, root mean square, as a share of it.
    #[getter]
    fn pressure_error(&self) -> Value {
        (&self.step.pressure_error).into()
    }

    /// Error of the peak pressure by the mesh, as a share of it.
    #[getter]
    fn peak_error(&self) -> Value {
        (&self.step.peak_error).into()
    }

    /// The nodes of the touched face as arrays of float64, all of one length, by the names of contact.csv: ``r_mm``
    /// (undeformed place; ``x_mm`` and ``y_mm`` in three dimensions), ``pressure_kpa``, ``shear_kpa``, ``gap_mm``,
    /// ``displacement_r_mm`` (``_x_mm``, ``_y_mm``), ``displacement_z_mm``.
    #[getter]
    fn contact<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let columns = PyDict::new(py);
        if let Some(step) = self.pressed.steps.get(self.number) {
            for (name, values) in contact_columns(&self.pressed, step) {
                columns.set_item(name, PyArray1::from_vec(py, values))?;
            }
        }
        Ok(columns)
    }

    /// The load as a dictionary, as in ``mechanics.steps`` of ``tirtouch press --json``.
    fn to_dict<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyDict>, Trouble> {
        Ok(to_dict(py, &json(&self.step)?)?)
    }

    fn __repr__(&self) -> String {
        format!("<tirtouch.Load {} mm, {} N>", self.step.depth_mm, self.step.force_n)
    }
}

/// Columns of contact.csv after those of the load.
fn contact_columns(pressed: &Pressed, step: &PressStep) -> Vec<(&'static str, Vec<f64>)> {
    type Column = (&'static str, fn(&ContactPoint) -> f64);
    let solid: [&[Column]; 2] = [
        &[("x_mm", |point| point.reference_mm[0]), ("y_mm", |point| point.reference_mm[1])],
        &[
            ("displacement_x_mm", |point| point.displacement_mm[0]),
            ("displacement_y_mm", |point| point.displacement_mm[1]),
            ("displacement_z_mm", |point| point.displacement_mm[2]),
        ],
    ];
    let flat: [&[Column]; 2] = [
        &[("r_mm", |point| point.reference_mm[0])],
        &[
            ("displacement_r_mm", |point| point.displacement_mm[0]),
            ("displacement_z_mm", |point| point.displacement_mm[1]),
        ],
    ];
    let [place, moved] = if pressed.setup.kinematics == Kinematics::ThreeDimensional { solid } else { flat };
    let borne: &[Column] = &[
        ("pressure_kpa", |point| point.pressure_kpa),
        ("shear_kpa", |point| point.shear_kpa),
        ("gap_mm", |point| point.gap_mm),
    ];
    let columns = place.iter().chain(borne).chain(moved);
    columns.map(|(name, pick)| (*name, step.points.iter().map(pick).collect())).collect()
}
