//! Pressure frames of a scanned indenter, their features, and the tissue that they are of.

use crate::json::{json, to_dict};
use crate::scan::Scan;
use crate::trouble::Trouble;
use crate::value::Value;
use crate::watch::watched_by_threads;
use numpy::{PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::{Path, PathBuf};
use tirtouch::estimate::tissue::{self, Question, noisy};
use tirtouch::figure::Figure;
use tirtouch::mechanics::frames::{self, Features, Frame, read_frames};
use tirtouch::pages::frames::{Reading, Source, setup_of};

/// Pressure under an indenter at one position after the other.
#[pyclass(frozen, module = "tirtouch")]
pub struct Frames {
    source: Source,
    /// What was scanned; none of measured frames.
    scan: Option<Py<Scan>>,
}

/// What frames say of the tissue, with intervals of 95 %.
#[pyclass(frozen, module = "tirtouch")]
pub struct Tissue {
    tissue: tissue::Tissue,
}

// What is known and asked are Python's keywords: each is an argument.
#[allow(clippy::too_many_arguments)]
#[pymethods]
impl Frames {
    /// Computes the frames of a scan: finite elements in plane strain, with the inclusions and without. ``progress`` is
    /// as for the methods of Session.
    ///
    /// Raises SceneError for a scan that cannot be computed, TirtouchError for a position that does not converge,
    /// Stopped.
    #[staticmethod]
    #[pyo3(signature = (scan, *, progress = None))]
    fn scan(scan: &Bound<'_, Scan>, progress: Option<&Bound<'_, PyAny>>) -> Result<Self, Trouble> {
        let known = scan.get();
        let of_scan = |error| Trouble::of_scan(error, &known.file);
        let source = watched_by_threads(scan.py(), progress, |observe| {
            let setup = setup_of(&known.loaded).map_err(of_scan)?;
            Source::scan((*known.loaded).clone(), setup, 0.0, observe).map_err(of_scan)
        })?;
        Ok(Self { source, scan: Some(scan.clone().unbind()) })
    }

    /// Measured frames. ``positions_mm``: ascending positions of the indenter's axis, 0 over the inclusion, of shape
    /// (frames,). ``x_mm``: ascending places along the indenter, 0 at its axis, of shape (places,). ``pressure_kpa``:
    /// of shape (frames, places), 0 where there is no contact.
    ///
    /// Raises ValueError for arrays that do not belong together.
    #[staticmethod]
    fn measured(
        positions_mm: PyReadonlyArray1<'_, f64>,
        x_mm: PyReadonlyArray1<'_, f64>,
        pressure_kpa: PyReadonlyArray2<'_, f64>,
    ) -> PyResult<Self> {
        let (positions, x, pressure) = (positions_mm.as_array(), x_mm.as_array(), pressure_kpa.as_array());
        if pressure.dim() != (positions.len(), x.len()) {
            let (rows, columns) = pressure.dim();
            let message =
                format!("pressure_kpa must be of shape ({}, {}), is of ({rows}, {columns})", positions.len(), x.len());
            return Err(PyValueError::new_err(message));
        }
        let rows = positions.iter().zip(pressure.outer_iter());
        let frame = |(position_mm, pressure): (&f64, numpy::ndarray::ArrayView1<'_, f64>)| Frame {
            position_mm: *position_mm,
            x_mm: x.to_vec(),
            pressure_kpa: pressure.to_vec(),
        };
        let frames = frames::Frames::new(rows.map(frame).collect());
        let frames = frames.map_err(|error| PyValueError::new_err(error.to_string()))?;
        Ok(Self { source: Source::measured("measured".into(), frames, Path::new("arrays")), scan: None })
    }

    /// Measured frames of a CSV file with the columns ``position_mm,x_mm,pressure_kpa``.
    ///
    /// Raises TirtouchError, with file and line, where it cannot be used.
    #[staticmethod]
    fn read(py: Python<'_>, path: PathBuf) -> Result<Self, Trouble> {
        let frames = py.detach(|| read_frames(&path)).map_err(tirtouch::failure::Failure::from)?;
        let name = path.file_stem().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
        Ok(Self { source: Source::measured(name, frames, &path), scan: None })
    }

    /// What was scanned; None of measured frames.
    #[getter]
    fn scanned(&self, py: Python<'_>) -> Option<Py<Scan>> {
        self.scan.as_ref().map(|scan| scan.clone_ref(py))
    }

    /// Positions of the indenter's axis, mm: float64 of shape (frames,).
    #[getter]
    fn positions_mm<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_iter(py, self.source.frames.as_slice().iter().map(|frame| frame.position_mm))
    }

    /// Places along the indenter, mm: float64 of shape (places,).
    #[getter]
    fn x_mm<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_iter(py, self.source.frames.as_slice().iter().take(1).flat_map(|frame| frame.x_mm.clone()))
    }

    /// Pressure, kPa: float64 of shape (frames, places), 0 where there is no contact.
    #[getter]
    fn pressure_kpa<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        pressures(py, &self.source.frames)
    }

    /// The same without the inclusions; None of measured frames.
    #[getter]
    fn without_kpa<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray2<f64>>>> {
        self.source.computed.as_ref().map(|computed| pressures(py, &computed.scanned.without)).transpose()
    }

    /// Force on the indenter, N per mm of its length: float64 of shape (frames,); None of measured frames.
    #[getter]
    fn force_n_per_mm<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray1<f64>>> {
        let computed = self.source.computed.as_ref()?;
        Some(PyArray1::from_slice(py, &computed.scanned.force_n_per_mm))
    }

    /// The features of all frames, as float64 of shape (frames,) by the names ``position_mm``, ``peak_kpa``,
    /// ``base_kpa``, ``center_mm``, ``fwhm_mm``, ``eccentricity``; NaN where one is undefined. ``window_mm`` is half
    /// the width of the window of the parabola, if not given the scan's, or the whole contact. Pressures up to
    /// ``noise_kpa`` count as none.
    ///
    /// Raises ValueError for numbers that make no sense.
    #[pyo3(signature = (*, window_mm = None, noise_kpa = 0.0))]
    fn features<'py>(
        &self,
        py: Python<'py>,
        window_mm: Option<f64>,
        noise_kpa: f64,
    ) -> Result<Bound<'py, PyDict>, Trouble> {
        let features = self.reading(window_mm, noise_kpa, None)?.features;
        let columns = PyDict::new(py);
        let positions = features.iter().map(|one| one.position_mm);
        columns.set_item("position_mm", PyArray1::from_iter(py, positions))?;
        type Pick = fn(&Features) -> &Figure;
        let picks: [(&str, Pick); 5] = [
            ("peak_kpa", |one| &one.peak_kpa),
            ("base_kpa", |one| &one.base_kpa),
            ("center_mm", |one| &one.center_mm),
            ("fwhm_mm", |one| &one.fwhm_mm),
            ("eccentricity", |one| &one.eccentricity),
        ];
        for (name, pick) in picks {
            let values = features.iter().map(|one| pick(one).value().unwrap_or(f64::NAN));
            columns.set_item(name, PyArray1::from_iter(py, values))?;
        }
        Ok(columns)
    }

    /// The same with noise added, a share of each pressure; ``seed`` is that of the noise. They count as measured.
    ///
    /// Raises ValueError for a share that makes no sense.
    #[pyo3(signature = (share, *, seed = 0))]
    fn noisy(&self, share: f64, seed: u32) -> PyResult<Self> {
        not_negative("share", share)?;
        let frames = noisy(&self.source.frames, share, seed);
        let frames = frames.map_err(|error| PyValueError::new_err(error.to_string()))?;
        Ok(Self { source: Source::measured(self.source.name.clone(), frames, Path::new("arrays")), scan: None })
    }

    /// The tissue that the frames are of: its thickness and modulus, radius and modulus of one round inclusion.
    /// ``known`` is a scan of what is known beside them: indenter, depth of the press, Poisson's ratios; its own tissue
    /// is the guess from which it is sought. ``by_force`` holds each frame's own force in place of the depth of the
    /// press, ``free_depth`` seeks the depth of the inclusion too. ``seed`` is that of the draws behind the intervals.
    /// The rest is as for ``features``.
    ///
    /// Raises SceneError for a scan that is not one tissue with one round inclusion, TirtouchError for frames that tell
    /// too little, Stopped.
    #[pyo3(signature = (known, *, by_force = false, free_depth = false, window_mm = None, noise_kpa = 0.0, seed = 0,
                        progress = None))]
    fn invert(
        &self,
        known: &Bound<'_, Scan>,
        by_force: bool,
        free_depth: bool,
        window_mm: Option<f64>,
        noise_kpa: f64,
        seed: u32,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> Result<Tissue, Trouble> {
        check(window_mm, noise_kpa)?;
        let (py, file, scene) = (known.py(), &known.get().file, &known.get().loaded);
        let window_mm = window_mm.or(scene.scene.scan.window_mm);
        let question = Question { scene, by_force, free_depth, window_mm, noise_kpa, seed };
        let tissue = watched_by_threads(py, progress, |observe| {
            let found = tissue::invert(&self.source.frames, &question, observe);
            found.map_err(|error| Trouble::of_tissue(error, file))
        })?;
        Ok(Tissue { tissue })
    }

    /// What ``tirtouch frames --json`` says, less what is about files; ``tissue`` is what ``invert`` gave.
    #[pyo3(signature = (*, window_mm = None, noise_kpa = 0.0, tissue = None))]
    fn to_dict<'py>(
        &self,
        py: Python<'py>,
        window_mm: Option<f64>,
        noise_kpa: f64,
        tissue: Option<&Bound<'py, Tissue>>,
    ) -> Result<Bound<'py, PyDict>, Trouble> {
        let tissue = tissue.map(|tissue| tissue.get().tissue.clone());
        Ok(to_dict(py, &self.reading(window_mm, noise_kpa, tissue)?.json())?)
    }

    fn __len__(&self) -> usize {
        self.source.frames.as_slice().len()
    }

    fn __repr__(&self) -> String {
        format!("<tirtouch.Frames of {:?}, {} positions>", self.source.name, self.__len__())
    }
}

