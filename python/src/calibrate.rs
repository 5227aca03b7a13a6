//! Learns calibrations.

use crate::calibration::Calibration;
use crate::json::to_table;
use crate::session::{Session, with_session};
use crate::sweep::options;
use crate::trouble::Trouble;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::{Path, PathBuf};
use tirtouch::calibrate::{CalibrationFile, FrameModel};
use tirtouch::progress::Observer;
use tirtouch::sweep::{Options, Parts, Status, Sweep, SweepError, run};

/// Name of the file that is learnt, as the command line has it.
const FILE: &str = "calibration.json";

/// Learns what a sensor's frames say of an inclusion, from phantoms that sweeps press and trace (docs/CLI.md).
///
/// ``sweeps``: a calibration file, or a dictionary of what stands in its ``[calibrate]``: ``design`` and, where they
/// are wanted, ``leds`` and ``empty``, each a sweep file or the folder of a sweep. Sweep files are computed in folders
/// of ``folder``, as by ``Sweep.run``, and gone on with where these are there. ``folder`` gets calibration.json too.
/// ``session``, ``workers`` and ``progress`` are as for ``Sweep.run``.
///
/// Raises SceneError for files that cannot be used, TirtouchError for sweeps that nothing can be learnt from,
/// DeviceError and Stopped.
#[pyfunction]
#[pyo3(signature = (sweeps, folder, *, session = None, workers = None, progress = None))]
pub fn calibrate(
    py: Python<'_>,
    sweeps: &Bound<'_, PyAny>,
    folder: PathBuf,
    session: Option<&Bound<'_, Session>>,
    workers: Option<usize>,
    progress: Option<&Bound<'_, PyAny>>,
) -> Result<Calibration, Trouble> {
    let parts = file_of(sweeps)?.calibrate;
    let options = options(None, workers, false)?;
    with_session(py, session, progress, |session, observe| {
        let folders = parts
            .folders(&mut Parts::new(&folder, &mut |sweep, place| compute(sweep, place, session, options, observe)))?;
        if !folders.is_whole {
            let message = format!("{}: not all points are there yet: others compute them", folder.display());
            return Err(Trouble::input(message));
        }
        let trainings = folders.read()?;
        let stopped = || Trouble::of_sweep(SweepError::Stopped, &folder);
        let file = folder.join(FILE);
        trainings.learn(observe)?.ok_or_else(stopped)?.write(&file)?;
        // What is written has less digits than what was learnt.
        Ok(FrameModel::load(&file)?.into())
    })
}

/// Computes what a folder of a sweep lacks.
///
/// # Errors
/// What the library says.
fn compute(
    sweep: &Sweep,
    folder: &Path,
    session: &tirtouch::pipeline::Session,
    options: Options,
    observe: &mut Observer,
) -> Result<Status, Trouble> {
    let records = sweep.enter(folder, false, folder.is_dir())?;
    run(sweep, &records, session, options, observe).map_err(|error| Trouble::of_sweep(error, folder))?;
    Ok(Status::of(sweep, &records))
}

/// The calibration file that is named, or that a dictionary makes.
fn file_of(sweeps: &Bound<'_, PyAny>) -> Result<CalibrationFile, Trouble> {
    if let Ok(table) = sweeps.cast::<PyDict>() {
        let mut file = toml::Table::new();
        file.insert("calibrate".into(), paths(table)?.into());
        let text = toml::to_string(&file).map_err(|error| Trouble::input(error.to_string()))?;
        return Ok(CalibrationFile::parse(&text, Path::new("calibration.toml"))?);
    }
    match sweeps.extract::<PathBuf>() {
        Ok(file) => Ok(CalibrationFile::load(&file)?),
        Err(_) => Err(PyTypeError::new_err("sweeps must be the path of a calibration file, or a dictionary").into()),
    }
}

/// A dictionary whose values may be paths.
fn paths(table: &Bound<'_, PyDict>) -> PyResult<toml::Table> {
    let plain = table.copy()?;
    for (key, value) in table {
        if let Ok(path) = value.extract::<PathBuf>() {
            plain.set_item(key, path.to_string_lossy())?;
        }
    }
    to_table(&plain)
}
