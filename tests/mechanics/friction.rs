//! Coulomb friction against its closed forms and limits.

use super::answers::press::{force, phantom, press};
use super::answers::{Solved, graded, held, on_a_base, touched};
use std::f64::consts::PI;
use tirtouch::mechanics::contact::{Contact, Counterpart, Grip, Profile};
use tirtouch::mechanics::kinematics::Kinematics;
use tirtouch::mechanics::material::Material;
use tirtouch::mechanics::mesh::{Footprint, Mesh, PhantomMesh, PhantomShape};
use tirtouch::mechanics::newton::{LinearSolver, Solver};
use tirtouch::mechanics::press::contact_points;
use tirtouch::mechanics::problem::{Problem, State, Support};

/// A node of the face: x, pressure and traction along x (kPa), area.
struct Row {
    x: f64,
    pressure: f64,
    along: [f64; 2],
    area: f64,
}

/// The base moved by `base_mm`.
fn moved(mesh: &Mesh, height: f64, base_mm: [f64; 3]) -> Vec<Support> {
    let up = mesh.dim - 1;
    (0..mesh.dim).flat_map(|axis| held(mesh, |x| x[up] >= height * (1.0 - 1e-12), axis, |_| base_mm[axis])).collect()
}

/// Presses by `depth` without friction, then moves the base along the face with it: one step each.
fn pressed_and_moved(mut problem: Problem, height: f64, depth: f64, along: [f64; 2]) -> (Problem, State) {
    let up = problem.mesh.dim - 1;
    let base = |share: f64| {
        let mut base_mm = [share * along[0], share * along[1], 0.0];
        base_mm[up] = -depth;
        base_mm
    };
    problem.supports = moved(&problem.mesh, height, base(0.0));
    let grip = std::mem::replace(&mut problem.contacts[0].grip, Grip::Frictionless);
    let start = problem.start();
    let pressed = Solver::new(&problem, LinearSolver::Direct).step(&start, &start, 1.0, false).unwrap();
    problem.supports = moved(&problem.mesh, height, base(1.0));
    problem.contacts[0].grip = grip;
    let state = Solver::new(&problem, LinearSolver::Direct).step(&pressed, &pressed, 1.0, false).unwrap();
    (problem, state)
}

fn rows(problem: &Problem, state: &State) -> Vec<Row> {
    let areas = problem.contacts[0].present_areas(&problem.mesh.nodes);
    let nodes = problem.contacts[0].nodes.iter().zip(&state.traction[0]).zip(areas);
    let mut rows: Vec<Row> = nodes
        .map(|((&a, t), area)| Row {
            x: problem.mesh.nodes[a as usize][0],
            pressure: t.normal,
            along: [t.vector[0], t.vector[1]],
            area,
        })
        .collect();
    rows.sort_by(|a, b| a.x.total_cmp(&b.x));
    rows
}

fn rubbing(
    kinematics: Kinematics,
    mesh: Mesh,
    radius: f64,
    profile: Profile,
    material: Material,
    friction: f64,
) -> Problem {
    let facets = touched(&mesh, radius);
    let counterpart = Counterpart::Rigid { profile, center: [0.0; 2] };
    let grip = Grip::Coulomb(friction);
    let contact = Contact::new(kinematics, &mesh, &facets, counterpart, grip, material.law.shear_kpa(), 1.0);
    Problem { contacts: vec![contact], ..Problem::free(kinematics, mesh, vec![material]) }
}

#[test]
fn a_dragged_block_bears_friction_times_its_weight_against_the_motion() {
    let block = PhantomMesh {
        shape: PhantomShape::Block { size_mm: [8.0, 6.0], height_mm: 2.0 },
        inclusions: Vec::new(),
        footprint: Footprint::Rectangle { half_widths_mm: [4.0, 3.0] },
        symmetry: [false; 2],
        resolution: graded(2.0, 2.0, 2.0, 0.5, 1),
        offset_mm: [0.0; 2],
        layers_mm: Vec::new(),
    };
    for friction in [0.1, 1.0] {
        let plane = (Kinematics::PlaneStrain, block.build_2d().unwrap(), [4.0, 0.0]);
        let solid = (Kinematics::ThreeDimensional, block.build_3d().unwrap(), [2.4, 3.2]);
        for (kinematics, mesh, along) in [plane, solid] {
            let material = Material::linear(5.0, 0.45).unwrap();
            let problem = rubbing(kinematics, mesh, 10.0, Profile::Flat, material, friction);
            let (problem, state) = pressed_and_moved(problem, 2.0, 0.1, along);
            let rows = rows(&problem, &state);
            let normal: f64 = rows.iter().map(|row| row.pressure * row.area).sum();
            let tangential = [0, 1].map(|i| rows.iter().map(|row| row.along[i] * row.area).sum::<f64>());
            let ratio = tangential[0].hypot(tangential[1]) / (friction * normal);
            // In three dimensions the sideways bulge turns single nodes' slip by a little.
            let tolerance = if kinematics == Kinematics::PlaneStrain { 1e-8 } else { 2e-3 };
            assert!(normal > 0.0 && (ratio - 1.0).abs() < tolerance, "{friction} {kinematics:?}: {ratio}");
            for row in rows.iter().filter(|row| row.pressure > 0.0) {
                let share = row.along[0].hypot(row.along[1]) / (friction * row.pressure);
                assert!((share - 1.0).abs() < 1e-6, "{friction} {kinematics:?}: {share} at {}", row.x);
            }
            let against = (tangential[0] * along[0] + tangential[1] * along[1]) / 4.0;
            assert!((against / tangential[0].hypot(tangential[1]) + 1.0).abs() < 1e-3, "{tangential:?}");
        }
    }
}

