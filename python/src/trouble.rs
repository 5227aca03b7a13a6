//! What goes wrong, as Python's exceptions.

use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple, PyType};
use std::path::Path;
use tirtouch::calibrate::CalibrateError;
use tirtouch::estimate::tissue::TissueError;
use tirtouch::failure::{Failure, Kind};
use tirtouch::image_io::ImageError;
use tirtouch::mechanics::frames::scan::ScanError;
use tirtouch::mechanics::press::PressError;
use tirtouch::output::{OutputError, Remedy};
use tirtouch::pages::PageError;
use tirtouch::pipeline::PipelineError;
use tirtouch::scene::SceneError;
use tirtouch::sweep::{SweepError, SweepFolderError};
use tirtouch::trace::TraceError;

/// Classes of `_errors.py`. They are written in Python: Rust classes cannot extend `Exception` in the stable ABI.
#[derive(Debug, Clone, Copy)]
pub enum Class {
    Error,
    Scene,
    Device,
    Stopped,
    Press,
}

/// What goes wrong: in the library, or in Python.
pub enum Trouble {
    Said(Box<Failure>, Class),
    /// A press that stopped early, with the Press of the loads that it reached.
    Press(Box<Failure>, Py<PyAny>),
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

    /// Of a sweep in that folder.
    pub fn of_sweep(error: SweepError, folder: &Path) -> Self {
        match error {
            SweepError::Output(error) => error.into(),
            error @ SweepError::Device { .. } => Self::Said(Box::new(error.into()), Class::Device),
            SweepError::Stopped => {
                let words = format!("stopped on request; what was done is in {}", folder.display());
                Self::Said(Box::new(Failure::failed(words)), Class::Stopped)
            }
        }
    }

    /// Of a scan that came from `file`.
    pub fn of_scan(error: ScanError, file: &Path) -> Self {
        Self::of_failure(error.into(), file)
    }

    /// Of frames whose tissue was sought beside what the scan of that file knows.
    pub fn of_tissue(error: TissueError, file: &Path) -> Self {
        match error {
            TissueError::Scan(_) | TissueError::Scene { .. } => Self::of_failure(error.into(), file),
            error => Failure::from(error).into(),
        }
    }

    /// A scene of that file is to blame where the input is.
    fn of_failure(failure: Failure, file: &Path) -> Self {
        match failure.kind() {
            Kind::Input if failure.names_a_file() => Self::scene(failure),
            Kind::Input => Self::scene(failure.prefixed(&file.display().to_string()).in_file(file)),
            _ => failure.into(),
        }
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

impl From<OutputError> for Trouble {
    fn from(error: OutputError) -> Self {
        let help = match &error {
            OutputError::Refused { remedy: Remedy::Replace, .. } => "; force=True replaces it",
            OutputError::Refused { remedy: Remedy::GoOn, .. } => {
                "; resume=True goes on with it, force=True replaces it"
            }
            OutputError::Refused { remedy: Remedy::Elsewhere, .. } => "; choose another folder",
            _ => return Failure::from(error).into(),
        };
        let words = format!("{error}{help}");
        match error {
            OutputError::Refused { place, .. } => Failure::input(words).in_file(&place).into(),
            _ => Failure::input(words).into(),
        }
    }
}

impl From<SweepFolderError> for Trouble {
    fn from(error: SweepFolderError) -> Self {
        match error {
            SweepFolderError::Output(error) => error.into(),
            SweepFolderError::Scene(error) => error.into(),
            error @ SweepFolderError::Strange(_) => Failure::from(error).into(),
        }
    }
}

impl From<PageError> for Trouble {
    fn from(error: PageError) -> Self {
        match error {
            PageError::Output(error) => error.into(),
            error => Failure::from(error).into(),
        }
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
                Python::attach(|py| exception(py, &failure, class, None).unwrap_or_else(|error| error))
            }
            Trouble::Press(failure, press) => {
                Python::attach(|py| exception(py, &failure, Class::Press, Some(press)).unwrap_or_else(|error| error))
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

fn exception(py: Python<'_>, failure: &Failure, class: Class, reached: Option<Py<PyAny>>) -> PyResult<PyErr> {
    let name = match class {
        Class::Error => "TirtouchError",
        Class::Scene => "SceneError",
        Class::Device => "DeviceError",
        Class::Stopped => "Stopped",
        Class::Press => "PressError",
    };
    let class = py.import("tirtouch._errors")?.getattr(name)?.cast_into::<PyType>()?;
    // The command line's own words are of the folder that it was writing.
    let message = if failure.kind() == Kind::Cancelled { "stopped on request" } else { failure.message() };
    let (file, line, key) = failure.place();
    let place = PyDict::new(py);
    place.set_item("file", file.map(|file| file.to_string_lossy().into_owned()))?;
    place.set_item("line", line)?;
    place.set_item("key", key)?;
    if let Some(reached) = reached {
        place.set_item("reached", reached)?;
    }
    let said = failure.json();
    let others = said["errors"].as_array().into_iter().flatten().skip(1);
    let others: Vec<&str> = others.filter_map(|other| other["message"].as_str()).collect();
    place.set_item("others", PyTuple::new(py, others)?)?;
    Ok(PyErr::from_value(class.call((message,), Some(&place))?))
}
