//! The patch test: a linear displacement, prescribed on the boundary of a distorted mesh with curved edges, is found
//! inside with its uniform stress.
//!
//! Tolerance 1e-10: Newton's method ends at a residual of 1e-9 of the forces and converges quadratically, so that the
//! last step leaves round-off times the condition of the incompressible tangent (1e4).

use super::answers::{Solved, held_around};
use tirtouch::mechanics::kinematics::Kinematics;
use tirtouch::mechanics::material::{Law, Material, OgdenTerm};
use tirtouch::mechanics::mesh::shapes;
use tirtouch::mechanics::problem::Problem;
use tirtouch::mechanics::read_out::samples;
use tirtouch::mechanics::solid::element_system;

const TOLERANCE: f64 = 1e-10;

type Gradient = [[f64; 3]; 3];

fn apply(gradient: &Gradient, x: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|i| (0..3).map(|j| gradient[i][j] * x[j]).sum())
}

/// Solves with the boundary moved by `gradient` and returns the largest errors of displacement and stress.
fn patch(kinematics: Kinematics, material: Material, gradient: &Gradient) -> (Solved, [f64; 2]) {
    let dim = kinematics.dim();
    let mesh = shapes::patch(dim, 3, 0.25, 0.04, 11).unwrap();
    let supports = held_around(&mesh, |x| apply(gradient, x));
    let modulus = material.law.shear_kpa();
    let problem = Problem { supports, ..Problem::free(kinematics, mesh, vec![material]) };
    let solved = Solved::new(problem, &[1.0]).unwrap();
    let mut errors = [0.0f64; 2];
    for (x, u) in solved.problem.mesh.nodes.iter().zip(&solved.state.displacement) {
        let exact = apply(gradient, *x);
        (0..dim).for_each(|i| errors[0] = errors[0].max((u[i] - exact[i]).abs()));
    }
    let first = samples(&solved.problem, &solved.state, 0).unwrap()[0];
    for e in 0..solved.problem.mesh.element_count() {
        for sample in samples(&solved.problem, &solved.state, e).unwrap() {
            for k in 0..9 {
                let off = sample.cauchy[k / 3][k % 3] - first.cauchy[k / 3][k % 3];
                errors[1] = errors[1].max(off.abs() / modulus);
            }
        }
    }
    (solved, errors)
}

fn settings() -> [(Kinematics, Gradient); 3] {
    [
        (Kinematics::PlaneStrain, [[0.02, 0.03, 0.0], [-0.01, -0.04, 0.0], [0.0; 3]]),
        // Homogeneous around the axis: u_r = a r, u_z = b z.
        (Kinematics::Axisymmetric, [[0.03, 0.0, 0.0], [0.0, -0.05, 0.0], [0.0; 3]]),
        (Kinematics::ThreeDimensional, [[0.02, 0.03, -0.01], [0.01, -0.04, 0.02], [-0.02, 0.01, 0.03]]),
    ]
}

fn laws() -> Vec<Law> {
    vec![
        Law::Linear { shear_kpa: 2.0 },
        Law::NeoHookean { shear_kpa: 2.0 },
        Law::Ogden { terms: vec![OgdenTerm { shear_kpa: 1.0, exponent: 3.0 }] },
    ]
}

#[test]
fn distorted_patches_carry_a_uniform_strain_exactly() {
    for (kinematics, gradient) in settings() {
        for law in laws() {
            for poisson in [0.0, 0.3, 0.4999] {
                let material = Material::elastic(law.clone(), poisson).unwrap();
                // Stresses near the incompressible limit carry the bulk modulus, 5000 shear moduli, as a factor of
                // round-off.
                let scale = material.bulk_kpa() / material.law.shear_kpa();
                let (_, [displacement, stress]) = patch(kinematics, material, &gradient);
                assert!(displacement < TOLERANCE, "{kinematics:?} {law:?} nu {poisson}: {displacement:e}");
                assert!(stress < TOLERANCE * scale.max(1.0), "{kinematics:?} {law:?} nu {poisson}: {stress:e}");
            }
        }
    }
}

