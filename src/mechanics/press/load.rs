//! Brings a press to the asked depths or forces.

use super::{Load, Setup, contact_points};
use crate::mechanics::newton::Solver;
use crate::mechanics::path::{PathError, follow};
use crate::mechanics::problem::{Problem, State};

/// A load that was reached.
pub(super) struct Reached {
    pub state: State,
    pub force_n: f64,
}

/// How close an asked force is met, as a share of it.
const FORCE_TOLERANCE: f64 = 1e-6;
/// Presses tried for a force.
const TRIES: usize = 40;

/// Follows the asked loads, handing over each as it is reached.
pub(super) fn march(
    solver: &mut Solver,
    setup: &Setup,
    observe: &mut dyn FnMut(f64) -> bool,
    reached: &mut dyn FnMut(Reached),
) -> Result<(), PathError> {
    let problem = solver.problem();
    let mut state = problem.start();
    let (count, height) = match &setup.load {
        Load::Depths(depths) => (depths.len(), depths.last().copied().unwrap_or(1.0)),
        Load::Forces(forces) => (forces.len(), 1.0),
    };
    for k in 0..count {
        let (state_here, force_n) = match &setup.load {
            Load::Depths(depths) => {
                let mut watch = |load: f64| observe(load / height);
                let next = follow(solver, state, &[depths[k]], &mut watch)?;
                let force = force_n(problem, &next, setup.copies());
                (next, force)
            }
            Load::Forces(forces) => {
                let mut watch = |_: f64| observe(k as f64 / count as f64);
                to_force(solver, state, forces[k], setup, &mut watch)?
            }
        };
        let held = if setup.hold_s > 0.0 { hold(solver, &state_here, setup.hold_s)? } else { state_here };
        let force_n = if setup.hold_s > 0.0 { self::force_n(problem, &held, setup.copies()) } else { force_n };
        reached(Reached { state: held.clone(), force_n });
        state = held;
    }
    Ok(())
}

fn hold(solver: &mut Solver, state: &State, seconds: f64) -> Result<State, PathError> {
    solver.hold(state, seconds).map_err(|cause| PathError::Hold { load: state.load, cause })
}

/// Force of all contacts along z, N.
fn force_n(problem: &Problem, state: &State, copies: f64) -> f64 {
    let points = (0..problem.contacts.len()).flat_map(|contact| contact_points(problem, contact, state));
    points.map(|point| point.force_mn).sum::<f64>() * copies * 1e-3
}

/// The depth at which the contact bears a force: secant steps, kept inside a bracket once there is one.
fn to_force(
    solver: &mut Solver,
    start: State,
    target: f64,
    setup: &Setup,
    observe: &mut dyn FnMut(f64) -> bool,
) -> Result<(State, f64), PathError> {
    let problem = solver.problem();
    let copies = setup.copies();
    let meets = |force: f64| (force - target).abs() <= FORCE_TOLERANCE * target;
    let mut low = (start.load, force_n(problem, &start, copies));
    if meets(low.1) {
        return Ok((start, low.1));
    }
    let mut high: Option<(f64, f64)> = None;
    let mut base = start;
    let mut depth = if low.0 > 0.0 { low.0 * target / low.1.max(f64::MIN_POSITIVE) } else { FIRST_DEPTH_MM };
    let mut last = (base.clone(), low.1);
    for _ in 0..TRIES {
        let state = follow(solver, base.clone(), &[depth], observe)?;
        let force = force_n(problem, &state, copies);
        last = (state, force);
        if meets(force) {
            return Ok(last);
        }
        let here = (depth, force);
        let slope = (force - low.1) / (depth - low.0);
        if force < target {
            // A state below the target is a start for the next.
            (low, base) = (here, last.0.clone());
        } else {
            high = Some(here);
        }
        let aim = depth + (target - force) / slope.max(f64::MIN_POSITIVE);
        depth = match high {
            Some(high) if !(low.0 < aim && aim < high.0) => 0.5 * (low.0 + high.0),
            Some(_) => aim,
            None => aim.min(2.0 * depth + FIRST_DEPTH_MM),
        };
    }
    Err(PathError::NoForce { target_n: target, depth_mm: last.0.load, force_n: last.1 })
}

/// First depth tried for a force, mm.
const FIRST_DEPTH_MM: f64 = 0.05;
