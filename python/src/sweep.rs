//! Sweeps.

use crate::COMMAND;
use crate::json::{json, to_dict, to_table, to_value, without_nulls};
use crate::scene::Scene;
use crate::session::{Session, with_session};
use crate::sweep_status::SweepStatus;
use crate::trouble::Trouble;
use numpy::PyArray1;
use pyo3::exceptions::{PyIndexError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString, PyTuple};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;
use tirtouch::failure::Failure;
use tirtouch::output::{RESULT, Records};
use tirtouch::pages::sweep::{Points, points, write};
use tirtouch::scene;
use tirtouch::sweep::{self, NoScene, Options, Shard, Status, by_hand};
use tirtouch::vary::Scalar;

/// The copy of the scene in the folder of a sweep: what the sweep of a scene that is there already names.
const SCENE: &str = "scene.toml";
/// Most workers.
const MOST_WORKERS: usize = 256;

/// Many points of a scene: keys that vary, a design of points, and what is measured at each (docs/SWEEPS.md). It never
/// changes; ``len`` is how many points there are.
///
/// ``scene`` is the scene that varies. ``set`` says what varies: a key of the scene with the list of its values, or
/// with a dictionary as in the ``[[vary]]`` of a sweep file, such as ``{"uniform": [1.40, 1.44]}``. ``measures`` are
/// kinds, ``"contrast"`` or ``"contrast radius_mm=4"``, or dictionaries as in ``[[measure]]``; if not given, the mean
/// radiance, or nothing where images are kept. ``design`` is a dictionary such as ``{"kind": "sobol", "points": 64}``;
/// if not given, the grid of all values with all others, the last key changing fastest. ``require`` are expressions
/// that must hold. ``images`` keeps images, as in ``{"format": "exr", "loads": "all"}``.
///
/// ``seed`` of all random numbers is the scene's if not given. ``target_error`` is the relative error that each image
/// is traced to; if not given, samples are the scene's. ``random_numbers`` ``"common"`` are the same at all points, so
/// that images differ by what varies and little noise; ``"own"`` are of each point. ``name`` is the sweep's, also in
/// messages; if not given, it is made of the scene's.
///
/// Raises SceneError for what no sweep can hold, TypeError for values of other types.
#[pyclass(frozen, module = "tirtouch")]
pub struct Sweep {
    pub sweep: Arc<sweep::Sweep>,
    /// Name in messages.
    file: PathBuf,
}

impl Sweep {
    pub fn of(sweep: sweep::Sweep, file: PathBuf) -> Self {
        Self { sweep: Arc::new(sweep), file }
    }
}

