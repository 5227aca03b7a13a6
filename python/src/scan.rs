//! Scans: an indenter pressed into tissue at one position after the other.

use crate::json::{json, to_dict, to_table, without_nulls};
use crate::scene::sets_of;
use crate::trouble::Trouble;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use std::path::PathBuf;
use std::sync::Arc;
use tirtouch::scene::{self, LoadedScan, SCAN_PRESETS};
use tirtouch::vary;

/// A checked scan scene: tissue, and an indenter that is pressed into it at one position after the other. It never
/// changes; ``set`` gives another.
///
/// Keys and their units are those of scan scene files (docs/SCENES.md): mm, kPa.
#[pyclass(frozen, module = "tirtouch")]
pub struct Scan {
    pub loaded: Arc<LoadedScan>,
    /// Name in messages; the files that the scene names lie in its folder.
    pub file: PathBuf,
}

impl Scan {
    fn of(loaded: LoadedScan, file: PathBuf) -> Self {
        Self { loaded: Arc::new(loaded), file }
    }
}

#[pymethods]
impl Scan {
    /// Reads a scan scene file, or the preset of ``"preset:NAME"``.
    ///
    /// Raises SceneError, with file, line and key, where it cannot be used.
    #[staticmethod]
    fn open(path: PathBuf) -> Result<Self, Trouble> {
        let (loaded, file) = scene::open_scan(&path)?;
        Ok(Self::of(loaded, file))
    }

    /// A scan scene that comes with the program, by its name.
    ///
    /// Raises SceneError, which lists the names, where there is none of that name.
    #[staticmethod]
    fn preset(name: &str) -> Result<Self, Trouble> {
        Ok(Self::of(scene::scan_preset(name)?, format!("{name}.toml").into()))
    }

    /// Names of the scan scenes that come with the program.
    #[staticmethod]
    fn presets() -> Vec<&'static str> {
        SCAN_PRESETS.iter().map(|(name, _)| *name).collect()
    }

    /// A scan scene from the text of its file. ``file`` is its name in messages, ``scan.toml`` if not given; files that
    /// the scene names are sought in its folder when they are needed.
    ///
    /// Raises SceneError, with line and key, where it cannot be used.
    #[staticmethod]
    #[pyo3(signature = (text, file = PathBuf::from("scan.toml")))]
    fn parse(text: &str, file: PathBuf) -> Result<Self, Trouble> {
        Ok(Self::of(scene::parse_scan(text, &file)?, file))
    }

    /// A scan scene from a dictionary with the keys of its file; keys that are None are left out. ``file`` is as for
    /// ``parse``.
    ///
    /// Raises SceneError where it cannot be used, TypeError for what no scene can hold.
    #[staticmethod]
    #[pyo3(signature = (values, file = PathBuf::from("scan.toml")))]
    fn from_dict(values: &Bound<'_, PyDict>, file: PathBuf) -> Result<Self, Trouble> {
        let text = toml::to_string(&to_table(values)?).map_err(|error| Trouble::input(error.to_string()))?;
        Self::parse(&text, file)
    }

    /// All keys, defaults included, as a dictionary that ``from_dict`` takes.
    fn to_dict<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyDict>, Trouble> {
        Ok(to_dict(py, &without_nulls(json(&self.loaded.scene)?))?)
    }

    /// The text of the scene file, as it was read, or as ``set`` and ``from_dict`` made it.
    fn to_toml(&self) -> &str {
        &self.loaded.text
    }

    /// The scene with keys set, as by ``Scene.set``.
    ///
    /// Raises what ``Scene.set`` does.
    fn set(&self, values: &Bound<'_, PyDict>) -> Result<Self, Trouble> {
        let loaded = vary::with_scan((*self.loaded).clone(), &self.file, &sets_of(values, &self.file)?)?;
        Ok(Self::of(loaded, self.file.clone()))
    }

    /// Name of the scene.
    #[getter]
    fn name(&self) -> &str {
        &self.loaded.scene.name
    }

    /// What the scene is and where its numbers come from.
    #[getter]
    fn description(&self) -> &str {
        &self.loaded.scene.description
    }

    fn __eq__(&self, other: &Bound<'_, PyAny>) -> bool {
        other.cast::<Self>().is_ok_and(|other| other.get().loaded.scene == self.loaded.scene)
    }

    fn __repr__(&self) -> String {
        format!("<tirtouch.Scan {:?}>", self.name())
    }

    /// For pickle: text and file.
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyTuple>)> {
        let parse = py.get_type::<Self>().getattr("parse")?;
        Ok((parse, (self.to_toml(), &self.file).into_pyobject(py)?))
    }
}