/// Cattaneo 1938, Mindlin 1949 (Johnson 1985, Contact Mechanics, section 7.2): under a cylinder that bears P and T,
/// |x| < c = a sqrt(1 - T/(mu P)) sticks; the shear is mu p less mu (c/a) p0 sqrt(1 - x^2/c^2) there.
#[test]
fn a_cylinder_pushed_sideways_sticks_in_the_middle_as_cattaneo_and_mindlin_say() {
    let (radius, far, friction, size) = (400.0, 60.0, 0.5, 0.06);
    for share in [0.3, 0.6] {
        let mesh = PhantomMesh {
            shape: PhantomShape::Cylinder { radius_mm: far, height_mm: far },
            inclusions: Vec::new(),
            footprint: Footprint::Round { radius_mm: 1.4 },
            symmetry: [false; 2],
            resolution: graded(2.0 * size, 2.0 * size, 0.2 * far, 0.5, 2),
            offset_mm: [0.0; 2],
            layers_mm: Vec::new(),
        }
        .build_2d()
        .unwrap();
        let material = Material::linear(1.0, 0.5).unwrap();
        let profile = Profile::Round { radius_mm: radius };
        let problem = rubbing(Kinematics::PlaneStrain, mesh, 1.4, profile, material, friction);
        // For a = 1 mm; the force is the measured one.
        let depth = (2.0 * (2.0 * far).ln() - 1.0) / (4.0 * radius);
        let (problem, state) = pressed_and_moved(problem, far, depth, [-share * friction * depth, 0.0]);
        let rows = rows(&problem, &state);
        let [normal, tangential] = [|row: &Row| row.pressure, |row: &Row| row.along[0]]
            .map(|f| rows.iter().map(|row| f(row) * row.area).sum::<f64>());
        let modulus = 1.0 / 0.75;
        let a = (4.0 * normal * radius / (PI * modulus)).sqrt();
        let p0 = 2.0 * normal / (PI * a);
        let left = 1.0 - tangential / (friction * normal);
        let c = a * left.sqrt();
        assert!(0.1 < left && left < 0.9, "{left}");
        let stuck = rows.iter().filter(|row| row.along[0] < friction * row.pressure * (1.0 - 1e-9));
        let found = 0.5 * stuck.map(|row| row.area).sum::<f64>();
        // Nodes are half an element apart, and the first that slips is at most one beyond c.
        assert!((found - c).abs() < size, "sticks to {found}, not {c} of {a}");
        let circle = |x: f64, edge: f64| (1.0 - (x / edge).powi(2)).max(0.0).sqrt();
        let mut sums = [0.0; 2];
        for row in rows.iter().filter(|row| row.x.abs() < 0.9 * a) {
            let exact = friction * p0 * (circle(row.x, a) - c / a * circle(row.x, c));
            sums[0] += row.area * (row.along[0] - exact).powi(2);
            sums[1] += row.area;
        }
        let rms = (sums[0] / sums[1]).sqrt() / (friction * p0);
        // Two elements of 17 in the kinks at c; a base at 60 a.
        assert!(rms < 0.02, "{rms}");
    }
}

