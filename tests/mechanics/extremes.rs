//! The press at its limits.

use super::answers::press::{force, mean_pressure, phantom, press};
use super::answers::{Solved, graded, held, on_a_base};
use faer::{Mat, Side};
use tirtouch::mechanics::contact::Grip;
use tirtouch::mechanics::kinematics::Kinematics;
use tirtouch::mechanics::material::{Law, Material};
use tirtouch::mechanics::mesh::{Footprint, PhantomMesh, PhantomShape, shapes};
use tirtouch::mechanics::newton::{LinearSolver, Solver};
use tirtouch::mechanics::path::follow;
use tirtouch::mechanics::problem::Problem;
use tirtouch::mechanics::read_out::{min_jacobian, pressure_jump};
use tirtouch::mechanics::solid::element_system;

fn tied(poisson: f64) -> Solved {
    press(phantom(1, None), vec![Material::linear(5.0, poisson).unwrap()], Grip::Bonded, 1.0, &[1.0]).unwrap()
}

#[test]
fn the_force_of_a_press_rises_to_that_of_the_incompressible_phantom() {
    let limit = tied(0.5);
    let mut last = 0.0;
    for poisson in [0.3, 0.45, 0.49, 0.4999, 0.499999] {
        let solved = tied(poisson);
        assert!(force(&solved) > last && force(&solved) < force(&limit), "nu {poisson}: {}", force(&solved));
        last = force(&solved);
        // A checkerboard would have 2; a smooth field on this mesh, singular at one edge, has less than a third.
        let jump = pressure_jump(&solved.problem, &solved.state);
        assert!(jump < 0.3, "nu {poisson}: {jump}");
        // Away from the limit force and pressure are linear in 1 - 2 nu.
        let off = force(&solved) / force(&limit) - 1.0;
        assert!(off.abs() < 30.0 * (1.0 - 2.0 * poisson), "nu {poisson}: {off:e}");
    }
    let near = tied(0.499999);
    assert!((force(&near) / force(&limit) - 1.0).abs() < 1e-4);
    assert!((mean_pressure(&near, 1.0) / mean_pressure(&limit, 1.0) - 1.0).abs() < 1e-4);
    assert!(pressure_jump(&limit.problem, &limit.state) < 0.3);
}

#[test]
fn contrasts_of_a_million_converge_and_order_the_pressures() {
    let mut last = 0.0;
    for contrast in [1e-6, 1e-3, 1.0, 1e3, 1e6] {
        let materials = [5.0, 5.0 * contrast].map(|modulus| Material::neo_hookean(modulus, 0.4999).unwrap());
        let solved = press(phantom(1, Some((8.0, 5.0))), materials.to_vec(), Grip::Bonded, 1.0, &[1.0]).unwrap();
        let pressure = mean_pressure(&solved, 1.0);
        assert!(
            pressure > last && min_jacobian(&solved.problem, &solved.state).unwrap() > 0.0,
            "{contrast} {pressure}"
        );
        last = pressure;
    }
}

#[test]
fn a_ball_of_the_phantoms_own_stuff_changes_nothing() {
    let material = Material::linear(5.0, 0.5).unwrap();
    let with = press(phantom(2, Some((8.0, 5.0))), vec![material.clone(); 2], Grip::Bonded, 1.0, &[1.0]).unwrap();
    let without = press(phantom(2, None), vec![material], Grip::Bonded, 1.0, &[1.0]).unwrap();
    // Two meshes: each is good to 4e-4 in the force, by its ladder.
    assert!((force(&with) / force(&without) - 1.0).abs() < 1e-3);
    assert!((mean_pressure(&with, 1.0) / mean_pressure(&without, 1.0) - 1.0).abs() < 1e-3);
}

