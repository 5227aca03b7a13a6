//! Runs a press through its loads.

use super::pressed::{PressStep, Pressed};
use super::ready::Ready;
use super::{Load, PressError, Setup, error_estimate};
use crate::mechanics::newton::LinearSolver;
use crate::progress::{Observer, Stage};
use std::time::Instant;

/// What a press computes beside the press itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct PressSettings {
    /// A second press on a coarser mesh estimates the error.
    pub estimate_error: bool,
    /// How linear systems are solved; if not given, as costs less.
    pub method: Option<LinearSolver>,
}

/// Presses. `observe` hears how far it is and may stop it.
///
/// # Errors
/// [`PressError`]; `Stopped` holds the loads that were reached.
pub fn press(setup: &Setup, settings: PressSettings, observe: &mut Observer) -> Result<Pressed, PressError> {
    press_near(setup, None, settings, observe)
}

/// As [`press`], and starts at each depth from what another press found there, that of a phantom like it, as far as
/// there is one state in balance (docs/decisions/warm-starts.md). The state is the same to rounding.
///
/// # Errors
/// As [`press`].
pub fn press_near(
    setup: &Setup,
    near: Option<&Pressed>,
    settings: PressSettings,
    observe: &mut Observer,
) -> Result<Pressed, PressError> {
    let ready = Ready::new(setup, settings.method)?;
    let what = if settings.estimate_error { "estimating the error" } else { "pressing on a coarser mesh" };
    let start = Instant::now();
    // Faces that slide first find each other on a coarser mesh: what touches on another phantom is too far from what
    // does on this one. What is to estimate the error may come first too, except where the way decides between states.
    let estimates = settings.estimate_error && near.is_none() && setup.one_state_to_mm() == f64::INFINITY;
    let leads = ready.takes_guesses() && (ready.slides() || estimates);
    let first = if leads { 0.25 } else { 0.0 };
    let mut coarse = if leads {
        coarser(setup, near, settings.method, &mut |done| observe(Stage { done: first * done, what }))?
    } else {
        None
    };
    let before = start.elapsed().as_secs_f64();
    let last = if settings.estimate_error && !leads { 0.25 } else { 0.0 };
    let share = 1.0 - first - last;
    let mut pressed = ready
        .press(coarse.as_ref().or(near), &mut |done| observe(Stage { done: first + share * done, what: "pressing" }))?;
    if !settings.estimate_error {
        pressed.seconds += before;
        return Ok(pressed);
    }
    let start = Instant::now();
    let asked = |step: &PressStep| pressed.steps.iter().any(|asked| asked.depth_mm == step.depth_mm);
    coarse.iter_mut().for_each(|coarse| coarse.steps.retain(asked));
    let observe = &mut |done| observe(Stage { done: first + share + last * done, what });
    match error_estimate::estimate(&mut pressed, coarse, settings.method, observe) {
        Err(PressError::Stopped { cause, .. }) => {
            return Err(PressError::Stopped { cause, reached: Box::new(pressed) });
        }
        // The press stands.
        Err(PressError::Mesh(why)) => pressed.unestimated = Some(why.to_string()),
        done => done?,
    }
    pressed.error_seconds = before + start.elapsed().as_secs_f64();
    Ok(pressed)
}

/// The press on the next coarser mesh, read halfway to far depths too, as far as it comes, if
/// there is such a mesh; `near` is for it.
fn coarser(
    setup: &Setup,
    near: Option<&Pressed>,
    method: Option<LinearSolver>,
    observe: &mut dyn FnMut(f64) -> bool,
) -> Result<Option<Pressed>, PressError> {
    let ready = Ready::new(&halfway(&setup.coarsened()), method);
    ready.map_or(Ok(None), |ready| ready.press_as_far(near, observe).map(Some))
}

/// A press that is also read halfway to each depth that lies more than a millimetre beyond the one before.
fn halfway(setup: &Setup) -> Setup {
    let Load::Depths(depths) = &setup.load else { return setup.clone() };
    let starts = std::iter::once(0.0).chain(depths.iter().copied());
    let halves =
        starts.zip(depths).filter(|(start, end)| *end - start > LONG_MM).map(|(start, end)| 0.5 * (start + end));
    let mut all: Vec<f64> = halves.chain(depths.iter().copied()).collect();
    all.sort_by(f64::total_cmp);
    Setup { load: Load::Depths(all), ..setup.clone() }
}

const LONG_MM: f64 = 1.0;
