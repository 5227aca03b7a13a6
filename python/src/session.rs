//! Sessions.

use crate::arguments::{Asked, backend, precision};
use crate::calibration::Given;
use crate::image::{Image, images};
use crate::inspection::Inspection;
use crate::press::{Press, stopped, truth_of};
use crate::run::{Run, Wanted};
use crate::scene::Scene;
use crate::taken::{Taken, baseline, earlier_loads, prepared};
use crate::trouble::Trouble;
use crate::watch::watched;
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use std::sync::{Mutex, MutexGuard, PoisonError, TryLockError};
use std::thread::{self, ThreadId};
use std::time::Duration;
use tirtouch::pages::inspection::Inspection as Seen;
use tirtouch::pipeline;
use tirtouch::progress::Observer;
use tirtouch::trace::{BackendChoice, Precision};

/// Time between two looks whether another thread is done with the session.
const BETWEEN_LOOKS: Duration = Duration::from_millis(20);

/// Devices with the kernels built on them, and the last presses: what stays from image to image. The first image of a
/// kind compiles its kernels; later ones find them.
///
/// A session opens a GPU where there is one, else the CPU tracer (``backend`` ``"auto"``), or what is asked for
/// (``"gpu"``, ``"cpu"``). ``precision`` ``"f64"`` is computed on the CPU only.
///
/// Raises DeviceError where a GPU is asked for and there is none, ValueError for other names.
///
/// Threads may share a session: they use it one after the other. ``progress`` of its methods is a callable
/// ``progress(what: str, done: float)``, called about ten times a second, that stops the work by returning False; True
/// shows a bar if tqdm is installed. Ctrl-C stops the work too.
#[pyclass(frozen, module = "tirtouch")]
pub struct Session {
    session: Mutex<pipeline::Session>,
    /// The thread that uses it.
    user: Mutex<Option<ThreadId>>,
    adapter: String,
    backend: &'static str,
}

/// A session in use.
struct InUse<'a> {
    session: MutexGuard<'a, pipeline::Session>,
    user: &'a Mutex<Option<ThreadId>>,
}

impl Drop for InUse<'_> {
    fn drop(&mut self) {
        *self.user.lock().unwrap_or_else(PoisonError::into_inner) = None;
    }
}

impl Session {
    /// The session once no other thread uses it. Called without Python's lock.
    fn take_up(&self) -> Result<InUse<'_>, Trouble> {
        let me = Some(thread::current().id());
        let user = || self.user.lock().unwrap_or_else(PoisonError::into_inner);
        if *user() == me {
            let message = "the session is at work, and progress was called by it: open another session for more";
            return Err(PyRuntimeError::new_err(message).into());
        }
        let session = loop {
            match self.session.try_lock() {
                Ok(session) => break session,
                Err(TryLockError::Poisoned(session)) => break session.into_inner(),
                Err(TryLockError::WouldBlock) => Python::attach(|py| py.check_signals())?,
            }
            thread::sleep(BETWEEN_LOOKS);
        };
        *user() = me;
        Ok(InUse { session, user: &self.user })
    }

    /// Works on a scene with the session.
    fn work<T: Send>(
        &self,
        scene: &Bound<'_, Scene>,
        progress: Option<&Bound<'_, PyAny>>,
        work: impl FnOnce(&mut pipeline::Session, &Scene, &mut Observer) -> Result<T, Trouble> + Send,
    ) -> Result<T, Trouble> {
        let known = scene.get();
        watched(scene.py(), progress, |observe| work(&mut self.take_up()?.session, known, observe))
    }
}

/// Works with a session that is given, or with one of its own.
pub fn with_session<T: Send>(
    py: Python<'_>,
    session: Option<&Bound<'_, Session>>,
    progress: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&mut pipeline::Session, &mut Observer) -> Result<T, Trouble> + Send,
) -> Result<T, Trouble> {
    let known = session.map(Bound::get);
    watched(py, progress, |observe| match known {
        Some(session) => work(&mut session.take_up()?.session, observe),
        None => work(&mut pipeline::Session::open(BackendChoice::Auto, Precision::F32)?, observe),
    })
}

