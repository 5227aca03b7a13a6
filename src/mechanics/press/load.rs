//! Brings a press to the asked depths or forces.

use super::carry::Guesses;
use super::setup::length_mm;
use super::{Load, Pose, Setup, contact_points};
use crate::mechanics::newton::Solver;
use crate::mechanics::path::{PathError, follow};
use crate::mechanics::problem::{Problem, State, Support};

/// A load that was reached.
pub(super) struct Reached {
    pub state: State,
    pub pose: Pose,
    pub force_n: f64,
}

/// How close an asked force is met, as a share of it.
const FORCE_TOLERANCE: f64 = 1e-6;
/// Presses tried for a force.
const TRIES: usize = 40;

/// Follows the asked loads, handing over each as it is reached. Depths of which there is a guess are tried at once.
pub(super) fn march(
    solver: &mut Solver,
    setup: &Setup,
    guesses: &Guesses,
    observe: &mut dyn FnMut(f64) -> bool,
    reached: &mut dyn FnMut(Reached),
) -> Result<(), PathError> {
    let mut state = solver.problem().start();
    let mut hand_over = |solver: &mut Solver, state: State, pose: Pose| {
        let held = if pose.hold_s > 0.0 { hold(solver, &state, pose.hold_s)? } else { state };
        let force_n = force_n(solver.problem(), &held, setup.copies());
        reached(Reached { state: held.clone(), pose, force_n });
        Ok::<_, PathError>(held)
    };
    if let Load::Forces(forces) = &setup.load {
        for (k, &force_n) in forces.iter().enumerate() {
            let mut watch = |_: f64| observe(k as f64 / forces.len() as f64);
            let found = to_force(solver, state, force_n, setup, &mut watch)?.0;
            let pose = Pose { depth_mm: found.load, hold_s: setup.hold_s, ..Pose::default() };
            state = hand_over(solver, found, pose)?;
        }
        return Ok(());
    }
    let poses = setup.poses();
    let starts = || std::iter::once(Pose::default()).chain(poses.iter().copied());
    let ways: Vec<[f64; 3]> = poses.iter().zip(starts()).map(|(pose, start)| pose.way_from(&start)).collect();
    let whole: f64 = ways.iter().map(|&way| length_mm(way)).sum();
    let base = moved_base(solver.problem());
    let mut last = None;
    for (pose, way) in poses.into_iter().zip(ways) {
        let length = length_mm(way);
        if length > 0.0 {
            // The load factor is the depth, or the length of the path.
            let target = match setup.load {
                Load::Path(_) => {
                    solver.turn(&state, &motion(&base, way.map(|x| x / length), setup.kinematics.dim()));
                    last = None;
                    state.load + length
                }
                _ => pose.depth_mm,
            };
            if !observe(state.load / whole) {
                return Err(PathError::Stopped);
            }
            // The guess of the load itself; if it fails, those on the way.
            let known = guesses.between(state.load, target.min(setup.one_state_to_mm()));
            let way = if known.len() > 1 { known.as_slice() } else { &[] };
            for load in known.last().into_iter().chain(way) {
                let guess = guesses.at(&state, *load).filter(|_| state.load < target);
                let Some(next) = guess.and_then(|guess| solver.step(&state, &guess, *load, false).ok()) else {
                    continue;
                };
                last = Some(std::mem::replace(&mut state, next));
            }
            state = follow(solver, state, &mut last, &[target], &mut |load| observe(load / whole))?;
        }
        // A line through states whose faces slid, drawn on by as much again, costs more than it spares.
        if pose.hold_s > 0.0 || solver.problem().slides() {
            last = None;
        }
        state = hand_over(solver, state, pose)?;
    }
    Ok(())
}

/// Nodes of the base that moves.
fn moved_base(problem: &Problem) -> Vec<u32> {
    let up = problem.kinematics.dim() - 1;
    let moved = problem.supports.iter().filter(|support| support.axis == up && support.displacement_mm != 0.0);
    moved.map(|support| support.node).collect()
}

/// The base's motion for one mm of a way along x and y and towards the sensor.
fn motion(base: &[u32], [x, y, depth]: [f64; 3], dim: usize) -> Vec<Support> {
    let along = if dim == 3 { [x, y, -depth] } else { [x, -depth, 0.0] };
    let of = |&node: &u32| (0..dim).map(move |axis| Support { node, axis, displacement_mm: along[axis] });
    base.iter().flat_map(of).collect()
}

fn hold(solver: &mut Solver, state: &State, seconds: f64) -> Result<State, PathError> {
    let fails = |cause| PathError::Hold { load: state.load, cause };
    let mut lengths = solver.problem().steps_of_hold_s(seconds).into_iter();
    lengths.try_fold(state.clone(), |held, length| solver.hold(&held, length)).map_err(fails)
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
        let state = follow(solver, base.clone(), &mut None, &[depth], observe)?;
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
