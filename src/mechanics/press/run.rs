//! Runs a press through its loads.

use super::carry::Guesses;
use super::load::{Reached, march};
use super::{
    Assembly, ContactPoint, Cost, Load, Pose, PressError, PressureError, SensorBody, Setup, contact_points,
    error_estimate,
};
use crate::mechanics::newton::{Method, Solver};
use crate::mechanics::path::PathError;
use crate::mechanics::problem::State;
use crate::progress::{Observer, Stage};
use std::time::{Duration, Instant};

/// What a press computes beside the press itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct PressSettings {
    /// A second press on a coarser mesh estimates the error.
    pub estimate_error: bool,
    /// How linear systems are solved; if not given, as costs less.
    pub method: Option<Method>,
}

/// A press at one of the asked loads.
#[derive(Debug, Clone)]
pub struct PressStep {
    /// Motion of the phantom's base, mm.
    pub depth_mm: f64,
    /// Its motion along x and y, mm.
    pub slide_mm: [f64; 2],
    /// Time for which it was held before it was read, s.
    pub hold_s: f64,
    /// Total force along z, N.
    pub force_n: f64,
    /// Largest pressure over 0.8 of the footprint's radius, kPa: the edge of a tied contact is singular. Under an
    /// indenter over all of the face.
    pub peak_pressure_kpa: f64,
    /// Nodes of the touched face, by x, then y.
    pub points: Vec<ContactPoint>,
    /// The whole state.
    pub state: State,
    /// Error of the pressure, where it was estimated.
    pub error: Option<PressureError>,
}

/// A press at all asked loads that it reached.
#[derive(Debug, Clone)]
pub struct Pressed {
    /// Description.
    pub setup: Setup,
    /// The problem.
    pub assembly: Assembly,
    /// Asked loads, ascending.
    pub steps: Vec<PressStep>,
    /// Displacement unknowns.
    pub unknowns: usize,
    /// Newton iterations.
    pub iterations: usize,
    /// Cycles of multigrid.
    pub cycles: usize,
    /// Seconds, without the error estimate.
    pub seconds: f64,
    /// Seconds of the error estimate.
    pub error_seconds: f64,
    /// How linear systems were solved.
    pub method: Method,
    /// Memory of the matrix's factor, or of multigrid's levels, MiB.
    pub factor_mib: f64,
}

/// Share of the footprint's radius over which pressures are judged.
pub const JUDGED_SHARE: f64 = 0.8;

/// Presses. `observe` hears how far it is and may stop it.
///
/// # Errors
/// [`PressError`]; `Stopped` holds the loads that were reached.
pub fn press(setup: &Setup, settings: PressSettings, observe: &mut Observer) -> Result<Pressed, PressError> {
    press_near(setup, None, settings, observe)
}

/// As [`press`], and starts at each depth from what another press found there, that of a phantom like it: half as many
/// iterations, a third or fewer where the two are much alike. The state is as well balanced; where a deep press has
/// several, in which the elements beside the sensor's wall fold differently, it may be another one
/// (docs/decisions/warm-starts.md).
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
    // does on this one. What is to estimate the error may come first too.
    let slides = ready.assembly.problem.slides();
    let leads = ready.takes_guesses() && (slides || (settings.estimate_error && near.is_none()));
    let first = if leads { 0.25 } else { 0.0 };
    let mut coarse = if leads {
        coarser(setup, near, settings, &mut |done| observe(Stage { done: first * done, what }))?
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
    error_estimate::estimate(&mut pressed, coarse, settings.method, observe)?;
    pressed.error_seconds = before + start.elapsed().as_secs_f64();
    Ok(pressed)
}

