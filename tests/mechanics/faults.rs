//! Faults that the comparisons must see.

use super::answers::sphere;
use tirtouch::mechanics::kinematics::Kinematics;

#[test]
fn a_shell_without_its_hoop_is_not_a_sphere() {
    // Plane strain on the same mesh: weight 1 in place of the circle, no hoop strain. It is a cylinder, b = 2 a, whose
    // inner face moves by 2 (1 + nu) p a / (E (1 - a^2/b^2)) / 2 = 2 mm for nu = 0.5.
    let answer = sphere::linear(4, Kinematics::PlaneStrain);
    assert!(answer.error("u(a), mm") > 0.5, "{:e}", answer.error("u(a), mm"));
    assert!((answer.figures[0].value - 2.0).abs() < 1e-4, "{}", answer.figures[0].value);
}
