//! Load stepping: from the undeformed state to each asked load, in steps as long as Newton's method bears.

use super::newton::{Solver, StepError};
use super::problem::State;
use thiserror::Error;

/// Why a load was not reached.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum PathError {
    /// Even short steps did not converge.
    #[error("the press stops at {reached:.3} of its load: {cause}")]
    Stuck {
        /// Highest load factor in balance.
        reached: f64,
        /// Why the next step failed.
        cause: StepError,
    },
    /// The caller stopped it.
    #[error("stopped")]
    Stopped,
}

/// Shortest step as a share of the longest asked one.
const SHORTEST: f64 = 1.0 / 1024.0;

/// Follows the loads (increasing factors) and hands each converged asked state to `reached`. Where a step fails, it is
/// halved; after a success it is doubled. `observe` hears the present load factor and may stop the work.
///
/// # Errors
/// [`PathError`]; the states handed over before stay valid.
pub fn follow(
    solver: &mut Solver,
    start: State,
    loads: &[f64],
    observe: &mut dyn FnMut(f64) -> bool,
    reached: &mut dyn FnMut(State),
) -> Result<State, PathError> {
    let mut state = start;
    for &target in loads {
        let whole = target - state.load;
        let mut step = whole;
        while state.load < target {
            if !observe(state.load) {
                return Err(PathError::Stopped);
            }
            let next = if state.load + 1.001 * step >= target { target } else { state.load + step };
            match solver.step(&state, next) {
                Ok(balanced) => {
                    state = balanced;
                    step *= 2.0;
                }
                Err(cause) if step * 0.5 < whole * SHORTEST => {
                    return Err(PathError::Stuck { reached: state.load, cause });
                }
                Err(_) => step *= 0.5,
            }
        }
        reached(state.clone());
    }
    Ok(state)
}