impl Frames {
    fn reading(
        &self,
        window_mm: Option<f64>,
        noise_kpa: f64,
        tissue: Option<tissue::Tissue>,
    ) -> Result<Reading, Trouble> {
        check(window_mm, noise_kpa)?;
        let own = self.scan.as_ref().and_then(|scan| scan.get().loaded.scene.scan.window_mm);
        let window_mm = window_mm.or(own);
        let features = self.source.features(window_mm, noise_kpa);
        let features = features.map_err(|error| Trouble::input(error.to_string()))?;
        let (source, shown) = (self.source.clone(), self.source.nearest(0.0));
        Ok(Reading { source, features, window_mm, noise_kpa, shown, tissue, noisy: None })
    }
}

fn not_negative(name: &str, number: f64) -> PyResult<()> {
    match number.is_finite() && number >= 0.0 {
        true => Ok(()),
        false => Err(PyValueError::new_err(format!("{name} must be a finite number of 0 or more, is {number}"))),
    }
}

fn check(window_mm: Option<f64>, noise_kpa: f64) -> PyResult<()> {
    if let Some(window_mm) = window_mm.filter(|window_mm| !(window_mm.is_finite() && *window_mm > 0.0)) {
        return Err(PyValueError::new_err(format!("window_mm must be a finite number above 0, is {window_mm}")));
    }
    not_negative("noise_kpa", noise_kpa)
}

