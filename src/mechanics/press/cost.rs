//! What a press takes, known before it is done: by it the method is chosen, and what does not fit into memory refused.

use super::{Assembly, Load, PressError, Setup};
use crate::mechanics::kinematics::Kinematics;
use crate::mechanics::memory::{GIB, limit_gib};
use crate::mechanics::newton::LinearSolver;
use crate::mechanics::problem::Problem;

/// What a press takes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cost {
    /// Elements.
    pub elements: usize,
    /// Displacement unknowns.
    pub unknowns: usize,
    /// How linear systems are solved.
    pub method: LinearSolver,
    /// Memory, GiB; measured ones lay between half and all of it.
    pub memory_gib: f64,
    /// Seconds on two cores, to a factor of three.
    pub seconds: f64,
}

/// Unknowns in three dimensions from which multigrid costs less time than a factorisation.
const CROSSING: usize = 15_000;

/// Newton iterations of a load, and presses that a force is sought with.
const ITERATIONS: f64 = 7.0;
const FORCE_PRESSES: f64 = 4.0;

/// Memory by unknowns n, bytes. `docs/decisions/multigrid.md` has the measured ones.
fn memory_bytes(plane: bool, method: LinearSolver, n: f64) -> f64 {
    const PROGRAM: f64 = 4e7;
    PROGRAM
        + match (plane, method) {
            (true, _) => 2.2e3 * n,
            (false, LinearSolver::Direct) => 260.0 * n.powf(1.35),
            (false, LinearSolver::Multigrid) => 2.6e3 * n,
        }
}

/// Seconds of an iteration by unknowns n.
fn iteration_seconds(plane: bool, method: LinearSolver, n: f64) -> f64 {
    match (plane, method) {
        (true, _) => 7e-6 * n,
        (false, LinearSolver::Direct) => 7.6e-7 * n.powf(1.4),
        (false, LinearSolver::Multigrid) => 2.3e-5 * n,
    }
}

impl Cost {
    /// Of a press, solved as asked or as costs less.
    ///
    /// # Errors
    /// Geometry that cannot be meshed, a setting that is not supported.
    pub fn of(setup: &Setup, method: Option<LinearSolver>) -> Result<Self, PressError> {
        Ok(Self::of_problem(setup, &Assembly::new(setup)?.problem, method))
    }

    pub(super) fn of_problem(setup: &Setup, problem: &Problem, method: Option<LinearSolver>) -> Self {
        let unknowns = problem.unknowns();
        let plane = setup.kinematics != Kinematics::ThreeDimensional;
        let best = if plane || unknowns < CROSSING { LinearSolver::Direct } else { LinearSolver::Multigrid };
        let method = if plane { LinearSolver::Direct } else { method.unwrap_or(best) };
        let presses = match &setup.load {
            Load::Depths(depths) => depths.len() as f64,
            Load::Forces(forces) => FORCE_PRESSES * forces.len() as f64,
            Load::Path(poses) => poses.len() as f64,
        };
        Self {
            elements: problem.mesh.element_count(),
            unknowns,
            method,
            memory_gib: memory_bytes(plane, method, unknowns as f64) / GIB,
            seconds: presses * ITERATIONS * iteration_seconds(plane, method, unknowns as f64),
        }
    }

    /// Whether the memory is there.
    ///
    /// # Errors
    /// [`PressError::TooLarge`], with the resolution that would fit.
    pub(super) fn check(&self, setup: &Setup) -> Result<(), PressError> {
        self.within(setup, limit_gib())
    }

    fn within(&self, setup: &Setup, limit_gib: f64) -> Result<(), PressError> {
        if self.memory_gib <= limit_gib {
            return Ok(());
        }
        let coarser = |share: f64| {
            let mut setup = setup.clone();
            setup.phantom.resolution = setup.phantom.resolution.finer(share);
            Self::of(&setup, None)
        };
        let fits = FITS.into_iter().find(|share| coarser(*share).is_ok_and(|cost| cost.memory_gib <= limit_gib));
        Err(PressError::TooLarge { unknowns: self.unknowns, memory_gib: self.memory_gib, limit_gib, fits })
    }
}

/// Shares of the resolution that are tried where a press does not fit.
const FITS: [f64; 8] = [0.9, 0.8, 0.7, 0.6, 0.5, 0.4, 0.3, 0.25];

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::mechanics::from_scene::press_setup;
    use crate::scene::{Dimensions, preset};

    fn setup(dimensions: Dimensions, resolution: f64) -> Setup {
        let mut loaded = preset("phantom-size-8mm").unwrap();
        let press = loaded.scene.press.as_mut().unwrap();
        (press.dimensions, press.resolution) = (dimensions, resolution);
        press_setup(&loaded).unwrap()
    }

    #[test]
    fn large_presses_in_three_dimensions_alone_go_to_multigrid() {
        let method = |dimensions, resolution| Cost::of(&setup(dimensions, resolution), None).unwrap().method;
        assert_eq!(method(Dimensions::Two, 4.0), LinearSolver::Direct);
        assert_eq!(method(Dimensions::Three, 0.4), LinearSolver::Direct);
        assert_eq!(method(Dimensions::Three, 1.0), LinearSolver::Multigrid);
    }

    #[test]
    fn a_press_that_does_not_fit_names_a_resolution_that_does() {
        let setup = setup(Dimensions::Three, 1.0);
        let cost = Cost::of(&setup, None).unwrap();
        assert!(cost.within(&setup, 1.01 * cost.memory_gib).is_ok());
        let error = cost.within(&setup, 0.6 * cost.memory_gib).unwrap_err();
        let PressError::TooLarge { fits: Some(share), .. } = error else { panic!("{error}") };
        let mut coarser = setup.clone();
        coarser.phantom.resolution = coarser.phantom.resolution.finer(share);
        assert!(Cost::of(&coarser, None).unwrap().memory_gib <= 0.6 * cost.memory_gib);
        let error = cost.within(&setup, 1e-4).unwrap_err();
        assert!(matches!(error, PressError::TooLarge { fits: None, .. }), "{error}");
    }
}