#[test]
fn a_bonded_block_is_pressed_to_half_its_height() {
    for (law, poisson) in [(Law::NeoHookean { shear_kpa: 2.0 }, 0.4999), (Law::NeoHookean { shear_kpa: 2.0 }, 0.5)] {
        let mesh = PhantomMesh {
            shape: PhantomShape::Cylinder { radius_mm: 20.0, height_mm: 20.0 },
            inclusions: Vec::new(),
            footprint: Footprint::Round { radius_mm: 20.0 },
            symmetry: [true, false],
            resolution: graded(2.5, 2.5, 2.5, 0.5, 1),
            offset_mm: [0.0; 2],
            layers_mm: Vec::new(),
        }
        .build_2d()
        .unwrap();
        let mut supports = on_a_base(&mesh, 20.0, -10.0);
        (0..2).for_each(|axis| supports.extend(held(&mesh, |x| x[1] == 0.0, axis, |_| 0.0)));
        let materials = vec![Material::elastic(law, poisson).unwrap()];
        let kinematics = Kinematics::Axisymmetric;
        let problem = Problem { supports, ..Problem::free(kinematics, mesh, materials) };
        let mut solver = Solver::new(&problem, LinearSolver::Direct);
        let mut state = problem.start();
        for load in (1..=10).map(|k| 0.1 * f64::from(k)) {
            state = follow(&mut solver, state, &mut None, &[load], &mut |_| true).unwrap();
            let least = min_jacobian(&problem, &state).unwrap();
            assert!(least > 0.0, "nu {poisson}, load {load}: {least}");
        }
    }
}

#[test]
fn no_press_is_no_stress() {
    for grip in [Grip::Bonded, Grip::Frictionless, Grip::Coulomb(0.5)] {
        for law in [Law::Linear { shear_kpa: 2.0 }, Law::NeoHookean { shear_kpa: 2.0 }] {
            let solved =
                press(phantom(1, None), vec![Material::elastic(law, 0.5).unwrap()], grip, 0.0, &[1.0]).unwrap();
            let state = &solved.state;
            assert!(state.displacement.iter().flatten().all(|u| *u == 0.0), "{grip:?}");
            assert!(state.pressure.iter().all(|p| *p == 0.0), "{grip:?}");
            assert!(state.traction.iter().flatten().all(|t| t.normal == 0.0 && t.vector == [0.0; 3]), "{grip:?}");
        }
    }
}

#[test]
fn an_elements_tangent_resists_all_but_rigid_motions() {
    for (kinematics, rigid) in
        [(Kinematics::PlaneStrain, 3), (Kinematics::Axisymmetric, 1), (Kinematics::ThreeDimensional, 6)]
    {
        for law in [Law::Linear { shear_kpa: 1.0 }, Law::NeoHookean { shear_kpa: 1.0 }] {
            for poisson in [0.3, 0.5] {
                let dim = kinematics.dim();
                let mesh = shapes::patch(dim, 2, 0.2, 0.03, 1).unwrap();
                let nodes: Vec<[f64; 3]> = mesh.element(1).iter().map(|&a| mesh.nodes[a as usize]).collect();
                let material = Material::elastic(law.clone(), poisson).unwrap();
                let still = vec![[0.0; 3]; nodes.len()];
                let system = element_system(
                    kinematics,
                    &nodes,
                    &still,
                    &[0.0; 4],
                    &material,
                    None,
                    Some(1e4 * material.law.shear_kpa()),
                )
                .unwrap();
                let n = system.force.len();
                let matrix = Mat::from_fn(n, n, |i, j| system.stiffness[i * n + j]);
                let skew =
                    (0..n * n).fold(0.0f64, |m, k| m.max((matrix[(k / n, k % n)] - matrix[(k % n, k / n)]).abs()));
                let values = matrix.self_adjoint_eigenvalues(Side::Lower).unwrap();
                let largest = values.last().unwrap();
                // Round-off of the largest, and no deformation is a millionth softer than the softest.
                assert!(skew < 1e-12 * largest, "{kinematics:?}: {skew:e}");
                let zero = values.iter().filter(|value| value.abs() < 1e-12 * largest).count();
                assert_eq!(zero, rigid, "{kinematics:?} {law:?} nu {poisson}: {values:?}");
                assert!(values.iter().all(|value| *value > -1e-12 * largest));
            }
        }
    }
}