fn pressures<'py>(py: Python<'py>, frames: &frames::Frames) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let rows: Vec<Vec<f64>> = frames.as_slice().iter().map(|frame| frame.pressure_kpa.clone()).collect();
    Ok(PyArray2::from_vec2(py, &rows)?)
}

#[pymethods]
impl Tissue {
    /// Thickness of the tissue, mm.
    #[getter]
    fn thickness_mm(&self) -> Value {
        (&self.tissue.thickness_mm).into()
    }

    /// Young's modulus of the tissue, kPa.
    #[getter]
    fn tissue_youngs_kpa(&self) -> Value {
        (&self.tissue.tissue_youngs_kpa).into()
    }

    /// Radius of the inclusion, mm.
    #[getter]
    fn radius_mm(&self) -> Value {
        (&self.tissue.radius_mm).into()
    }

    /// Young's modulus of the inclusion, kPa.
    #[getter]
    fn inclusion_youngs_kpa(&self) -> Value {
        (&self.tissue.inclusion_youngs_kpa).into()
    }

    /// Modulus of the inclusion over that of the tissue.
    #[getter]
    fn contrast(&self) -> Value {
        (&self.tissue.contrast).into()
    }

    /// Depth of the inclusion, to the point that the scan counts to, mm; None where it was not sought.
    #[getter]
    fn depth_mm(&self) -> Option<Value> {
        self.tissue.depth_mm.as_ref().map(Value::from)
    }

    /// Sum of squares of what the fit leaves, in units of its noise, over the degrees of freedom: about 1 where the
    /// frames are of such a tissue.
    #[getter]
    fn reduced_chi_square(&self) -> f64 {
        self.tissue.reduced_chi_square
    }

    /// ``tissue`` of ``tirtouch frames --json``.
    fn to_dict<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyDict>, Trouble> {
        Ok(to_dict(py, &json(&self.tissue)?)?)
    }

    fn __repr__(&self) -> String {
        let [radius, contrast] = [self.radius_mm(), self.contrast()].map(|value| value.said());
        format!("<tirtouch.Tissue radius_mm {radius}, contrast {contrast}>")
    }
}
