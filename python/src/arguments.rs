//! What is asked of a render, checked as the command line does.

use crate::scene::Scene;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use tirtouch::camera::top_grey;
use tirtouch::estimate::Threshold;
use tirtouch::pipeline::Order;
use tirtouch::trace::{BackendChoice, Precision, Settings};

/// How images are wanted; what is None is the scene's own.
#[derive(Default)]
pub struct Asked {
    pub seed: Option<u32>,
    pub spp: Option<u32>,
    pub photons: Option<u64>,
    pub integrator: Option<String>,
    pub target_error: Option<f64>,
    pub seconds: Option<f64>,
    pub without_inclusions: bool,
}

impl Asked {
    /// # Errors
    /// `ValueError` for numbers that make no sense, alone or together.
    pub fn order(&self, scene: &Scene) -> PyResult<Order> {
        self.check(scene)?;
        let own = &scene.loaded.scene.render;
        let integrator = match &self.integrator {
            Some(name) => {
                name.parse().map_err(|why| PyValueError::new_err(format!("integrator: {why}, is {name:?}")))?
            }
            None => own.integrator,
        };
        let settings = Settings {
            integrator,
            spp: self.spp.unwrap_or(own.spp),
            photons: self.photons.or(own.photons),
            seconds: self.seconds,
            target_error: self.target_error,
            seed: self.seed.unwrap_or(own.seed),
        };
        Ok(Order { settings, without_inclusions: self.without_inclusions, ..Order::of(&scene.loaded.scene) })
    }

    fn check(&self, scene: &Scene) -> PyResult<()> {
        let positive = |name: &str, number: Option<f64>| match number {
            Some(number) if !(number.is_finite() && number > 0.0) => {
                Err(PyValueError::new_err(format!("{name} must be a finite number above 0, is {number}")))
            }
            _ => Ok(()),
        };
        positive("spp", self.spp.map(f64::from))?;
        positive("photons", self.photons.map(|photons| photons as f64))?;
        positive("target_error", self.target_error)?;
        positive("seconds", self.seconds)?;
        let samples = self.spp.is_some() || self.photons.is_some();
        let budgets = [self.target_error, self.seconds].iter().flatten().count();
        if budgets + usize::from(samples) > 1 {
            return Err(PyValueError::new_err("give one of seconds, target_error, and fixed samples (spp, photons)"));
        }
        if self.without_inclusions && scene.loaded.scene.press.is_none() {
            return Err(PyValueError::new_err("without_inclusions needs a scene with a [press]"));
        }
        Ok(())
    }
}

/// A choice by its name.
///
/// # Errors
/// `ValueError` for another name.
pub fn backend(name: &str) -> PyResult<BackendChoice> {
    name.parse().map_err(|why| PyValueError::new_err(format!("backend {name:?}: {why}")))
}

/// A choice by its name.
///
/// # Errors
/// `ValueError` for another name.
pub fn precision(name: &str) -> PyResult<Precision> {
    name.parse().map_err(|why| PyValueError::new_err(format!("precision {name:?}: {why}")))
}

/// A threshold in grey levels of a camera of so many bits: a number of levels, a text like `2%`, or the paper's.
///
/// # Errors
/// `ValueError` for a number that makes no sense, `TypeError` for something else.
pub fn threshold_grey(asked: Option<&Bound<'_, PyAny>>, bit_depth: u32) -> PyResult<f64> {
    let text = match asked {
        None => return Ok(Threshold::default().of(f64::from(top_grey(bit_depth)))),
        Some(asked) => match (asked.extract::<f64>(), asked.extract::<String>()) {
            (Ok(levels), _) => levels.to_string(),
            (_, Ok(text)) => text,
            _ => return Err(PyTypeError::new_err("threshold must be a number of grey levels, or a text like \"2%\"")),
        },
    };
    let threshold = text.parse::<Threshold>().map_err(|why| PyValueError::new_err(format!("threshold: {why}")))?;
    Ok(threshold.of(f64::from(top_grey(bit_depth))))
}
