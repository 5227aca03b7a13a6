//! Images.

use crate::COMMAND;
use crate::arguments::threshold_grey;
use crate::array::{frame_of, image_of};
use crate::exposure::{Exposure, Wanted};
use crate::json::{json, to_dict};
use crate::reading::Reading;
use crate::scene::Scene;
use crate::taken::Taken;
use crate::trouble::Trouble;
use crate::value::Value;
use numpy::PyArray2;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::PyDict;
use std::path::PathBuf;
use tirtouch::camera::Frame;
use tirtouch::figure::Figure;
use tirtouch::pipeline::ReadAs;

/// An image: radiance with its variance, the camera's frame of it, and where the light went.
///
/// Row 0 is at positive y, column 0 at negative x. Arrays cannot be written to; ``.copy()`` gives one that can.
#[pyclass(frozen, module = "tirtouch")]
pub struct Image {
    taken: Taken,
    scene: Py<Scene>,
    truth: serde_json::Value,
    baseline: Option<Py<Image>>,
    radiance: PyOnceLock<Py<PyArray2<f32>>>,
    variance: PyOnceLock<Py<PyArray2<f32>>>,
    frame: PyOnceLock<Py<PyAny>>,
}

impl Image {
    pub fn new(taken: Taken, scene: Py<Scene>, truth: serde_json::Value, baseline: Option<Py<Image>>) -> Self {
        let (radiance, variance, frame) = (PyOnceLock::new(), PyOnceLock::new(), PyOnceLock::new());
        Self { taken, scene, truth, baseline, radiance, variance, frame }
    }

    fn size(&self) -> [u32; 2] {
        [self.taken.frame.width, self.taken.frame.height]
    }
}

#[pymethods]
impl Image {
    /// Mean radiance, W/(m^2 sr): float32 of shape (height, width).
    #[getter]
    fn radiance(&self, py: Python<'_>) -> PyResult<Py<PyArray2<f32>>> {
        let make = || Ok::<_, PyErr>(image_of(py, self.taken.outcome.film.mean.clone(), self.size())?.unbind());
        Ok(self.radiance.get_or_try_init(py, make)?.clone_ref(py))
    }

    /// Variance of that mean, the square of its unit: float32 of shape (height, width). It is 0 where no path found
    /// light; what may have been missed there is in ``absolute_error`` of ``to_dict``, and stands in radiance.exr.
    #[getter]
    fn variance(&self, py: Python<'_>) -> PyResult<Py<PyArray2<f32>>> {
        let make = || Ok::<_, PyErr>(image_of(py, self.taken.outcome.film.variance.clone(), self.size())?.unbind());
        Ok(self.variance.get_or_try_init(py, make)?.clone_ref(py))
    }

    /// The camera's frame, grey levels: of shape (height, width), uint8 for a camera of 8 bits, else uint16.
    #[getter]
    fn frame(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        Ok(self.frame.get_or_try_init(py, || frame_of(py, &self.taken.frame))?.clone_ref(py))
    }

    /// The scene.
    #[getter]
    fn scene(&self, py: Python<'_>) -> Py<Scene> {
        self.scene.clone_ref(py)
    }

    /// The same load without inclusions, where ``baseline=True`` asked for it.
    #[getter]
    fn baseline(&self, py: Python<'_>) -> Option<Py<Image>> {
        self.baseline.as_ref().map(|baseline| baseline.clone_ref(py))
    }

    /// Where the light went, as shares of what the LEDs emit: ``emitted``, ``absorbed``, ``escaped_top``,
    /// ``escaped_bottom``, ``escaped_sides``, ``detected``, ``terminated``, ``roulette``, ``residual``.
    #[getter]
    fn ledger<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyDict>, Trouble> {
        Ok(to_dict(py, &json(&self.taken.summary.ledger)?)?)
    }

    /// Root-mean-square standard error over the lit pixels over their mean; undefined for a dark image.
    #[getter]
    fn relative_error(&self) -> Value {
        (&self.taken.summary.relative_error).into()
    }

    /// Time of tracing, without loading and compiling, s.
    #[getter]
    fn seconds(&self) -> f64 {
        self.taken.summary.seconds
    }

    /// What traced it.
    #[getter]
    fn adapter(&self) -> &str {
        &self.taken.summary.adapter
    }

    /// The seed that was asked for.
    #[getter]
    fn seed(&self) -> u32 {
        self.taken.summary.seed
    }

    /// Scale of the frame at the touched face, mm per pixel.
    #[getter]
    fn mm_per_pixel(&self) -> f64 {
        self.taken.mm_per_pixel
    }