#[test]
fn distorted_patches_carry_a_strain_without_volume_change_exactly_where_incompressible() {
    for (kinematics, gradient) in [
        (Kinematics::PlaneStrain, [[0.02, 0.03, 0.0], [-0.01, -0.02, 0.0], [0.0; 3]]),
        (Kinematics::Axisymmetric, [[0.03, 0.0, 0.0], [0.0, -0.06, 0.0], [0.0; 3]]),
        (Kinematics::ThreeDimensional, [[0.02, 0.03, -0.01], [0.01, -0.05, 0.02], [-0.02, 0.01, 0.03]]),
    ] {
        let material = Material::linear(3.0, 0.5).unwrap();
        let (_, [displacement, stress]) = patch(kinematics, material, &gradient);
        assert!(displacement < TOLERANCE && stress < 1e-8, "{kinematics:?}: {displacement:e} {stress:e}");
    }
}

#[test]
fn finite_rotations_cause_no_stress() {
    let (sin, cos) = 0.7f64.sin_cos();
    let plane = [[cos - 1.0, -sin, 0.0], [sin, cos - 1.0, 0.0], [0.0; 3]];
    // About the axis (1, 2, 2)/3, by Rodrigues' formula.
    let axis = [1.0 / 3.0, 2.0 / 3.0, 2.0 / 3.0];
    let turn = [[0.0, -axis[2], axis[1]], [axis[2], 0.0, -axis[0]], [-axis[1], axis[0], 0.0]];
    let delta = |i: usize, j: usize| f64::from(u8::from(i == j));
    let solid: Gradient =
        [0, 1, 2].map(|i| [0, 1, 2].map(|j| sin * turn[i][j] + (1.0 - cos) * (axis[i] * axis[j] - delta(i, j))));
    for (kinematics, gradient) in [(Kinematics::PlaneStrain, plane), (Kinematics::ThreeDimensional, solid)] {
        for law in laws().into_iter().skip(1) {
            let dim = kinematics.dim();
            let mesh = shapes::patch(dim, 3, 0.25, 0.04, 11).unwrap();
            let material = Material::elastic(law, 0.4).unwrap();
            for e in 0..mesh.element_count() {
                let nodes: Vec<[f64; 3]> = mesh.element(e).iter().map(|&a| mesh.nodes[a as usize]).collect();
                let moved: Vec<[f64; 3]> = nodes.iter().map(|x| apply(&gradient, *x)).collect();
                let system = element_system(kinematics, &nodes, &moved, &[0.0; 4], &material, None, None).unwrap();
                // Round-off: a force is modulus times face, at most 2 kPa x 1 mm^2.
                let largest = system.force.iter().fold(0.0f64, |m, f| m.max(f.abs()));
                assert!(largest < 1e-14 && system.volume_defect < 1e-14, "{kinematics:?}: {largest:e}");
            }
        }
    }
}

#[test]
fn confined_compression_finds_the_constrained_modulus() {
    // E (1 - nu) / ((1 + nu)(1 - 2 nu)) = 1667.11 E at nu = 0.4999.
    let strain = 1e-3;
    for kinematics in [Kinematics::PlaneStrain, Kinematics::Axisymmetric, Kinematics::ThreeDimensional] {
        let up = kinematics.dim() - 1;
        let mut gradient = [[0.0; 3]; 3];
        gradient[up][up] = -strain;
        let (solved, _) = patch(kinematics, Material::linear(1.0, 0.4999).unwrap(), &gradient);
        let stress = samples(&solved.problem, &solved.state, 4).unwrap()[2].cauchy[up][up];
        assert!((-stress / strain - 1667.11).abs() < 0.005, "{kinematics:?}: {}", -stress / strain);
    }
}
