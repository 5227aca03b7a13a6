//! Relaxing bodies, read after a ramp and a hold: stresses and reactions against the Prony series in closed form.

use super::answers::held_around;
use tirtouch::mechanics::kinematics::Kinematics;
use tirtouch::mechanics::material::{Law, Material, Prony};
use tirtouch::mechanics::mesh::shapes;
use tirtouch::mechanics::newton::{LinearSolver, Solver};
use tirtouch::mechanics::problem::{Problem, State};
use tirtouch::mechanics::read_out::{element_pressure, reactions, samples};

const TERMS: [Prony; 2] = [Prony { share: 0.3, time_s: 2.0 }, Prony { share: 0.25, time_s: 40.0 }];
const SHEAR: f64 = 2.0;
/// Newton's residual times the condition of the tangent.
const TOLERANCE: f64 = 1e-8;

/// A uniform stretch by 1 % (`size` times as much), at nu = 0.3, along the axis of each setting.
fn gradient(kinematics: Kinematics, size: f64) -> [[f64; 3]; 3] {
    let rows = match kinematics {
        Kinematics::PlaneStrain => [[0.01, 0.006, 0.0], [-0.004, -0.02, 0.0], [0.0; 3]],
        Kinematics::Axisymmetric => [[0.01, 0.0, 0.0], [0.0, -0.03, 0.0], [0.0; 3]],
        Kinematics::ThreeDimensional => [[0.01, 0.006, 0.0], [-0.004, -0.02, 0.002], [0.003, 0.0, 0.005]],
    };
    rows.map(|row| row.map(|entry| size * entry))
}

/// A distorted patch, moved by a gradient within `ramp_s` and held for `hold_s`.
fn held(kinematics: Kinematics, law: Law, gradient: [[f64; 3]; 3], ramp_s: f64, hold_s: f64) -> (Problem, State) {
    let material = Material::elastic(law, 0.3).unwrap().with_relaxation(TERMS.to_vec()).unwrap();
    let mesh = shapes::patch(kinematics.dim(), 3, 0.25, 0.04, 11).unwrap();
    let supports = held_around(&mesh, |x| [0, 1, 2].map(|i| (0..3).map(|j| gradient[i][j] * x[j]).sum()));
    let seconds_per_load = Some(ramp_s);
    let problem = Problem { supports, seconds_per_load, ..Problem::free(kinematics, mesh, vec![material]) };
    let mut solver = Solver::new(&problem, LinearSolver::Direct);
    let start = problem.start();
    let ramped = solver.step(&start, &start, 1.0, true).unwrap();
    let state = solver.hold(&ramped, hold_s).unwrap();
    drop(solver);
    (problem, state)
}

/// Share of a deviatoric stress that is left of a ramp of strain in `ramp` seconds, `hold` seconds after it.
fn left(ramp: f64, hold: f64) -> f64 {
    let gone = TERMS.map(|Prony { share, time_s }| {
        let mean = if ramp > 0.0 { -(-ramp / time_s).exp_m1() * time_s / ramp } else { 1.0 };
        share * (1.0 - mean * (-hold / time_s).exp())
    });
    1.0 - gone.iter().sum::<f64>()
}

const SETTINGS: [Kinematics; 3] = [Kinematics::PlaneStrain, Kinematics::Axisymmetric, Kinematics::ThreeDimensional];

#[test]
fn stresses_and_reactions_of_a_ramp_and_a_hold_follow_the_prony_series() {
    for kinematics in SETTINGS {
        let moved = gradient(kinematics, 1.0);
        // Around the axis a radial stretch is one along the hoop too.
        let mut strain = [0, 1, 2].map(|i| [0, 1, 2].map(|j| 0.5 * (moved[i][j] + moved[j][i])));
        if kinematics == Kinematics::Axisymmetric {
            strain[2][2] = moved[0][0];
        }
        let trace = strain[0][0] + strain[1][1] + strain[2][2];
        let bulk = Material::elastic(Law::Linear { shear_kpa: SHEAR }, 0.3).unwrap().bulk_kpa();
        for (ramp, hold) in [(0.0, 0.0), (0.0, 3.0), (5.0, 0.0), (5.0, 3.0), (5.0, 1e9)] {
            let (problem, state) = held(kinematics, Law::Linear { shear_kpa: SHEAR }, moved, ramp, hold);
            let share = left(ramp, hold);
            let stress = |i: usize, j: usize| {
                let diagonal = f64::from(u8::from(i == j));
                2.0 * SHEAR * share * (strain[i][j] - diagonal * trace / 3.0) + diagonal * bulk * trace
            };
            let (mut work, mut off) = (0.0, 0.0f64);
            for e in 0..problem.mesh.element_count() {
                for sample in samples(&problem, &state, e).unwrap() {
                    for (i, row) in sample.cauchy.iter().enumerate() {
                        for (j, entry) in row.iter().enumerate() {
                            off = off.max((entry - stress(i, j)).abs());
                            work += sample.volume * stress(i, j) * strain[i][j];
                        }
                    }
                }
            }
            assert!(off < TOLERANCE, "{kinematics:?}, {ramp} s, {hold} s: a stress is off by {off:e} kPa");
            // Virtual work: reactions over the boundary's motion are stress over strain.
            let forces = reactions(&problem, &state).unwrap();
            let done: f64 = (0..forces.len()).map(|a| dot(forces[a], state.displacement[a])).sum();
            assert!((done / work - 1.0).abs() < TOLERANCE, "{kinematics:?}, {ramp} s, {hold} s: {done} for {work}");
        }
    }
}

#[test]
fn a_large_strain_at_once_relaxes_by_the_prony_series() {
    // Held still, each Piola-Kirchhoff stress falls as the series says, and the Cauchy stress with it.
    for kinematics in SETTINGS {
        let moved = gradient(kinematics, 12.0);
        let law = || Law::NeoHookean { shear_kpa: SHEAR };
        let (problem, at_once) = held(kinematics, law(), moved, 0.0, 0.0);
        let (_, later) = held(kinematics, law(), moved, 0.0, 3.0);
        let (share, mut largest) = (left(0.0, 3.0), 0.0f64);
        let pressure = element_pressure(&problem, &later);
        for e in 0..problem.mesh.element_count() {
            let [first, last] = [&at_once, &later].map(|state| samples(&problem, state, e).unwrap());
            for (first, last) in first.iter().zip(&last) {
                for k in 0..9 {
                    let diagonal = |s: f64| if k % 4 == 0 { s } else { 0.0 };
                    let before = first.cauchy[k / 3][k % 3] - diagonal(first.pressure);
                    let after = last.cauchy[k / 3][k % 3] - diagonal(last.pressure);
                    largest = largest.max((after - share * before).abs());
                }
                largest = largest.max((last.pressure - first.pressure).abs());
            }
            let mean = |e: usize| pressure[e * problem.mesh.element(e).len()];
            largest = largest.max((mean(e) + last[0].pressure).abs());
        }
        assert!(largest < TOLERANCE, "{kinematics:?}: off by {largest:e} kPa");
    }
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
