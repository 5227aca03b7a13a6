//! What is said of a press.

use super::Failure;
use super::facts::figure;
use crate::mechanics::from_scene::press_setup;
use crate::mechanics::kinematics::Kinematics;
use crate::mechanics::newton::Method;
use crate::mechanics::path::PathError;
use crate::mechanics::press::{Cost, PressError, PressStep, Pressed, Rounding, Setup};
use crate::scene::LoadedScene;
use serde_json::{Value, json};
use std::path::Path;

/// Why there are no mechanics.
pub(super) const NO_MECHANICS: &str = "the scene presses nothing: it prescribes shape and contact, or has neither";

/// What the press of a scene will take, if it has one.
pub(super) fn press_cost(loaded: &LoadedScene, file: &Path) -> Result<Option<Cost>, Failure> {
    let cost = match press_setup(loaded) {
        Err(PressError::NoPress) => return Ok(None),
        setup => setup.and_then(|setup| Cost::of(&setup, None)),
    };
    cost.map(Some).map_err(|error| PressFailure::of(error, file).failure)
}

/// How linear systems are solved, in words.
pub(super) fn method_name(method: Method) -> &'static str {
    match method {
        Method::Direct => "factorisation",
        Method::Multigrid => "multigrid",
    }
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

/// Name of the setting.
pub(super) fn setting(setup: &Setup) -> &'static str {
    match setup.kinematics {
        Kinematics::Axisymmetric => "axisymmetric",
        Kinematics::PlaneStrain => "plane strain",
        Kinematics::ThreeDimensional => "three dimensions",
    }
}

/// What `--json` says of a press: its last load, and all of them under `steps`.
pub(super) fn press_json(pressed: &Pressed) -> Value {
    let quality = pressed.assembly.problem.mesh.quality();
    let estimated = pressed.error_seconds > 0.0;
    let mut object = match pressed.steps.last() {
        Some(step) => step_json(step, estimated),
        None => json!({}),
    };
    object["setting"] = json!(setting(&pressed.setup));
    object["iterations"] = json!(pressed.iterations);
    object["dofs"] = json!(pressed.unknowns);
    object["elements"] = json!(quality.elements);
    object["least_scaled_jacobian"] = json!(quality.least_scaled_jacobian);
    object["seconds"] = json!(pressed.seconds);
    object["error_seconds"] = json!(pressed.error_seconds);
    object["method"] = json!(method_name(pressed.method));
    object["factor_mib"] = json!(pressed.factor_mib);
    object["steps"] = pressed.steps.iter().map(|step| step_json(step, estimated)).collect();
    object
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

/// What `--json` says of a load; `estimated`: whether errors were to be.
fn step_json(step: &PressStep, estimated: bool) -> Value {
    let no_rounding =
        json!({"undefined": "no flat rigid sensor with a rounded edge slides, or its arc takes half of the face"});
    let rounding = |share: Option<f64>| share.map_or(no_rounding.clone(), |share| json!(share));
    let undefined = json!({"undefined": match (estimated, step.force_n) {
        (false, _) => "press.estimate_error is off",
        (true, 0.0) => "nothing is borne, of which an error were a share",
        (true, _) => "the coarser mesh that estimates it does not reach this load",
    }});
    json!({
        "depth_mm": step.depth_mm,
        "slide_mm": step.slide_mm,
        "hold_s": step.hold_s,
        "force_n": step.force_n,
        "peak_pressure_kpa": step.peak_pressure_kpa,
        "pressure_error": step.error.map_or(undefined.clone(), |error| json!(error.rms)),
        "force_error": step.error.map_or(undefined.clone(), |error| json!(error.force)),
        "pressure_rounding": step.error.map_or(undefined.clone(), |error| rounding(error.rounding.map(|r| r.rms))),
        "force_rounding": step.error.map_or(undefined, |error| rounding(error.rounding.map(|r| r.force))),
    })
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