// The tables of a sweep file are Python's keywords: each is an argument.
#[allow(clippy::too_many_arguments)]
#[pymethods]
impl Sweep {
    // Python shows no docstring of a constructor: what it takes is said of the class.
    #[new]
    #[pyo3(signature = (scene, *, set, measures = None, design = None, require = None, images = None, seed = None,
                        target_error = None, random_numbers = "common", name = None))]
    fn by_hand(
        scene: &Bound<'_, Scene>,
        set: &Bound<'_, PyDict>,
        measures: Option<Vec<Bound<'_, PyAny>>>,
        design: Option<&Bound<'_, PyDict>>,
        require: Option<Vec<String>>,
        images: Option<&Bound<'_, PyDict>>,
        seed: Option<u32>,
        target_error: Option<f64>,
        random_numbers: &str,
        name: Option<String>,
    ) -> Result<Self, Trouble> {
        let base = scene.get();
        let design = design.map(to_table).transpose()?.unwrap_or_else(|| toml::toml! { kind = "grid" });
        let mut settings = toml::toml! { scene = SCENE };
        settings.insert("design".into(), design.into());
        settings.insert("random_numbers".into(), random_numbers.into());
        settings.extend(images.map(to_table).transpose()?.map(|images| ("images".to_owned(), images.into())));
        settings.extend(seed.map(|seed| ("seed".to_owned(), i64::from(seed).into())));
        settings.extend(target_error.map(|error| ("target_error".to_owned(), error.into())));
        let vary = set.iter().map(|(key, values)| vary(&key, &values)).collect::<PyResult<Vec<_>>>()?;
        let measures = match (measures, images) {
            (Some(measures), _) => measures,
            (None, Some(_)) => Vec::new(),
            (None, None) => vec![PyString::new(scene.py(), "mean_radiance").into_any()],
        };
        let measures = measures.iter().enumerate().map(|(k, one)| measure(one, k)).collect::<PyResult<Vec<_>>>()?;
        let require = require.into_iter().flatten().map(|expression| toml::toml! { expression = expression }.into());
        let mut file = toml::Table::new();
        file.insert("sweep".into(), settings.into());
        file.insert("vary".into(), vary.into());
        file.insert("require".into(), toml::Value::Array(require.collect()));
        file.insert("measure".into(), measures.into());
        let text = toml::to_string(&file).map_err(|error| Trouble::input(error.to_string()))?;
        let name = name.unwrap_or_else(|| format!("{}-sweep", base.loaded.scene.name));
        let file = PathBuf::from(format!("{name}.toml"));
        let sweep = sweep::Sweep::of_scene(&text, &file, (*base.loaded).clone(), base.file.clone())?;
        Ok(Self::of(sweep, file))
    }

    /// Reads a sweep file, or the sweep of a folder that ``run`` made.
    ///
    /// Raises SceneError, with file, line and key, where it cannot be used, TirtouchError for a folder of something
    /// else.
    #[staticmethod]
    fn open(path: PathBuf) -> Result<Self, Trouble> {
        Ok(Self::of(sweep::Sweep::open(&path)?, path))
    }

    /// A sweep from the text of a sweep file. ``file`` is its name in messages, ``sweep.toml`` if not given; the files
    /// that it names are sought in its folder.
    ///
    /// Raises SceneError, with line and key, where it cannot be used.
    #[staticmethod]
    #[pyo3(signature = (text, file = PathBuf::from("sweep.toml")))]
    fn parse(text: &str, file: PathBuf) -> Result<Self, Trouble> {
        Ok(Self::of(sweep::Sweep::parse(text, &file)?, file))
    }

    /// A sweep from a dictionary with the keys of a sweep file; keys that are None are left out. ``file`` is as for
    /// ``parse``.
    ///
    /// Raises SceneError where it cannot be used, TypeError for what no sweep can hold.
    #[staticmethod]
    #[pyo3(signature = (values, file = PathBuf::from("sweep.toml")))]
    fn from_dict(values: &Bound<'_, PyDict>, file: PathBuf) -> Result<Self, Trouble> {
        let text = toml::to_string(&to_table(values)?).map_err(|error| Trouble::input(error.to_string()))?;
        Self::parse(&text, file)
    }

    /// All keys, defaults included, as a dictionary.
    fn to_dict<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyDict>, Trouble> {
        Ok(to_dict(py, &without_nulls(json(&self.sweep.file)?))?)
    }

    /// The text of the sweep file.
    fn to_toml(&self) -> &str {
        &self.sweep.text
    }

    /// Name of the sweep.
    #[getter]
    fn name(&self) -> &str {
        &self.sweep.name
    }

    /// Names of what varies, as columns of ``SweepResults.points`` have them.
    #[getter]
    fn variables(&self) -> Vec<&str> {
        self.sweep.plan.names().collect()
    }

    /// Names of the figures, as columns of ``SweepResults.points`` have them.
    #[getter]
    fn figures(&self) -> Vec<&str> {
        self.sweep.columns().collect()
    }

    /// The scene that varies.
    #[getter]
    fn base(&self) -> Scene {
        Scene::of(self.sweep.base.clone(), self.sweep.base_file.clone())
    }

    /// The scene of a point; ``row`` counts from 0.
    ///
    /// Raises IndexError for a row that there is not, SceneError for a point that makes no scene.
    fn scene(&self, row: usize) -> Result<Scene, Trouble> {
        let text = self.sweep.scene_text(row).map_err(|error| no_scene(&error, &self.file))?;
        let mut loaded = scene::parse(&text, &self.sweep.base_file)?;
        loaded.files = self.sweep.base.files.clone();
        Ok(Scene::of(loaded, self.sweep.base_file.clone()))
    }

    /// Computes the points that have no record yet in a folder, and writes its tables and its report, as ``tirtouch
    /// sweep run`` does, with the same records. ``session`` traces; if not given, one is opened.
    ///
    /// A folder that is there is refused, unless ``resume`` goes on with it, beside other workers if there are any, or
    /// ``force`` replaces it. ``retry`` computes points again that failed. ``shard`` is ``(k, n)``: only part k of n of
    /// the points, from 1. ``workers`` threads press beside the one that traces (1 to 256; if not given, half of the
    /// cores). A sweep that was stopped, by ``progress`` or Ctrl-C, keeps all points that were done: ``resume`` goes
    /// on.
    ///
    /// Raises TirtouchError for a folder that cannot be written, DeviceError, Stopped, and ValueError for arguments
    /// that make no sense. Points that cannot be computed stop nothing: they are ``failed`` in the table, with the
    /// reason.
    #[pyo3(signature = (folder, *, session = None, resume = false, force = false, retry = false, shard = None,
                        workers = None, progress = None))]
    fn run(
        &self,
        py: Python<'_>,
        folder: PathBuf,
        session: Option<&Bound<'_, Session>>,
        resume: bool,
        force: bool,
        retry: bool,
        shard: Option<(u32, u32)>,
        workers: Option<usize>,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> Result<SweepResults, Trouble> {
        if resume && force {
            return Err(PyValueError::new_err("resume goes on with a folder, force replaces it: give one").into());
        }
        let options = options(shard, workers, retry)?;
        let sweep = &self.sweep;
        let told = with_session(py, session, progress, |session, observe| {
            let start = Instant::now();
            let records = sweep.enter(&folder, force, resume)?;
            let of_sweep = |error| Trouble::of_sweep(error, &folder);
            let computed = sweep::run(sweep, &records, session, options, observe).map_err(of_sweep)?;
            let status = write(sweep, &records, COMMAND)?;
            let told = status.run_json(sweep, start.elapsed().as_secs_f64(), computed);
            let mut result = tirtouch::output::described(told.clone(), Some(&folder));
            result["command"] = serde_json::json!([COMMAND]);
            records.write(RESULT, &format!("{result:#}\n"))?;
            Ok(told)
        })?;
        Ok(SweepResults::of(sweep.clone(), folder, Some(told)))
    }

    /// How far the sweep of a folder is, from whatever records are there.
    ///
    /// Raises TirtouchError for a folder without records of this sweep.
    fn status(&self, folder: PathBuf) -> Result<SweepStatus, Trouble> {
        SweepResults::of(self.sweep.clone(), folder, None).known_status()
    }

    fn __len__(&self) -> usize {
        self.sweep.plan.count()
    }

    fn __repr__(&self) -> String {
        format!("<tirtouch.Sweep {:?}, {} points>", self.sweep.name, self.sweep.plan.count())
    }

    /// For pickle: text, scene, and the name of the file.
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyTuple>)> {
        let again = py.get_type::<Self>().getattr("_again")?;
        Ok((again, (self.to_toml(), self.base(), &self.file).into_pyobject(py)?))
    }

    /// What pickle was told.
    #[staticmethod]
    fn _again(text: &str, base: &Bound<'_, Scene>, file: PathBuf) -> Result<Self, Trouble> {
        let base = base.get();
        let sweep = sweep::Sweep::of_scene(text, &file, (*base.loaded).clone(), base.file.clone())?;
        Ok(Self::of(sweep, file))
    }
}

