//! Thick spheres.

use super::answers::sphere;
use tirtouch::mechanics::kinematics::Kinematics;

#[test]
fn a_thick_sphere_widens_by_six_sevenths() {
    let answer = sphere::linear(4, Kinematics::Axisymmetric);
    // Rung 2 is off by 4e-6; the error falls with the fourth power.
    assert!(answer.error("u(a), mm").abs() < 4e-6, "{:e}", answer.error("u(a), mm"));
}

#[test]
fn a_hollow_sphere_inflates_at_the_known_pressure() {
    assert!((sphere::inflation_pressure(2.0) - 0.806927).abs() < 5e-7);
    let answer = sphere::inflated(4);
    assert!(answer.error("p / mu").abs() < 1e-3, "{:e}", answer.error("p / mu"));
}
