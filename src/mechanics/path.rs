//! Load stepping: from the undeformed state to each asked load, in steps as long as Newton's method bears.

use super::newton::{Solver, StepError};
use super::problem::State;
use thiserror::Error;

/// Why a load was not reached.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum PathError {
    /// Even short steps did not converge.
    #[error("the press stops at {reached:.3} of {target}: {cause}")]
    Stuck {
        /// Highest load factor in balance.
        reached: f64,
        /// Load factor that was asked for.
        target: f64,
        /// Why the next step failed.
        cause: StepError,
    },
    /// A force that no depth within reach bears.
    #[error("a force of {target_n} N is not met: {force_n:.6} N at {depth_mm:.4} mm")]
    NoForce {
        /// Asked, N.
        target_n: f64,
        /// Depth of the last try, mm.
        depth_mm: f64,
        /// Its force, N.
        force_n: f64,
    },
    /// A material did not settle while the load was held.
    #[error("the hold at {load:.3} mm fails: {cause}")]
    Hold {
        /// Load factor.
        load: f64,
        /// Why.
        cause: StepError,
    },
    /// The caller stopped it.
    #[error("stopped")]
    Stopped,
}

/// Shortest step as a share of the longest asked one.
const SHORTEST: f64 = 1.0 / 1024.0;
/// Growth of the step after one that took few iterations, and after any other.
const GROWTH: [f64; 2] = [2.0, 1.25];
/// First step of faces that slide, as a share of the longest: all of the face is then still to find.
const FIRST: f64 = 0.25;
/// Steps, as a share of the longest asked one, that are tried with damping where they fail without. Longer ones are
/// halved.
const DAMPED_STEP: f64 = 0.13;
/// What few iterations are.
const EASY: usize = 6;

/// Follows the loads (increasing factors) to the last. Each step starts from the line through the last two states, of
/// which `last` is the one before; where it fails, it is halved. `observe` hears the present load factor and may stop
/// the work.
///
/// # Errors
/// [`PathError`].
pub fn follow(
    solver: &mut Solver,
    start: State,
    last: &mut Option<State>,
    loads: &[f64],
    observe: &mut dyn FnMut(f64) -> bool,
) -> Result<State, PathError> {
    let mut state = start;
    for &target in loads {
        let whole = target - state.load;
        let slides = solver.problem().slides();
        let longest = whole / solver.problem().steps_a_load() as f64;
        let mut step = if slides && state.load == 0.0 { longest.min(FIRST * whole) } else { longest };
        while state.load < target {
            if !observe(state.load) {
                return Err(PathError::Stopped);
            }
            let longest = longest.min(solver.problem().stride.from(state.load));
            step = step.min(longest).min(target - state.load);
            let next = if state.load + 1.001 * step >= target { target } else { state.load + step };
            let iterations = solver.iterations;
            let guess = last.as_ref().and_then(|last| solver.extrapolated(last, &state, next));
            let damped = step <= DAMPED_STEP * whole;
            let guess = guess.as_ref().unwrap_or(&state);
            let step_to = if next < target { Solver::pass } else { Solver::step };
            match step_to(solver, &state, guess, next, damped) {
                Ok(balanced) => {
                    *last = Some(std::mem::replace(&mut state, balanced));
                    step *= GROWTH[usize::from(solver.iterations - iterations > EASY)];
                }
                // A matrix that is too large stays so, however short the step.
                Err(cause) if step * 0.5 < whole * SHORTEST || cause.is_too_large() => {
                    return Err(PathError::Stuck { reached: state.load, target, cause });
                }
                Err(_) => step *= 0.5,
            }
        }
    }
    Ok(state)
}
