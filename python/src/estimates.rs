//! What frames say of an inclusion.

use crate::calibration::Given;
use crate::json::{json, to_dict};
use crate::scene::Scene;
use crate::trouble::Trouble;
use crate::value::Value;
use numpy::PyReadonlyArray2;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde_json::json;
use tirtouch::calibrate::{Frames, Inferred, Presses, check_depths, check_forces, ready};
use tirtouch::camera::top_grey;
use tirtouch::estimate as read;
use tirtouch::estimate::{Detected, GreyImage};
use tirtouch::scene::Camera;

/// What frames say of an inclusion by a calibration, with intervals of 95 %.
#[pyclass(frozen, module = "tirtouch")]
pub struct Estimates {
    estimates: read::Estimates,
    /// All that is inferred, where that was asked.
    inferred: Option<Result<Inferred, String>>,
}

impl Estimates {
    pub fn of(estimates: read::Estimates, inferred: Option<Result<Inferred, String>>) -> Self {
        Self { estimates, inferred }
    }

    fn undefined(why: String) -> Self {
        Self::of(read::Estimates::undefined(&why), Some(Err(why)))
    }
}

#[pymethods]
impl Estimates {
    /// Width of the inclusion, mm.
    #[getter]
    fn size_mm(&self) -> Value {
        (&self.estimates.size_mm).into()
    }

    /// Depth of the inclusion's top below the touched face, mm.
    #[getter]
    fn depth_mm(&self) -> Value {
        (&self.estimates.depth_mm).into()
    }

    /// Young's modulus of the inclusion, kPa.
    #[getter]
    fn youngs_kpa(&self) -> Value {
        (&self.estimates.youngs_kpa).into()
    }

    /// Whether there is an inclusion; None where that cannot be said.
    #[getter]
    fn detected(&self) -> Option<bool> {
        match self.estimates.detected {
            Detected::Known(detected) => Some(detected),
            Detected::Undefined { .. } => None,
        }
    }

    /// Why it cannot be said; None where it can.
    #[getter]
    fn reason(&self) -> Option<&str> {
        match &self.estimates.detected {
            Detected::Known(_) => None,
            Detected::Undefined { undefined } => Some(undefined),
        }
    }

    /// Every unknown of the calibration by its name, in the unit of its key; empty where nothing is inferred, and of
    /// ``Session.run``.
    #[getter]
    fn unknowns<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let unknowns = PyDict::new(py);
        if let Some(Ok(inferred)) = &self.inferred {
            for one in &inferred.unknowns {
                unknowns.set_item(&one.name, Value::from(&one.value))?;
            }
        }
        Ok(unknowns)
    }

    /// ``estimates`` and ``inferred`` of ``tirtouch estimate --json``; of ``Session.run`` the first alone.
    fn to_dict<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyDict>, Trouble> {
        let mut said = json!({"estimates": json(&self.estimates)?});
        match &self.inferred {
            Some(Ok(inferred)) => said["inferred"] = json(inferred)?,
            Some(Err(why)) => said["inferred"] = json!({"undefined": why}),
            None => {}
        }
        Ok(to_dict(py, &said)?)
    }

    fn __repr__(&self) -> String {
        let said = |value: &read::Value| Value::from(value).said();
        let [size, depth, youngs] =
            [&self.estimates.size_mm, &self.estimates.depth_mm, &self.estimates.youngs_kpa].map(said);
        format!("<tirtouch.Estimates size_mm {size}, depth_mm {depth}, youngs_kpa {youngs}>")
    }
}