/// The folder of a sweep: what its records say, from whatever is there.
#[pyclass(frozen, module = "tirtouch")]
pub struct SweepResults {
    sweep: Arc<sweep::Sweep>,
    folder: PathBuf,
    /// What the run said that made it.
    told: Option<serde_json::Value>,
}

impl SweepResults {
    pub fn of(sweep: Arc<sweep::Sweep>, folder: PathBuf, told: Option<serde_json::Value>) -> Self {
        Self { sweep, folder, told }
    }

    /// The records, if they are of this sweep.
    fn records(&self) -> Result<Records, Trouble> {
        let (records, order) = Records::read(&self.folder)?;
        match order == self.sweep.order() {
            true => Ok(records),
            false => {
                let message = format!("{}: holds the records of another sweep", self.folder.display());
                Err(Failure::input(message).in_file(&self.folder).into())
            }
        }
    }

    pub fn known_status(&self) -> Result<SweepStatus, Trouble> {
        let status = Status::of(&self.sweep, &self.records()?);
        Ok(SweepStatus { status, name: self.sweep.name.clone() })
    }
}

#[pymethods]
impl SweepResults {
    /// The results of a folder that ``Sweep.run`` or ``tirtouch sweep run`` made.
    ///
    /// Raises TirtouchError for a folder of something else.
    #[staticmethod]
    fn open(folder: PathBuf) -> Result<Self, Trouble> {
        let (sweep, _) = sweep::Sweep::of_folder(&folder)?;
        Ok(Self::of(Arc::new(sweep), folder, None))
    }