/// A flat punch of radius a, pressed straight down, sticks within c; beyond, the half space slips inwards.
///
/// Close to nu = 1/2 shear leaves the pressure p as it is (Goodman, J. Appl. Mech. 29, 515, 1962). With the Hankel
/// transforms P of p and Q of the shear q, nothing moves sideways where int (Q - beta P) J1(k r) dk = 0, beta = (1 - 2
/// nu)/(2 (1 - nu)). Take q = mu p + q* with q* within c, and the transform of q* as int_0^c phi(t) sin(k t) dt: by
/// Abel's equation phi(t) is (beta/pi) ln((a + t)/(a - t)) - mu (2/pi) (t/a) K'(t/a) but for a factor, K' the complete
/// elliptic integral of the complementary modulus. q is bounded where phi(c) = 0 (Spence, J. Elasticity 5, 297, 1975,
/// has the same condition).
#[test]
fn a_flat_punch_pressed_down_sticks_in_its_middle() {
    let (far, size, poisson): (f64, f64, f64) = (200.0, 0.01, 0.49);
    let beta = (1.0 - 2.0 * poisson) / (2.0 * (1.0 - poisson));
    for c in [0.3f64, 0.9] {
        // K'(c) by the arithmetic-geometric mean.
        let (mut a, mut b) = (1.0, c);
        for _ in 0..8 {
            (a, b) = (0.5 * (a + b), (a * b).sqrt());
        }
        let friction = beta * c.atanh() / c / (0.5 * PI / a);
        let mesh = PhantomMesh {
            shape: PhantomShape::Cylinder { radius_mm: far, height_mm: far },
            inclusions: Vec::new(),
            footprint: Footprint::Round { radius_mm: 1.0 },
            symmetry: [true, false],
            resolution: graded(2.0 * size, 2.0 * size, 0.3 * far, 1.0, 2),
            offset_mm: [0.0; 2],
            layers_mm: Vec::new(),
        }
        .build_2d()
        .unwrap();
        let material = Material::linear(1.0, poisson).unwrap();
        let mut problem = rubbing(Kinematics::Axisymmetric, mesh, 1.0, Profile::Flat, material, friction);
        problem.supports = on_a_base(&problem.mesh, far, -1e-4);
        let solved = Solved::new(problem, &[1.0]).unwrap();
        let points = contact_points(&solved.problem, 0, &solved.state);
        let slips = points.iter().filter(|p| p.shear_kpa > friction * p.pressure_kpa * (1.0 - 1e-6));
        let found = slips.map(|p| p.reference_mm[0]).fold(1.0, f64::min);
        // Nodes are half an element apart, and the first that slips is at most one beyond c.
        assert!((found - c).abs() < size, "sticks to {found}, not {c}");
    }
}

#[test]
fn friction_lies_between_sliding_and_the_bond() {
    let force = |grip| {
        let material = Material::linear(5.0, 0.4999).unwrap();
        force(&press(phantom(1, None), vec![material], grip, 1.0, &[1.0]).unwrap())
    };
    let [sliding, tied] = [Grip::Frictionless, Grip::Bonded].map(force);
    let [slight, small, middle, great] = [1e-7, 0.1, 0.3, 1e3].map(|friction| force(Grip::Coulomb(friction)));
    assert!((slight / sliding - 1.0).abs() < 1e-6, "{slight} {sliding}");
    assert!((great / tied - 1.0).abs() < 1e-6, "{great} {tied}");
    assert!(sliding < small && small < middle && middle < tied, "{sliding} {small} {middle} {tied}");
}

/// A ball pressed by half its radius into soft rubber: slopes up to 1 in the contact.
#[test]
fn a_ball_rubs_at_any_friction_and_nowhere_more_than_coulomb_allows() {
    let radius = 2.0;
    let mut sliding = 0.0;
    for friction in [0.0, 0.2, 0.5] {
        let mesh = PhantomMesh {
            shape: PhantomShape::Cylinder { radius_mm: 8.0 * radius, height_mm: 6.0 * radius },
            inclusions: Vec::new(),
            footprint: Footprint::Round { radius_mm: 1.2 * radius },
            symmetry: [true, false],
            resolution: graded(0.1 * radius, 0.1 * radius, radius, 0.3, 1),
            offset_mm: [0.0; 2],
            layers_mm: Vec::new(),
        }
        .build_2d()
        .unwrap();
        let material = Material::neo_hookean(5.0, 0.4999).unwrap();
        let profile = Profile::Round { radius_mm: radius };
        let mut problem = rubbing(Kinematics::Axisymmetric, mesh, 1.5 * radius, profile, material, friction);
        problem.supports = on_a_base(&problem.mesh, 6.0 * radius, -0.5 * radius);
        let solved = Solved::new(problem, &[1.0]).unwrap();
        assert!(solved.iterations < 80, "{friction}: {} iterations", solved.iterations);
        let points = contact_points(&solved.problem, 0, &solved.state);
        let force: f64 = points.iter().map(|point| point.force_mn).sum();
        if friction == 0.0 {
            sliding = force;
            continue;
        }
        assert!(force > sliding, "{friction}: {force} of {sliding}");
        let touching = points.iter().filter(|point| point.pressure_kpa > 0.0);
        let most = touching.map(|point| point.shear_kpa / point.pressure_kpa).fold(0.0, f64::max);
        assert!(most < friction * (1.0 + 1e-6), "{most} of {friction}");
        // The rim slips up to 0.3 and sticks beyond.
        let slips = most > friction * (1.0 - 1e-6);
        assert_eq!(slips, friction < 0.3, "{most} of {friction}");
    }
}
