//! What a press takes, known before it is done: by it the method is chosen, and what does not fit into memory refused.

use super::setup::length_mm;
use super::{Assembly, Load, Pose, PressError, Setup};
use crate::mechanics::contact::Grip;
use crate::mechanics::kinematics::Kinematics;
use crate::mechanics::memory::{GIB, limit_gib};
use crate::mechanics::newton::LinearSolver;
use crate::mechanics::problem::{Problem, Stride};

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

/// Newton iterations of a load that is one step; over a rigid sensor, where the contact's outline is to be found.
const ITERATIONS: f64 = 7.0;
const ITERATIONS_OVER_RIGID: f64 = 25.0;
/// Those of each of several steps; where faces rub.
const ITERATIONS_OF_STEP: f64 = 4.0;
const ITERATIONS_OF_RUBBING_STEP: f64 = 10.0;
/// Presses that a force is sought with.
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

/// Newton iterations of all loads, to a factor of three.
fn iterations(setup: &Setup, problem: &Problem) -> f64 {
    let over_rigid = problem.contacts.iter().any(|contact| contact.grip != Grip::Bonded && contact.is_rigid());
    let between = |from: f64, to: f64| {
        let Stride { any_to, longest } = problem.stride;
        let steps = ((to - any_to.max(from)).max(0.0) / longest).ceil().max(problem.steps_a_load() as f64);
        match steps > 1.0 {
            true if problem.rubs() => ITERATIONS_OF_RUBBING_STEP * steps,
            true => ITERATIONS_OF_STEP * steps,
            false if over_rigid => ITERATIONS_OVER_RIGID,
            false => ITERATIONS,
        }
    };
    if let Load::Forces(forces) = &setup.load {
        return FORCE_PRESSES * forces.len() as f64 * between(0.0, 0.0);
    }
    let (mut at, mut start, mut sum) = (0.0, Pose::default(), 0.0);
    for pose in setup.poses() {
        let to = at + length_mm(pose.way_from(&start));
        sum += between(at, to);
        (at, start) = (to, pose);
    }
    sum
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
        Self {
            elements: problem.mesh.element_count(),
            unknowns,
            method,
            memory_gib: memory_bytes(plane, method, unknowns as f64) / GIB,
            seconds: iterations(setup, problem) * iteration_seconds(plane, method, unknowns as f64),
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
    use crate::mechanics::press::{PressSettings, press};
    use crate::scene::{Dimensions, preset};
    use crate::vary::with;
    use std::path::Path;

    fn setup(dimensions: Dimensions, resolution: f64) -> Setup {
        let mut loaded = preset("phantom-size-8mm").unwrap();
        let press = loaded.scene.press.as_mut().unwrap();
        (press.dimensions, press.resolution) = (dimensions, resolution);
        press_setup(&loaded).unwrap()
    }

    #[test]
    fn iterations_are_foretold_within_a_factor_of_three() {
        let relaxing =
            r#"phantom.material={ law = "neo_hookean", youngs_kpa = 5, relaxation = [{ share = 0.5, time_s = 2 }] }"#;
        let slides = r#"press.interface={ kind = "frictionless" }"#;
        let rubs = r#"press.interface={ kind = "coulomb", friction = 0.3 }"#;
        let rigid = "press.sensor=rigid";
        for sets in [
            &[][..],
            &[rigid],
            &[slides],
            &[slides, rigid],
            &[rubs],
            &[rubs, rigid, "press.depths_mm=[1, 2]"],
            &[relaxing, "press.rate_mm_per_s=1"],
            &[slides, "press.dimensions=three", "press.depths_mm=[1]"],
        ] {
            let all: Vec<_> = sets.iter().chain(&["press.resolution=0.25"]).map(|set| set.parse().unwrap()).collect();
            let loaded = with(preset("phantom-size-8mm").unwrap(), Path::new("s.toml"), &all).unwrap();
            let setup = press_setup(&loaded).unwrap();
            let pressed = press(&setup, PressSettings::default(), &mut |_| true);
            let pressed = pressed.map_err(|error| error.to_string()).unwrap();
            let (foretold, taken) = (iterations(&setup, &pressed.assembly.problem), pressed.iterations as f64);
            assert!(foretold < 3.0 * taken && taken < 3.0 * foretold, "{sets:?}: {foretold} foretold, {taken} taken");
        }
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