/// What frames of one press say of the inclusion: its size, depth and modulus, and all other unknowns.
///
/// ``frames``: raw frames, one a load, as arrays of grey levels of shape (height, width), uint8 or uint16.
/// ``depths_mm``: depth of the press of each. ``calibration``: a Calibration, or the file of one; if not given, that of
/// the paper's sensor and phantoms, ``Calibration.ready()``. ``scene``: the scene whose camera took the
/// frames; if not given, the calibration's own camera, read with so many pixels.
///
/// ``forces_n``: force of each press, where it was measured, to a relative error (a standard deviation) of
/// ``force_error``.
///
/// What does not suit comes back as undefined, with the reason. Raises TypeError and ValueError for arguments that make
/// no sense, TirtouchError for a calibration that is none.
#[pyfunction]
#[pyo3(signature = (frames, depths_mm, *, forces_n = None, force_error = 0.01, calibration = None, scene = None))]
pub fn estimate(
    py: Python<'_>,
    frames: Vec<Bound<'_, PyAny>>,
    depths_mm: Vec<f64>,
    forces_n: Option<Vec<f64>>,
    force_error: f64,
    calibration: Option<Given>,
    scene: Option<&Bound<'_, Scene>>,
) -> Result<Estimates, Trouble> {
    let told = check_depths(&depths_mm, frames.len());
    told.map_err(|why| PyValueError::new_err(format!("depths_mm {why}")))?;
    check_measured(forces_n.as_deref(), force_error, frames.len())?;
    let frames = frames.iter().enumerate().map(|(k, frame)| Levels::of(frame, k)).collect::<PyResult<Vec<_>>>()?;
    let given = calibration.map(Given::model).transpose()?;
    let Some(model) = given.as_deref().or(ready()) else {
        return Ok(Estimates::undefined("no calibrated model".into()));
    };
    let size = frames.first().map(Levels::size).unwrap_or_default();
    let camera = match model.camera_of(scene.map(|scene| &*scene.get().loaded), size) {
        Ok(camera) => camera,
        Err(why) => return Ok(Estimates::undefined(why)),
    };
    let images = frames.iter().enumerate().map(|(k, frame)| frame.image(k, &camera.0));
    let images = images.collect::<PyResult<Vec<_>>>()?;
    let images: Vec<&GreyImage> = images.iter().collect();
    let forces_n = forces_n.as_deref().unwrap_or_default();
    let presses = Presses { depths_mm: &depths_mm, forces_n, force_error };
    let found = py.detach(|| model.inverted(&Frames::of(&camera, &images, presses)));
    Ok(Estimates::of(found.0, Some(found.1)))
}

fn check_measured(forces_n: Option<&[f64]>, force_error: f64, frames: usize) -> PyResult<()> {
    let positive = |number: f64| number.is_finite() && number > 0.0;
    if !positive(force_error) {
        return Err(PyValueError::new_err(format!("force_error must be a finite number above 0, is {force_error}")));
    }
    let Some(forces_n) = forces_n else { return Ok(()) };
    check_forces(forces_n, frames).map_err(|why| PyValueError::new_err(format!("forces_n {why}")))?;
    match forces_n.iter().find(|force_n| !positive(**force_n)) {
        Some(wrong) => Err(PyValueError::new_err(format!("forces_n must be finite numbers above 0, one is {wrong}"))),
        None => Ok(()),
    }
}

/// Grey levels of a frame, with its rows and columns.
struct Levels {
    shape: (usize, usize),
    grey: Vec<f64>,
}

/// The arrays that a frame may be.
#[derive(FromPyObject)]
enum FrameArray<'py> {
    Of8Bits(PyReadonlyArray2<'py, u8>),
    Of16Bits(PyReadonlyArray2<'py, u16>),
}

impl Levels {
    fn of(frame: &Bound<'_, PyAny>, number: usize) -> PyResult<Self> {
        match frame.extract() {
            Ok(FrameArray::Of8Bits(levels)) => {
                let levels = levels.as_array();
                Ok(Self { shape: levels.dim(), grey: levels.iter().map(|&level| f64::from(level)).collect() })
            }
            Ok(FrameArray::Of16Bits(levels)) => {
                let levels = levels.as_array();
                Ok(Self { shape: levels.dim(), grey: levels.iter().map(|&level| f64::from(level)).collect() })
            }
            Err(_) => {
                let message = format!("frames[{number}] must be an array of uint8 or uint16 of shape (height, width)");
                Err(PyTypeError::new_err(message))
            }
        }
    }

    /// Columns and rows.
    fn size(&self) -> [u32; 2] {
        [self.shape.1, self.shape.0].map(|count| u32::try_from(count).unwrap_or(u32::MAX))
    }

    /// As a frame of that camera.
    fn image(&self, number: usize, camera: &Camera) -> PyResult<GreyImage> {
        let top = f64::from(top_grey(camera.sensor.bit_depth));
        if let Some(above) = self.grey.iter().find(|level| **level > top) {
            let message = format!("frames[{number}] has the level {above}, the camera's end at {top}");
            return Err(PyValueError::new_err(message));
        }
        let image = GreyImage::new(self.shape.1, self.shape.0, &self.grey, Some(top));
        image.map_err(|error| PyValueError::new_err(format!("frames[{number}]: {error}")))
    }
}
