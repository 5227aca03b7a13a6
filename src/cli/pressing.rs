//! What is said of a press.

use super::Failure;
use super::facts::figure;
use crate::mechanics::from_scene::press_setup;
use crate::mechanics::path::PathError;
use crate::mechanics::press::{Cost, PressError, PressStep, Pressed, Rounding};
use crate::pipeline::{method_name, setting};
use crate::scene::LoadedScene;
use std::path::Path;

/// What the press of a scene will take, if it has one.
pub(super) fn press_cost(loaded: &LoadedScene, file: &Path) -> Result<Option<Cost>, Failure> {
    let cost = match press_setup(loaded) {
        Err(PressError::NoPress) => return Ok(None),
        setup => setup.and_then(|setup| Cost::of(&setup, None)),
    };
    cost.map(Some).map_err(|error| PressFailure::of(error, file).failure)
}

/// A press that failed, and what it reached.
pub(super) struct PressFailure {
    pub failure: Failure,
    pub reached: Option<Box<Pressed>>,
}

impl PressFailure {
    /// What a scene's press says, with the scene's file.
    pub fn of(error: PressError, file: &Path) -> Self {
        let words = format!("{}: {error}", file.display());
        let (failure, reached) = match error {
            PressError::Stopped { cause: PathError::Stopped, .. } => {
                return Self { failure: Failure::cancelled(), reached: None };
            }
            PressError::Stopped { reached, .. } => (Failure::failed(words), Some(reached)),
            _ => (Failure::input(words), None),
        };
        Self { failure: failure.in_file(file), reached }
    }
}

/// A load in words.
pub(super) fn load_name(step: &PressStep) -> String {
    let mut name = format!("{} mm", figure(step.depth_mm));
    let [x, y] = step.slide_mm;
    match [x != 0.0, y != 0.0] {
        [false, false] => {}
        [true, false] => name += &format!(", slid by {} mm", figure(x)),
        [false, true] => name += &format!(", slid by {} mm along y", figure(y)),
        [true, true] => name += &format!(", slid by {} and {} mm", figure(x), figure(y)),
    }
    if step.hold_s > 0.0 {
        name += &format!(", held {} s", figure(step.hold_s));
    }
    name
}

/// A press in words.
pub(super) fn press_rows(pressed: &Pressed) -> Vec<(String, String)> {
    let percent = |share: f64| figure(100.0 * share);
    let row = |name: &str, value: String| (name.to_owned(), value);
    let mut rows = vec![row(
        "mechanics",
        format!(
            "{}, {} unknowns, {} iterations, {} s and {} s for the error; {} of {} MiB",
            setting(&pressed.setup),
            pressed.unknowns,
            pressed.iterations,
            figure(pressed.seconds),
            figure(pressed.error_seconds),
            method_name(pressed.method),
            figure(pressed.factor_mib)
        ),
    )];
    rows.extend(pressed.steps.iter().map(|step| {
        let error = match step.error {
            Some(error) => {
                let sharp = |rounding: Rounding| {
                    format!(
                        "; a sharp edge changes them by up to {} and {} %",
                        percent(rounding.rms),
                        percent(rounding.force)
                    )
                };
                let sharp = error.rounding.map_or(String::new(), sharp);
                format!(
                    " (pressure within {} % rms, force within {} %{sharp})",
                    percent(error.rms),
                    percent(error.force)
                )
            }
            None => String::new(),
        };
        let force = format!("{} N, peak pressure {} kPa{error}", figure(step.force_n), figure(step.peak_pressure_kpa));
        row(&load_name(step), force)
    }));
    rows
}