/// The press on the next coarser mesh, read halfway to far depths too, as far as it comes; `near` is for it. Where
/// there is no such mesh an error cannot be estimated.
fn coarser(
    setup: &Setup,
    near: Option<&Pressed>,
    settings: PressSettings,
    observe: &mut dyn FnMut(f64) -> bool,
) -> Result<Option<Pressed>, PressError> {
    let ready = match Ready::new(&halfway(&setup.coarsened()), settings.method) {
        Err(error) if settings.estimate_error => return Err(error),
        Err(_) => return Ok(None),
        Ok(ready) => ready,
    };
    match ready.press(near, observe) {
        Err(stopped @ PressError::Stopped { cause: PathError::Stopped, .. }) => Err(stopped),
        Err(PressError::Stopped { reached, .. }) => Ok(Some(*reached)),
        pressed => pressed.map(Some),
    }
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

/// A press that was found to fit into memory.
pub(super) struct Ready {
    setup: Setup,
    assembly: Assembly,
    method: Method,
    meshing: Duration,
}

impl Ready {
    pub fn new(setup: &Setup, method: Option<Method>) -> Result<Self, PressError> {
        let start = Instant::now();
        let assembly = Assembly::new(setup)?;
        let cost = Cost::of_problem(setup, &assembly.problem, method);
        cost.check(setup)?;
        Ok(Self { setup: setup.clone(), assembly, method: cost.method, meshing: start.elapsed() })
    }

    /// Whether a state depends on its depth alone, not on the way there.
    fn takes_guesses(&self) -> bool {
        let problem = &self.assembly.problem;
        let elastic = problem.materials.iter().all(|material| material.relaxation.is_empty());
        matches!(self.setup.load, Load::Depths(_)) && elastic && !problem.rubs()
    }

    /// One press on one mesh; `near` has guesses for it.
    pub fn press(self, near: Option<&Pressed>, observe: &mut dyn FnMut(f64) -> bool) -> Result<Pressed, PressError> {
        let start = Instant::now();
        let near = near.filter(|_| self.takes_guesses());
        let Self { setup, assembly, method, meshing } = self;
        let guesses = near.map_or(Guesses::NONE, |near| Guesses::of(near, &assembly));
        let mut solver = Solver::new(&assembly.problem, method);
        let mut steps = Vec::new();
        let mut reach = |reached| steps.push(step(&setup, &assembly, reached));
        let outcome = march(&mut solver, &setup, &guesses, observe, &mut reach);
        without_rounding(&mut steps);
        let (iterations, cycles, factor_mib) =
            (solver.iterations, solver.cycles, solver.factor_bytes() as f64 / f64::from(1 << 20));
        drop(solver);
        let pressed = Pressed {
            unknowns: assembly.problem.unknowns(),
            setup,
            assembly,
            steps,
            iterations,
            cycles,
            seconds: (meshing + start.elapsed()).as_secs_f64(),
            error_seconds: 0.0,
            method,
            factor_mib,
        };
        match outcome {
            Ok(()) => Ok(pressed),
            Err(cause) => Err(PressError::Stopped { cause, reached: Box::new(pressed) }),
        }
    }
}

/// Balance, as a share of what is in balance.
const BALANCE: f64 = 1e-9;

/// What a lifted phantom still seems to bear is the rounding of what it bore.
fn without_rounding(steps: &mut [PressStep]) {
    let largest = |of: fn(&PressStep) -> f64| steps.iter().map(|step| of(step).abs()).fold(0.0, f64::max);
    let (force, peak) = (largest(|step| step.force_n), largest(|step| step.peak_pressure_kpa));
    for step in steps {
        step.force_n = if step.force_n.abs() > BALANCE * force { step.force_n } else { 0.0 };
        step.peak_pressure_kpa = if step.peak_pressure_kpa > BALANCE * peak { step.peak_pressure_kpa } else { 0.0 };
    }
}

fn step(setup: &Setup, assembly: &Assembly, Reached { state, pose, force_n }: Reached) -> PressStep {
    let points = contact_points(&assembly.problem, 0, &state);
    let judged = points.iter().filter(|point| is_judged(setup, point));
    let peak_pressure_kpa = judged.map(|point| point.pressure_kpa).fold(0.0, f64::max);
    let Pose { depth_mm, slide_mm, hold_s } = pose;
    PressStep { depth_mm, slide_mm, hold_s, force_n, peak_pressure_kpa, points, state, error: None }
}

/// Whether a point lies within the part of the face over which pressures are judged: an indenter has no singular edge,
/// so all of its contact is.
pub fn is_judged(setup: &Setup, point: &ContactPoint) -> bool {
    if matches!(setup.sensor, SensorBody::Indenter(_)) {
        return true;
    }
    let [x, y, _] = point.reference_mm;
    let across = if setup.kinematics.dim() == 3 { x.hypot(y) } else { x.abs() };
    across <= JUDGED_SHARE * setup.reach_mm()
}