    /// The folder.
    #[getter]
    fn folder(&self) -> &Path {
        &self.folder
    }

    /// The sweep.
    #[getter]
    fn sweep(&self) -> Sweep {
        Sweep::of((*self.sweep).clone(), self.folder.join("sweep.toml"))
    }

    /// Time that the run took, s; None where it was not this one.
    #[getter]
    fn seconds(&self) -> Option<f64> {
        self.told.as_ref()?.get("seconds")?.as_f64()
    }

    /// How far the sweep is.
    ///
    /// Raises TirtouchError for a folder without its records.
    fn status(&self) -> Result<SweepStatus, Trouble> {
        self.known_status()
    }

    /// All points in the order of the design, as columns of one length by the names of points.csv: ``row`` (int64, from
    /// 0), ``status`` (``"done"``, ``"rejected"``, ``"failed"``, ``"missing"``), what varies by its names, each figure
    /// with its ``_low`` and ``_high`` (95 %), ``relative_error``, ``note``. Numbers are float64, NaN where there is
    /// none; columns of texts are lists, with None.
    ///
    /// Raises TirtouchError for a folder without records of the sweep.
    fn points<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyDict>, Trouble> {
        let records = self.records()?;
        let Points { head, rows } = py.detach(|| points(&self.sweep, &records));
        let columns = PyDict::new(py);
        for (k, name) in head.into_iter().enumerate() {
            let cells: Vec<Option<&Scalar>> = rows.iter().map(|row| row.get(k).and_then(Option::as_ref)).collect();
            let is_text = |cell: &Option<&Scalar>| matches!(cell, Some(Scalar::Text(_) | Scalar::Flag(_)));
            if k == 0 {
                columns.set_item(name, PyArray1::from_iter(py, 0..rows.len() as i64))?;
            } else if ["status", "note"].contains(&name.as_str()) || cells.iter().any(is_text) {
                let cells = cells.into_iter().map(|cell| python(py, cell)).collect::<PyResult<Vec<_>>>()?;
                columns.set_item(name, cells)?;
            } else {
                let numbers = cells.into_iter().map(|cell| cell.and_then(Scalar::number).unwrap_or(f64::NAN));
                columns.set_item(name, PyArray1::from_iter(py, numbers))?;
            }
        }
        Ok(columns)
    }

