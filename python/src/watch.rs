//! Work that Python hears of, and can stop.

use crate::trouble::Trouble;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};
use tirtouch::progress::{Observer, Stage};

/// Time between two calls into Python: often enough for Ctrl-C, too seldom to cost anything.
const BETWEEN: Duration = Duration::from_millis(100);

/// Time between two looks at work that another thread does.
const LOOK: Duration = Duration::from_millis(10);

/// Does work without Python's lock. `progress` is a callable, True for a bar, or None.
///
/// # Errors
/// What the work says; what `progress` or a signal raises.
pub fn watched<T: Send>(
    py: Python<'_>,
    progress: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&mut Observer) -> Result<T, Trouble> + Send,
) -> Result<T, Trouble> {
    let mut watch = Watch::new(py, progress)?;
    let done = py.detach(|| work(&mut |stage| watch.hears(stage)));
    watch.end(py)?;
    done
}

/// The same of work that tells of itself from any thread. It is done by a thread of its own, so that signals are heard.
///
/// # Errors
/// As [`watched`].
pub fn watched_by_threads<T: Send>(
    py: Python<'_>,
    progress: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&(dyn Fn(Stage) -> bool + Sync)) -> Result<T, Trouble> + Send,
) -> Result<T, Trouble> {
    watched(py, progress, |observe| {
        let (told, stop) = (Mutex::new((0.0, String::new())), AtomicBool::new(false));
        let latest = || told.lock().unwrap_or_else(PoisonError::into_inner);
        thread::scope(|scope| {
            let worker = scope.spawn(|| {
                work(&|stage| {
                    *latest() = (stage.done, stage.what.to_owned());
                    !stop.load(Ordering::Relaxed)
                })
            });
            while !worker.is_finished() {
                let (done, what) = latest().clone();
                if !what.is_empty() && !observe(Stage { done, what: &what }) {
                    stop.store(true, Ordering::Relaxed);
                }
                thread::sleep(LOOK);
            }
            worker.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
        })
    })
}

struct Watch {
    call: Option<Py<PyAny>>,
    /// Whether what is called is a bar of ours.
    is_bar: bool,
    last: Option<Instant>,
    raised: Option<PyErr>,
}

impl Watch {
    fn new(py: Python<'_>, progress: Option<&Bound<'_, PyAny>>) -> PyResult<Self> {
        let (call, is_bar) = match progress {
            None => (None, false),
            Some(asked) => match asked.extract::<bool>() {
                Ok(true) => (Some(py.import("tirtouch._progress")?.getattr("Bar")?.call0()?.unbind()), true),
                Ok(false) => (None, false),
                Err(_) if asked.is_callable() => (Some(asked.clone().unbind()), false),
                Err(_) => return Err(PyTypeError::new_err("progress must be a callable, True, False or None")),
            },
        };
        Ok(Self { call, is_bar, last: None, raised: None })
    }

    /// Whether the work shall go on. The first stage is always told.
    fn hears(&mut self, stage: Stage<'_>) -> bool {
        if self.raised.is_some() || self.last.is_some_and(|last| last.elapsed() < BETWEEN) {
            return self.raised.is_none();
        }
        let heard = Python::attach(|py| {
            py.check_signals()?;
            match &self.call {
                Some(call) => {
                    Ok(!call.bind(py).call1((stage.what, stage.done))?.is(pyo3::types::PyBool::new(py, false)))
                }
                None => Ok(true),
            }
        });
        self.last = Some(Instant::now());
        heard.unwrap_or_else(|error| {
            self.raised = Some(error);
            false
        })
    }

    /// What was raised on the way comes before what the work says of it.
    fn end(self, py: Python<'_>) -> PyResult<()> {
        if let (true, Some(bar)) = (self.is_bar, &self.call) {
            bar.bind(py).call_method0("close")?;
        }
        self.raised.map_or(Ok(()), Err)
    }
}
