//! The whole way from a scene to estimates.

use crate::arguments::{Asked, threshold_grey};
use crate::calibration::Given;
use crate::estimates::Estimates;
use crate::image::{Image, images};
use crate::json::{json, to_dict};
use crate::press::{Press, truth};
use crate::reading::Reading;
use crate::scene::Scene;
use crate::taken::{Taken, baseline, earlier_loads, prepared};
use crate::trouble::Trouble;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::sync::Arc;
use tirtouch::calibrate::{FrameModel, estimates_of};
use tirtouch::estimate::GreyImage;
use tirtouch::mechanics::press::{PressStep, Pressed};
use tirtouch::pipeline::{EarlierFrame, Order, ReadAs, RunSummary, Session};
use tirtouch::progress::Observer;

/// Name of the frame without inclusions, as the command line writes it.
const BASELINE: &str = "baseline.png";

/// A scene pressed, traced, exposed and read.
#[pyclass(frozen, module = "tirtouch")]
pub struct Run {
    /// The images of all loads, in their order.
    #[pyo3(get)]
    images: Vec<Py<Image>>,
    /// The press; None where nothing is pressed.
    #[pyo3(get)]
    press: Option<Py<Press>>,
    /// The paper's figures of the last image.
    #[pyo3(get)]
    reading: Py<Reading>,
    /// What all frames say of the inclusion.
    #[pyo3(get)]
    estimates: Py<Estimates>,
    summary: serde_json::Value,
}

#[pymethods]
impl Run {
    /// The image of the last load.
    #[getter]
    fn image(&self, py: Python<'_>) -> Option<Py<Image>> {
        self.images.last().map(|image| image.clone_ref(py))
    }

    /// What ``tirtouch run --json`` says, less what is about its folder.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        to_dict(py, &self.summary)
    }

    fn __repr__(&self) -> String {
        format!("<tirtouch.Run, {} images>", self.images.len())
    }
}

/// How a run is wanted.
pub struct Wanted {
    order: Order,
    threshold_grey: f64,
    model: Option<Arc<FrameModel>>,
    subtract_baseline: bool,
}

/// What a run found.
pub struct Found {
    taken: Vec<Taken>,
    baseline: Option<Taken>,
    pressed: Option<Arc<Pressed>>,
    reading: Reading,
    summary: RunSummary,
}

impl Wanted {
    /// # Errors
    /// Arguments that make no sense, a calibration that is none.
    pub fn new(
        asked: Asked,
        scene: &Scene,
        threshold: Option<&Bound<'_, PyAny>>,
        calibration: Option<Given>,
        subtract_baseline: bool,
    ) -> Result<Self, Trouble> {
        let threshold_grey = threshold_grey(threshold, scene.loaded.scene.camera.sensor.bit_depth)?;
        let model = calibration.map(Given::model).transpose()?;
        Ok(Self { order: asked.order(scene)?, threshold_grey, model, subtract_baseline })
    }

    /// # Errors
    /// What the library says.
    pub fn run(&self, session: &mut Session, scene: &Scene, observe: &mut Observer) -> Result<Found, Trouble> {
        let of_scene = |error| Trouble::of_scene(error, &scene.file);
        let grey = |taken: &Taken| GreyImage::from_frame(&taken.frame).map_err(|error| of_scene(error.into()));
        let prepared = prepared(session, scene, &self.order, observe)?;
        let baseline = match self.subtract_baseline {
            true => Some(baseline(session, scene, &prepared, observe)?),
            false => None,
        };
        let mut taken = earlier_loads(session, scene, &prepared, observe)?;
        let earlier = taken.iter().enumerate().filter_map(|(load, taken)| earlier_frame(taken, load)).collect();
        taken.push(Taken::take(session, prepared, scene, observe)?);
        let mut frames = Vec::new();
        for taken in &taken {
            if let Some((_, step)) = taken.prepared.pressed() {
                frames.push((step.depth_mm, grey(taken)?));
            }
        }
        let reference = baseline.as_ref().map(|taken| taken.shot().as_reference()).transpose();
        let reference = reference.map_err(|error| of_scene(error.into()))?;
        let read_as = ReadAs { threshold_grey: self.threshold_grey, reference: reference.as_ref(), calibration: None };
        let shot = taken.last().map(Taken::shot);
        let shot = shot.ok_or_else(|| Trouble::input("there is no image".into()))?;
        let mut reading = shot.read(&read_as).map_err(of_scene)?;
        reading.estimates = estimates_of(self.model.as_deref(), &scene.loaded, &frames);
        let name = self.subtract_baseline.then(|| BASELINE.to_owned());
        let mut summary = shot.run_summary(&reading, name.clone(), truth(scene, self.order.without_inclusions)?);
        summary.earlier_frames = earlier;
        let pressed = shot.prepared.press.as_ref().map(|(pressed, _)| pressed.clone());
        drop(shot);
        Ok(Found { reading: Reading::of(&reading, name), taken, baseline, pressed, summary })
    }
}

/// What is said of the frame of a load before the last.
fn earlier_frame(taken: &Taken, load: usize) -> Option<EarlierFrame> {
    let (pressed, step) = taken.prepared.pressed()?;
    let file = EarlierFrame::file_of(pressed, load, step);
    let &PressStep { depth_mm, slide_mm, hold_s, .. } = step;
    Some(EarlierFrame { depth_mm, slide_mm, hold_s, file, camera: taken.summary.camera.clone() })
}

impl Found {
    /// As Python holds it.
    ///
    /// # Errors
    /// A truth that cannot be told.
    pub fn into_run(self, scene: &Bound<'_, Scene>, without_inclusions: bool) -> Result<Run, Trouble> {
        let py = scene.py();
        let baseline = match self.baseline {
            Some(taken) => images(vec![taken], scene, &json(&truth(scene.get(), true)?)?, None)?.pop(),
            None => None,
        };
        let press = match self.pressed {
            Some(pressed) => Some(Py::new(py, Press::of(pressed, scene.get(), without_inclusions)?)?),
            None => None,
        };
        let images = images(self.taken, scene, &json(&self.summary.truth)?, baseline.as_ref())?;
        let estimates = Py::new(py, Estimates::of(self.summary.estimates.clone(), None))?;
        let reading = Py::new(py, self.reading)?;
        Ok(Run { images, press, reading, estimates, summary: json(&self.summary)? })
    }
}