    /// ``points`` as a pandas.DataFrame. Raises ImportError without pandas.
    fn to_pandas<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("tirtouch._tables")?.call_method1("points_to_pandas", (slf,))
    }

    /// The scene of a point; ``row`` counts from 0.
    ///
    /// Raises IndexError for a row that there is not, SceneError for a point that makes no scene.
    fn scene(&self, py: Python<'_>, row: usize) -> PyResult<Py<PyAny>> {
        Ok(Bound::new(py, self.sweep())?.call_method1("scene", (row,))?.unbind())
    }

    /// Writes the tables and the report of whatever records the folder has.
    ///
    /// Raises TirtouchError for a folder without records of the sweep, or that cannot be written.
    fn collect(&self, py: Python<'_>) -> Result<SweepStatus, Trouble> {
        let records = self.records()?;
        let status = py.detach(|| write(&self.sweep, &records, COMMAND))?;
        Ok(SweepStatus { status, name: self.sweep.name.clone() })
    }

    /// What ``tirtouch sweep run --json`` says, less what is about files; what ``tirtouch sweep status --json`` says
    /// where the run was not this one.
    fn to_dict<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyDict>, Trouble> {
        match &self.told {
            Some(told) => Ok(to_dict(py, told)?),
            None => self.known_status()?.to_dict(py),
        }
    }

    fn __repr__(&self) -> String {
        format!("<tirtouch.SweepResults of {:?} in {}>", self.sweep.name, self.folder.display())
    }
}

/// How points are computed.
///
/// # Errors
/// `ValueError` for numbers that make no sense.
pub fn options(shard: Option<(u32, u32)>, workers: Option<usize>, retry: bool) -> PyResult<Options> {
    let wrong = || PyValueError::new_err("shard must be (k, n) with k from 1 to n");
    let shard = shard.map(|(k, n)| Shard::new(k, n).ok_or_else(wrong)).transpose()?;
    if workers.is_some_and(|workers| !(1..=MOST_WORKERS).contains(&workers)) {
        return Err(PyValueError::new_err(format!("workers must be from 1 to {MOST_WORKERS}")));
    }
    let usual = Options::default();
    Ok(Options { workers: workers.unwrap_or(usual.workers), shard, retry })
}

/// A key and what it takes, as an entry of `[[vary]]`.
fn vary(key: &Bound<'_, PyAny>, values: &Bound<'_, PyAny>) -> PyResult<toml::Value> {
    let key: String = key.extract().map_err(|_| PyTypeError::new_err("set: a key must be a str"))?;
    let mut entry = toml::Table::new();
    match to_value(values, &key)? {
        toml::Value::Table(table) => entry = table,
        list @ toml::Value::Array(_) => drop(entry.insert("values".into(), list)),
        one => drop(entry.insert("fixed".into(), one)),
    }
    entry.entry("key").or_insert(key.into());
    Ok(entry.into())
}

/// A measure as an entry of `[[measure]]`.
fn measure(asked: &Bound<'_, PyAny>, number: usize) -> PyResult<toml::Value> {
    if let Ok(table) = asked.cast::<PyDict>() {
        return Ok(to_table(table)?.into());
    }
    let wrong = |why: String| PyValueError::new_err(format!("measures[{number}]: {why}"));
    let text: String = asked.extract().map_err(|_| {
        PyTypeError::new_err(format!("measures[{number}] must be a kind, as in \"contrast\", or a dictionary"))
    })?;
    let measure = by_hand::measure(&text).map_err(wrong)?;
    toml::Value::try_from(measure).map_err(|error| wrong(error.to_string()))
}

/// Why there is no scene of a point.
pub fn no_scene(error: &NoScene, file: &Path) -> Trouble {
    let words = format!("{}: {error}", file.display());
    match error {
        NoScene::Row { .. } => PyIndexError::new_err(words).into(),
        NoScene::Rejected { .. } => Trouble::scene(Failure::input(words).in_file(file)),
    }
}

fn python<'py>(py: Python<'py>, cell: Option<&Scalar>) -> PyResult<Bound<'py, PyAny>> {
    Ok(match cell {
        None => py.None().into_bound(py),
        Some(Scalar::Text(text)) => text.into_pyobject(py)?.into_any(),
        Some(Scalar::Flag(flag)) => flag.into_pyobject(py)?.to_owned().into_any(),
        Some(Scalar::Number(number)) => number.into_pyobject(py)?.into_any(),
    })
}
