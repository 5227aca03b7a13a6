//! Eshelby's sphere.

use super::answers::eshelby::{far, solve, strain};

#[test]
fn the_strain_in_a_stiff_sphere_is_eshelbys() {
    let answer = strain(2, 20.0);
    assert!((answer.figures[0].exact - 0.116279).abs() < 5e-7);
    assert!(answer.error("inside / far").abs() < 2e-3, "{:e}", answer.error("inside / far"));
    assert!(answer.error("spread, rms") < 5e-3, "{:e}", answer.error("spread, rms"));
}

#[test]
fn a_sphere_of_the_same_modulus_is_not_felt() {
    let solved = solve(1, 1.0);
    for (x, u) in solved.problem.mesh.nodes.iter().zip(&solved.state.displacement) {
        let exact = far(*x);
        // 1e-10 of the far displacements, 20 mm.
        assert!((0..2).all(|i| (u[i] - exact[i]).abs() < 2e-9), "{x:?} {u:?}");
    }
}

#[test]
fn spheres_of_any_contrast_strain_as_eshelby_says() {
    for contrast in [1e-6, 1e-3, 0.1, 1e3, 1e6] {
        let answer = strain(2, contrast);
        assert!(answer.error("inside / far").abs() < 5e-3, "k {contrast}: {:e}", answer.error("inside / far"));
    }
}