    /// Depth of the press, mm; undefined where nothing is pressed.
    #[getter]
    fn depth_mm(&self) -> Value {
        let depth = self.taken.prepared.pressed().map(|(_, step)| step.depth_mm);
        (&Figure::of(depth, "the scene presses nothing")).into()
    }

    /// The paper's figures of the frame, less ``reference`` where one is given (such as ``image.baseline``).
    /// ``threshold``: brighter pixels are lit, in grey levels or as a share of full scale like ``"2%"``; the paper's 5
    /// levels if not given.
    ///
    /// Raises SceneError for a reference of another size or bit depth, ValueError and TypeError for a threshold that
    /// makes no sense.
    #[pyo3(signature = (*, threshold = None, reference = None))]
    fn read(
        &self,
        py: Python<'_>,
        threshold: Option<&Bound<'_, PyAny>>,
        reference: Option<&Bound<'_, Self>>,
    ) -> Result<Reading, Trouble> {
        let threshold_grey = threshold_grey(threshold, self.taken.frame.bit_depth)?;
        let file = &self.scene.get().file;
        let reference = reference.map(Bound::get);
        py.detach(|| {
            let other = reference.map(|image| image.taken.shot().as_reference()).transpose();
            let other = other.map_err(|error| Trouble::of_scene(error.into(), file))?;
            let read_as = ReadAs { threshold_grey, reference: other.as_ref(), calibration: None };
            let reading = self.taken.shot().read(&read_as).map_err(|error| Trouble::of_scene(error, file))?;
            Ok(Reading::of(&reading, reference.map(|image| image.taken.summary.scene.clone())))
        })
    }

    /// Another frame of the same light: with another exposure time, other bits of a grey level (8 to 16) or another
    /// seed of the sensor's noise. What is not given is that of ``frame``.
    ///
    /// Raises ValueError for numbers that no camera has.
    #[pyo3(signature = (*, exposure_ms = None, bit_depth = None, seed = None))]
    fn expose(
        &self,
        py: Python<'_>,
        exposure_ms: Option<f64>,
        bit_depth: Option<u32>,
        seed: Option<u32>,
    ) -> Result<Exposure, Trouble> {
        let seed = Some(seed.unwrap_or(self.taken.prepared.streams.sensor()));
        let wanted = Wanted { exposure_ms, bit_depth, seed };
        Exposure::of(py, self.scene.get(), &self.taken.outcome.film, None, wanted)
    }

    /// Writes a file: ``.exr`` radiance and variance with their provenance, as ``tirtouch render`` does, ``.png`` the
    /// camera's frame.
    ///
    /// Raises TirtouchError where it cannot be written, ValueError for another ending.
    fn write(&self, py: Python<'_>, path: PathBuf) -> Result<(), Trouble> {
        let ending = path.extension().map(|ending| ending.to_string_lossy().to_ascii_lowercase());
        let taken = &self.taken;
        match ending.as_deref() {
            Some("exr") => Ok(py.detach(|| taken.shot().write_radiance(&path, COMMAND))?),
            Some("png") => Ok(py.detach(|| taken.frame.write_png(&path))?),
            _ => Err(PyValueError::new_err(format!("{}: must end in .exr or .png", path.display())).into()),
        }
    }

    /// What ``tirtouch render --json`` says, less what is about files.
    fn to_dict<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyDict>, Trouble> {
        let mut said = json(&self.taken.summary)?;
        said["truth"] = self.truth.clone();
        Ok(to_dict(py, &said)?)
    }

    /// Radiance, variance and frame as an xarray.Dataset over ``y_mm`` and ``x_mm``. Raises ImportError without xarray.
    fn to_xarray<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("tirtouch._tables")?.call_method1("image_to_xarray", (slf,))
    }

    fn __repr__(&self) -> String {
        let Frame { width, height, .. } = self.taken.frame;
        format!("<tirtouch.Image of {:?}, {width} x {height} pixels>", self.taken.summary.scene)
    }
}

/// The images with what belongs to them, as Python holds them.
pub fn images(
    taken: Vec<Taken>,
    scene: &Bound<'_, Scene>,
    truth: &serde_json::Value,
    baseline: Option<&Py<Image>>,
) -> PyResult<Vec<Py<Image>>> {
    let py = scene.py();
    let image = |taken| {
        let baseline = baseline.map(|baseline| baseline.clone_ref(py));
        Py::new(py, Image::new(taken, scene.clone().unbind(), truth.clone(), baseline))
    };
    taken.into_iter().map(image).collect()
}