// The options of a render are Python's keywords: each is an argument.
#[allow(clippy::too_many_arguments)]
#[pymethods]
impl Session {
    // Python shows no docstring of a constructor: what it takes is said of the class.
    #[new]
    #[pyo3(signature = (backend = "auto", precision = "f32"))]
    fn open(py: Python<'_>, backend: &str, precision: &str) -> Result<Self, Trouble> {
        let (choice, precision) = (self::backend(backend)?, self::precision(precision)?);
        let session = py.detach(|| pipeline::Session::open(choice, precision))?;
        let adapter = session.devices().adapter();
        let backend = if session.devices().is_gpu() { "gpu" } else { "cpu" };
        Ok(Self { session: Mutex::new(session), user: Mutex::new(None), adapter, backend })
    }

    /// Name of what traces.
    #[getter]
    fn adapter(&self) -> &str {
        &self.adapter
    }

    /// ``"gpu"`` or ``"cpu"``.
    #[getter]
    fn backend(&self) -> &str {
        self.backend
    }

    /// Presses the scene's phantom against its sensor, or finds that press among the session's last four.
    ///
    /// Raises SceneError for a scene that presses nothing, PressError for a press that stops early.
    #[pyo3(signature = (scene, *, without_inclusions = false, progress = None))]
    fn press(
        &self,
        scene: &Bound<'_, Scene>,
        without_inclusions: bool,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> Result<Press, Trouble> {
        if scene.get().loaded.scene.press.is_none() {
            return Err(Trouble::no_press(&scene.get().file));
        }
        let order = Asked { without_inclusions, ..Asked::default() }.order(scene.get())?;
        let pressed = self.work(scene, progress, |session, scene, observe| {
            let of_press = |error| stopped(error, scene, without_inclusions);
            session.press(&scene.loaded, &order, observe).map_err(of_press)
        })?;
        Press::of(pressed, scene.get(), without_inclusions)
    }

    /// What is understood of a scene, and what a render of it with this session would do; nothing is traced. ``gains``
    /// measures what it gains to leave out what the scene does not need: small images with each piece and without, in
    /// turn, in so many ``rounds`` (2 to 100).
    ///
    /// Raises SceneError for a scene that cannot be used, and for ``gains`` of one that guides no light.
    #[pyo3(signature = (scene, *, gains = false, rounds = 5, progress = None))]
    fn inspect(
        &self,
        scene: &Bound<'_, Scene>,
        gains: bool,
        rounds: u32,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> Result<Inspection, Trouble> {
        if !(2..=100).contains(&rounds) {
            return Err(PyValueError::new_err(format!("rounds must be from 2 to 100, is {rounds}")).into());
        }
        let seen = self.work(scene, progress, |session, scene, observe| {
            let of_scene = |error| Trouble::of_scene(error, &scene.file);
            let seen = Seen::of(scene.loaded.clone(), Ok(session.devices()), observe);
            let mut seen = seen.map_err(of_scene)?;
            if gains {
                seen.measure_gains(session.devices(), rounds, observe).map_err(of_scene)?;
            }
            Ok(seen)
        })?;
        Inspection::of(&seen, scene.get())
    }

    /// The image of a scene: pressed first where it presses, at the last of its loads.
    ///
    /// ``seed`` of all random numbers, ``spp`` camera paths a pixel, ``photons`` and ``integrator`` (``"auto"``,
    /// ``"path"``, ``"splat"``, ``"map"``) are the scene's own if not given. ``target_error`` traces until the relative
    /// error is at most that, ``seconds`` for so long; either replaces ``spp`` and ``photons``. ``baseline`` traces the
    /// same load without inclusions too: ``image.baseline``. ``without_inclusions`` makes that the image itself. Same
    /// seed, same bits, on one adapter with fixed samples.
    ///
    /// Raises SceneError for a scene that cannot be traced, PressError for a press that stops early, DeviceError,
    /// Stopped, and ValueError for arguments that make no sense.
    #[pyo3(signature = (scene, *, seed = None, spp = None, photons = None, integrator = None, target_error = None,
                        seconds = None, baseline = false, without_inclusions = false, progress = None))]
    fn render(
        &self,
        scene: &Bound<'_, Scene>,
        seed: Option<u32>,
        spp: Option<u32>,
        photons: Option<u64>,
        integrator: Option<String>,
        target_error: Option<f64>,
        seconds: Option<f64>,
        baseline: bool,
        without_inclusions: bool,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> Result<Py<Image>, Trouble> {
        let asked = Asked { seed, spp, photons, integrator, target_error, seconds, without_inclusions };
        let order = asked.order(scene.get())?;
        let (image, other) = self.work(scene, progress, |session, scene, observe| {
            let prepared = prepared(session, scene, &order, observe)?;
            let other = match baseline {
                true => Some(self::baseline(session, scene, &prepared, observe)?),
                false => None,
            };
            Ok((Taken::take(session, prepared, scene, observe)?, other))
        })?;
        let (py, truth) = (scene.py(), truth_of(scene.get(), without_inclusions)?);
        let known = || scene.clone().unbind();
        let other = match other {
            Some(other) => Some(Py::new(py, Image::new(other, known(), truth_of(scene.get(), true)?, None))?),
            None => None,
        };
        Ok(Py::new(py, Image::new(image, known(), truth, other))?)
    }

    /// The images of all loads of a scene's press, in their order; of a scene that presses nothing, its one image.
    /// Arguments are those of ``render``.
    ///
    /// Raises what ``render`` does.
    #[pyo3(signature = (scene, *, seed = None, spp = None, photons = None, integrator = None, target_error = None,
                        seconds = None, without_inclusions = false, progress = None))]
    fn render_loads(
        &self,
        scene: &Bound<'_, Scene>,
        seed: Option<u32>,
        spp: Option<u32>,
        photons: Option<u64>,
        integrator: Option<String>,
        target_error: Option<f64>,
        seconds: Option<f64>,
        without_inclusions: bool,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> Result<Vec<Py<Image>>, Trouble> {
        let asked = Asked { seed, spp, photons, integrator, target_error, seconds, without_inclusions };
        let order = asked.order(scene.get())?;
        let taken = self.work(scene, progress, |session, scene, observe| {
            let prepared = prepared(session, scene, &order, observe)?;
            let mut taken = earlier_loads(session, scene, &prepared, observe)?;
            taken.push(Taken::take(session, prepared, scene, observe)?);
            Ok(taken)
        })?;
        Ok(images(taken, scene, &truth_of(scene.get(), without_inclusions)?, None)?)
    }

    /// The whole way: press, images of all loads, the paper's figures of the last, and what all say of the inclusion.
    ///
    /// Arguments are those of ``render``. ``subtract_baseline`` reads the last frame less the one without inclusions.
    /// ``threshold`` is as for ``Image.read``. ``calibration`` is a Calibration, or the file of one; if not given,
    /// the calibration that comes with the program is used where it suits the scene.
    ///
    /// Raises what ``render`` does.
    #[pyo3(signature = (scene, *, seed = None, spp = None, photons = None, integrator = None, target_error = None,
                        seconds = None, subtract_baseline = false, without_inclusions = false, threshold = None,
                        calibration = None, progress = None))]
    fn run(
        &self,
        scene: &Bound<'_, Scene>,
        seed: Option<u32>,
        spp: Option<u32>,
        photons: Option<u64>,
        integrator: Option<String>,
        target_error: Option<f64>,
        seconds: Option<f64>,
        subtract_baseline: bool,
        without_inclusions: bool,
        threshold: Option<&Bound<'_, PyAny>>,
        calibration: Option<Given>,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> Result<Run, Trouble> {
        let asked = Asked { seed, spp, photons, integrator, target_error, seconds, without_inclusions };
        let wanted = Wanted::new(asked, scene.get(), threshold, calibration, subtract_baseline)?;
        let whole = self.work(scene, progress, |session, scene, observe| wanted.run(session, scene, observe))?;
        whole.into_run(scene, without_inclusions)
    }

    fn __repr__(&self) -> String {
        format!("<tirtouch.Session on {}>", self.adapter)
    }
}
