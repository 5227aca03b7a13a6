//! What the mixed elements are for: Cook's membrane with and without the pressure field.

use super::answers::cook;
use bilinear::bilinear_cook;

#[path = "bilinear.rs"]
mod bilinear;

#[test]
fn cooks_membrane_bends_by_its_reference() {
    let answer = cook::solve(4);
    assert!(answer.error("deflection, mm").abs() < 3e-3, "{:e}", answer.error("deflection, mm"));
}

#[test]
fn bilinear_displacement_elements_lock() {
    // As many nodes as in the mixed mesh above: 32 x 32 elements.
    let deflection = bilinear_cook(cook::LAMBDA, 32);
    assert!(deflection < 0.8 * cook::DEFLECTION, "{deflection} mm: no locking");
    // The same code is right where nothing is incompressible: against the mixed element at lambda = G (nu = 0.25).
    let easy = bilinear_cook(cook::SHEAR, 32);
    let finer = bilinear_cook(cook::SHEAR, 64);
    assert!((easy / finer - 1.0).abs() < 0.01, "{easy} mm, {finer} mm");
}
