//! Runs a press through its loads.

use super::load::{Reached, march};
use super::{
    Assembly, ContactPoint, Cost, Pose, PressError, PressureError, SensorBody, Setup, contact_points, error_estimate,
};
use crate::mechanics::newton::{Method, Solver};
use crate::mechanics::problem::State;
use std::time::Instant;

/// What a press computes beside the press itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct PressSettings {
    /// A second press on a coarser mesh estimates the error.
    pub estimate_error: bool,
    /// How linear systems are solved; if not given, as costs less.
    pub method: Option<Method>,
}

/// How far a press is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PressStage {
    /// Share of the work done, 0 to 1.
    pub done: f64,
    /// What is being done.
    pub what: &'static str,
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
pub fn press(
    setup: &Setup,
    settings: PressSettings,
    observe: &mut dyn FnMut(PressStage) -> bool,
) -> Result<Pressed, PressError> {
    let share = if settings.estimate_error { 0.75 } else { 1.0 };
    let mut pressed =
        press_once(setup, settings.method, &mut |done| observe(PressStage { done: share * done, what: "pressing" }))?;
    if settings.estimate_error {
        let start = Instant::now();
        let observe =
            &mut |done| observe(PressStage { done: share + (1.0 - share) * done, what: "estimating the error" });
        error_estimate::estimate(&mut pressed, settings.method, observe)?;
        pressed.error_seconds = start.elapsed().as_secs_f64();
    }
    Ok(pressed)
}

/// One press on one mesh.
pub(super) fn press_once(
    setup: &Setup,
    method: Option<Method>,
    observe: &mut dyn FnMut(f64) -> bool,
) -> Result<Pressed, PressError> {
    let start = Instant::now();
    let assembly = Assembly::new(setup)?;
    let cost = Cost::of_problem(setup, &assembly.problem, method);
    cost.check(setup)?;
    let mut solver = Solver::new(&assembly.problem, cost.method);
    let mut steps = Vec::new();
    let outcome = march(&mut solver, setup, observe, &mut |reached| steps.push(step(setup, &assembly, reached)));
    without_rounding(&mut steps);
    let (iterations, cycles, factor_mib) =
        (solver.iterations, solver.cycles, solver.factor_bytes() as f64 / f64::from(1 << 20));
    drop(solver);
    let unknowns = assembly.problem.unknowns();
    let seconds = start.elapsed().as_secs_f64();
    let setup = setup.clone();
    let pressed = Pressed {
        setup,
        assembly,
        steps,
        unknowns,
        iterations,
        cycles,
        seconds,
        error_seconds: 0.0,
        method: cost.method,
        factor_mib,
    };
    match outcome {
        Ok(()) => Ok(pressed),
        Err(cause) => Err(PressError::Stopped { cause, reached: Box::new(pressed) }),
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
