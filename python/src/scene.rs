//! Scenes.

use crate::json::{json, to_dict, to_python, to_table, to_value, without_nulls};
use crate::trouble::Trouble;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use tirtouch::failure::Failure;
use tirtouch::scene::{self, LoadedScene, PRESETS};
use tirtouch::vary::{self, Set};

/// A checked scene: sensor, camera, phantom and press. It never changes; ``set`` gives another.
///
/// Keys and their units are those of scene files (docs/SCENES.md): mm, nm, kPa, degrees.
#[pyclass(frozen, module = "tirtouch")]
pub struct Scene {
    pub loaded: Arc<LoadedScene>,
    /// Name in messages; the files that the scene names lie in its folder.
    pub file: PathBuf,
}

impl Scene {
    pub fn of(loaded: LoadedScene, file: PathBuf) -> Self {
        Self { loaded: Arc::new(loaded), file }
    }
}

#[pymethods]
impl Scene {
    /// Reads a scene file, or the preset of ``"preset:NAME"``.
    ///
    /// Raises SceneError, with file, line and key, where it cannot be used.
    #[staticmethod]
    fn open(path: PathBuf) -> Result<Self, Trouble> {
        let (loaded, file) = scene::open(&path)?;
        Ok(Self::of(loaded, file))
    }

    /// A scene that comes with the program, by its name.
    ///
    /// Raises SceneError, which lists the names, where there is none of that name.
    #[staticmethod]
    fn preset(name: &str) -> Result<Self, Trouble> {
        Ok(Self::of(scene::preset(name)?, format!("{name}.toml").into()))
    }

    /// Names of the scenes that come with the program.
    #[staticmethod]
    fn presets() -> Vec<&'static str> {
        PRESETS.iter().map(|(name, _)| *name).collect()
    }

    /// A scene from the text of a scene file. ``file`` is its name in messages, ``scene.toml`` if not given; files that
    /// the scene names are sought in its folder when they are needed.
    ///
    /// Raises SceneError, with line and key, where it cannot be used.
    #[staticmethod]
    #[pyo3(signature = (text, file = PathBuf::from("scene.toml")))]
    fn parse(text: &str, file: PathBuf) -> Result<Self, Trouble> {
        Ok(Self::of(scene::parse(text, &file)?, file))
    }

    /// A scene from a dictionary with the keys of a scene file; keys that are None are left out. ``file`` is as for
    /// ``parse``; lines in messages are those of the text that ``to_toml`` gives.
    ///
    /// Raises SceneError where it cannot be used, TypeError for what no scene can hold.
    #[staticmethod]
    #[pyo3(signature = (values, file = PathBuf::from("scene.toml")))]
    fn from_dict(values: &Bound<'_, PyDict>, file: PathBuf) -> Result<Self, Trouble> {
        let table = to_table(values)?;
        let text = toml::to_string(&table).map_err(|error| Trouble::input(error.to_string()))?;
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

    /// The scene with keys set, as in ``scene.set({"stack.layer[0].n": 1.42, "camera.pixels": [64, 48]})``. Keys are as
    /// in sweeps: ``led[*].power_mw`` are all of a list, ``stack.layer["glass"].n`` one by its name. A list or a
    /// dictionary takes the whole place of a list or a table.
    ///
    /// Raises SceneError for a key that leads nowhere and for a scene that breaks a rule, TypeError for what no scene
    /// can hold.
    fn set(&self, values: &Bound<'_, PyDict>) -> Result<Self, Trouble> {
        let loaded = vary::with((*self.loaded).clone(), &self.file, &sets_of(values, &self.file)?)?;
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
        let [width, height] = self.loaded.scene.camera.pixels;
        format!("<tirtouch.Scene {:?}, {width} x {height} pixels>", self.name())
    }

    /// For pickle: text and file.
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyTuple>)> {
        let parse = py.get_type::<Self>().getattr("parse")?;
        Ok((parse, (self.to_toml(), &self.file).into_pyobject(py)?))
    }
}

/// Keys and their values.
///
/// # Errors
/// `SceneError` for a key that is none, `TypeError` for what no scene can hold.
pub fn sets_of(values: &Bound<'_, PyDict>, file: &Path) -> Result<Vec<Set>, Trouble> {
    values.iter().map(|(key, value)| set_of(&key, &value, file)).collect()
}

fn set_of(key: &Bound<'_, PyAny>, value: &Bound<'_, PyAny>, file: &Path) -> Result<Set, Trouble> {
    let key: String = key.extract()?;
    let value = to_value(value, &key)?;
    let wrong =
        |why: String| Trouble::scene(Failure::input(format!("{}: {why}", file.display())).in_file(file).at_key(&key));
    Ok(Set { key: key.parse().map_err(wrong)?, value })
}

/// The JSON schema of scene files, or with ``sweep`` of sweep files, as a dictionary.
#[pyfunction]
#[pyo3(signature = (*, sweep = false))]
pub fn schema(py: Python<'_>, sweep: bool) -> PyResult<Bound<'_, PyAny>> {
    to_python(py, &if sweep { tirtouch::sweep::schema() } else { scene::schema() })
}
