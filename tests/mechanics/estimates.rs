//! The error that a press states of itself, against a finer mesh: the shipped neo-Hookean phantom at 4 mm, default
//! mesh.
//!
//! The face around the sensor folds up and meets its side wall at this depth. With an inclusion, a mesh three times as
//! fine as the default gives the same error as the one twice as fine here.

use super::answers::phantom::{errors, run};

/// The default resolution and the one that stands for the truth, as subdivisions.
const DEFAULT: usize = 2;
const TRUTH: usize = 4;

fn assert_the_estimate_is_true(inclusion: bool) {
    let pressed = run(inclusion, DEFAULT, true).unwrap();
    let [rms, force] = errors(&pressed, &run(inclusion, TRUTH, false).unwrap()).unwrap();
    let step = pressed.steps.last().unwrap();
    let error = step.error.unwrap();
    assert_eq!(step.depth_mm, 4.0);
    assert!(rms < 0.005, "rms {rms}");
    assert!(error.rms / rms < 2.0 && rms / error.rms < 2.0, "rms {rms}, estimated {}", error.rms);
    // The singular edge leaves first order, so that half of the error shows against a mesh twice as fine.
    assert!(force.abs() < 2.0 * error.force && error.force < 4.0 * force.abs(), "{force}, estimated {}", error.force);
}

#[test]
fn the_phantom_knows_the_error_of_its_pressure() {
    assert_the_estimate_is_true(false);
}

#[test]
fn the_phantom_with_an_inclusion_knows_the_error_of_its_pressure() {
    assert_the_estimate_is_true(true);
}
