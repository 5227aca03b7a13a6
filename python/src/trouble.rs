//! What goes wrong, as Python's exceptions.

use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple, PyType};
use std::path::Path;
use tirtouch::calibrate::CalibrateError;
use tirtouch::cli::{Failure, Kind};
use tirtouch::image_io::ImageError;
use tirtouch::mechanics::press::PressError;
use tirtouch::pipeline::PipelineError;
use tirtouch::scene::SceneError;
use tirtouch::trace::TraceError;

/// Classes of `_errors.py`. They are written in Python: Rust classes cannot extend `Exception` in the stable ABI.
#[derive(Debug, Clone, Copy)]
pub enum Class {
    Error,
    Scene,
    Device,
    Stopped,
}

/// What goes wrong: in the library, or in Python.
#[derive(Debug)]
pub enum Trouble {
    Said(Box<Failure>, Class),
    Python(PyErr),
}

impl Trouble {
    /// Of a scene that came from `file`.
    pub fn of_scene(error: PipelineError, file: &Path) -> Self {
        let is_device = matches!(&error, PipelineError::Trace(error) if is_device(error));
        let failure = Failure::of_scene(error, file);
        let class = match failure.kind() {
            Kind::Input => Class::Scene,
            _ if is_device => Class::Device,
            kind => of_kind(kind),
        };
        Self::Said(Box::new(failure), class)
    }

    /// A mistake of a scene.
    pub fn scene(failure: Failure) -> Self {
        Self::Said(Box::new(failure), Class::Scene)
    }

    /// A scene that presses nothing, where a press is asked for.
    pub fn no_press(file: &Path) -> Self {
        let failure = Failure::input(format!("{}: {}", file.display(), PressError::NoPress));
        Self::scene(failure.in_file(file).at_key("press"))
    }

    /// Bad input that is no scene.
    pub fn input(message: String) -> Self {
        Failure::input(message).into()
    }
}

impl From<Failure> for Trouble {
    fn from(failure: Failure) -> Self {
        let class = of_kind(failure.kind());
        Self::Said(Box::new(failure), class)
    }
}

impl From<SceneError> for Trouble {
    fn from(error: SceneError) -> Self {
        Self::Said(Box::new(error.into()), Class::Scene)
    }
}

impl From<TraceError> for Trouble {
    fn from(error: TraceError) -> Self {
        let class = is_device(&error).then_some(Class::Device);
        let failure = Failure::from(error);
        let class = class.unwrap_or(of_kind(failure.kind()));
        Self::Said(Box::new(failure), class)
    }
}

impl From<ImageError> for Trouble {
    fn from(error: ImageError) -> Self {
        Failure::from(error).into()
    }
}

impl From<CalibrateError> for Trouble {
    fn from(error: CalibrateError) -> Self {
        Failure::from(error).into()
    }
}

impl From<PyErr> for Trouble {
    fn from(error: PyErr) -> Self {
        Self::Python(error)
    }
}

impl From<Trouble> for PyErr {
    fn from(trouble: Trouble) -> Self {
        match trouble {
            Trouble::Python(error) => error,
            Trouble::Said(failure, class) => {
                Python::attach(|py| exception(py, &failure, class).unwrap_or_else(|error| error))
            }
        }
    }
}

fn of_kind(kind: Kind) -> Class {
    if kind == Kind::Cancelled { Class::Stopped } else { Class::Error }
}

/// Whether what computes is to blame.
fn is_device(error: &TraceError) -> bool {
    use TraceError::{CutShort, DeviceLost, Driver, Memory, NoAdapter};
    matches!(error, NoAdapter | DeviceLost(_) | Memory { .. } | Driver(_) | CutShort { .. })
}

fn exception(py: Python<'_>, failure: &Failure, class: Class) -> PyResult<PyErr> {
    let name = match class {
        Class::Error => "TirtouchError",
        Class::Scene => "SceneError",
        Class::Device => "DeviceError",
        Class::Stopped => "Stopped",
    };
    let class = py.import("tirtouch._errors")?.getattr(name)?.cast_into::<PyType>()?;
    let (file, line, key) = failure.place();
    let place = PyDict::new(py);
    place.set_item("file", file.map(|file| file.to_string_lossy().into_owned()))?;
    place.set_item("line", line)?;
    place.set_item("key", key)?;
    let said = failure.json();
    let others = said["errors"].as_array().into_iter().flatten().skip(1);
    let others: Vec<&str> = others.filter_map(|other| other["message"].as_str()).collect();
    place.set_item("others", PyTuple::new(py, others)?)?;
    Ok(PyErr::from_value(class.call((failure.message(),), Some(&place))?))
}
