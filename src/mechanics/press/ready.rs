//! One press on one mesh.

use super::carry::Guesses;
use super::face::Face;
use super::load::{Reached, march};
use super::pressed::{PressStep, Pressed};
use super::{Assembly, Cost, Load, Pose, PressError, Setup, contact_points};
use crate::mechanics::newton::{LinearSolver, Solver};
use crate::mechanics::path::PathError;
use std::time::{Duration, Instant};

/// A press that was found to fit into memory.
pub(super) struct Ready {
    setup: Setup,
    assembly: Assembly,
    method: LinearSolver,
    meshing: Duration,
}

impl Ready {
    pub fn new(setup: &Setup, method: Option<LinearSolver>) -> Result<Self, PressError> {
        let start = Instant::now();
        let assembly = Assembly::new(setup)?;
        let cost = Cost::of_problem(setup, &assembly.problem, method);
        cost.check(setup)?;
        Ok(Self { setup: setup.clone(), assembly, method: cost.method, meshing: start.elapsed() })
    }

    /// Whether faces slide over each other.
    pub fn slides(&self) -> bool {
        self.assembly.problem.slides()
    }

    /// Whether a state depends on its depth alone, not on the way there.
    pub fn takes_guesses(&self) -> bool {
        matches!(self.setup.load, Load::Depths(_)) && !self.assembly.problem.way_counts()
    }

    /// One press on one mesh, as far as it comes: the loads that it reached are a press, too. What is told to stop is
    /// not.
    pub fn press_as_far(
        self,
        near: Option<&Pressed>,
        observe: &mut dyn FnMut(f64) -> bool,
    ) -> Result<Pressed, PressError> {
        match self.press(near, observe) {
            Err(PressError::Stopped { cause, reached }) if cause != PathError::Stopped => Ok(*reached),
            outcome => outcome,
        }
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
            unestimated: None,
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
        if step.peak_pressure_kpa <= BALANCE * peak {
            (step.peak_pressure_kpa, step.peak_at_mm) = (0.0, None);
        }
    }
}

fn step(setup: &Setup, assembly: &Assembly, Reached { state, pose, force_n }: Reached) -> PressStep {
    let points = contact_points(&assembly.problem, 0, &state);
    let face = Face::new(setup, assembly.problem.contacts.first(), points);
    let peak = face.peak().filter(|(_, pressure)| *pressure > 0.0);
    let (peak_pressure_kpa, peak_at_mm) = peak.map_or((0.0, None), |([x, y, _], pressure)| (pressure, Some([x, y])));
    let Pose { depth_mm, slide_mm, hold_s } = pose;
    let (points, error) = (face.points, None);
    PressStep { depth_mm, slide_mm, hold_s, force_n, peak_pressure_kpa, peak_at_mm, points, state, error }
}
