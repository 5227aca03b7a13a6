//! The paper's figures of a frame.

use crate::json::{json, to_dict};
use crate::trouble::Trouble;
use crate::value::Value;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use tirtouch::pipeline::{self, PaperSummary};

/// What the TSIS paper reads from a frame. Intervals hold the mean of the figure over seeds, of light and camera.
#[pyclass(frozen, module = "tirtouch")]
pub struct Reading {
    summary: PaperSummary,
}

impl Reading {
    /// Of a frame less a reference of that name.
    pub fn of(reading: &pipeline::Reading, reference: Option<String>) -> Self {
        let (figures, threshold_grey) = (reading.paper.clone(), reading.threshold_grey);
        Self { summary: PaperSummary { figures, threshold_grey, reference } }
    }
}

#[pymethods]
impl Reading {
    /// Pixels brighter than the threshold.
    #[getter]
    fn lit_pixels(&self) -> usize {
        self.summary.figures.lit_pixels
    }

    /// Diameter of the disc of as many pixels, pixels.
    #[getter]
    fn diameter_px(&self) -> Value {
        (&self.summary.figures.diameter_px).into()
    }

    /// The same in mm on the touched face: of what is lit, not of what presses.
    #[getter]
    fn diameter_mm(&self) -> Value {
        (&self.summary.figures.diameter_mm).into()
    }

    /// Centroid of the grey values: column and row, each from 0 at the upper left corner, pixels.
    #[getter]
    fn centroid_px(&self) -> (Value, Value) {
        let centroid = &self.summary.figures.centroid_px;
        ((&centroid.axis(0)).into(), (&centroid.axis(1)).into())
    }

    /// Depth indicator h, grey levels.
    #[getter]
    fn h_grey(&self) -> Value {
        (&self.summary.figures.h_grey).into()
    }

    /// Sum M of the grey values of all pixels, grey levels.
    #[getter]
    fn sum_grey(&self) -> Value {
        (&self.summary.figures.sum_grey).into()
    }

    /// The threshold, grey levels.
    #[getter]
    fn threshold_grey(&self) -> f64 {
        self.summary.threshold_grey
    }

    /// What a reader must know about these figures.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.summary.figures.warnings.clone()
    }

    /// As ``paper`` of ``tirtouch run --json``.
    fn to_dict<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyDict>, Trouble> {
        Ok(to_dict(py, &json(&self.summary)?)?)
    }

    fn __repr__(&self) -> String {
        format!("<tirtouch.Reading, {} lit pixels>", self.summary.figures.lit_pixels)
    }
}
