//! The tied press against the digits of another code, and its balance.

use super::answers::press::{force, phantom, press, tied};
use tirtouch::mechanics::contact::Grip;
use tirtouch::mechanics::material::Material;
use tirtouch::mechanics::mesh::Boundary;
use tirtouch::mechanics::read_out::{boundary_force, reactions};

#[test]
fn the_tied_press_gives_the_digits_of_another_element() {
    for inclusion in [false, true] {
        let answer = tied(2, inclusion);
        for name in ["p(r < 1 mm), Pa", "force, N"] {
            assert!(answer.error(name).abs() < 5e-3, "{inclusion} {name}: {:e}", answer.error(name));
        }
    }
}

#[test]
fn what_the_face_bears_the_base_bears() {
    for grip in [Grip::Bonded, Grip::Frictionless] {
        let material = Material::neo_hookean(5.0, 0.4999).unwrap();
        let solved = press(phantom(1, None), vec![material], grip, 2.0, &[1.0]).unwrap();
        let forces = reactions(&solved.problem, &solved.state).unwrap();
        let base = boundary_force(&solved.problem.mesh, &forces, Boundary::Base)[1];
        // Newton's tolerance on the residual.
        assert!((1e-3 * base / force(&solved) + 1.0).abs() < 1e-6, "{grip:?} {base} {}", force(&solved));
    }
}
