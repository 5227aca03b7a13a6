//! The face around a tied soft sensor, which folds up from about 3 mm on and meets the sensor's side wall.

use super::answers::phantom::setup;
use tirtouch::mechanics::mesh::Boundary;
use tirtouch::mechanics::newton::{LinearSolver, Solver};
use tirtouch::mechanics::path::follow;
use tirtouch::mechanics::press::{Assembly, contact_points};
use tirtouch::mechanics::problem::State;
use tirtouch::mechanics::read_out::reactions;

const DEPTH_MM: f64 = 6.0;
/// Half as fine as the default mesh.
const DIVISIONS: usize = 1;

fn pressed(assembly: &Assembly) -> State {
    let problem = &assembly.problem;
    let mut solver = Solver::new(problem, LinearSolver::Direct);
    follow(&mut solver, problem.start(), &mut None, &[1.0, 2.0, DEPTH_MM], &mut |_| true).unwrap()
}

/// How far the face around the sensor reaches into it, mm; negative where it stays away.
fn inside_mm(assembly: &Assembly, state: &State) -> f64 {
    let now = assembly.problem.positions(state);
    let [phantom, sensor] = assembly.bodies.as_slice() else { panic!("two bodies") };
    let node = |a: u32| now[a as usize + assembly.phantom_nodes];
    let mut wall: Vec<[f64; 3]> = sensor.boundary_nodes(Boundary::Side).into_iter().map(node).collect();
    wall.sort_by(|a, b| a[1].total_cmp(&b[1]));
    let around = phantom.boundary_nodes(Boundary::Touched).into_iter().filter(|&a| phantom.nodes[a as usize][0] > 15.0);
    let reach = |[r, z, _]: [f64; 3]| {
        let above = wall.partition_point(|place| place[1] <= z);
        let (a, b) = (wall.get(above.checked_sub(1)?)?, wall.get(above)?);
        Some(a[0] + (b[0] - a[0]) * (z - a[1]) / (b[1] - a[1]) - r)
    };
    around.filter_map(|a| reach(now[a as usize])).fold(f64::NEG_INFINITY, f64::max)
}

#[test]
fn the_face_around_a_tied_sensor_stays_out_of_its_side_wall() {
    let mut assembly = Assembly::new(&setup(true, DIVISIONS)).unwrap();
    let state = pressed(&assembly);
    assert_forces_balance(&assembly, &state);
    let found = inside_mm(&assembly, &state);
    assembly.problem.contacts.truncate(1);
    let through = inside_mm(&assembly, &pressed(&assembly));
    println!("inside by {found:.5} mm, {through:.5} mm where nothing is in the way");
    // Gaps close in the mean over a node's share of the face, not at each node.
    assert!(found < 0.01, "{found} mm inside");
    assert!(through > 0.02, "{through} mm inside without a wall");
}

/// A contact that is forgotten in the force does not balance the support of the phantom's base.
fn assert_forces_balance(assembly: &Assembly, state: &State) {
    let problem = &assembly.problem;
    let supports = reactions(problem, state).unwrap();
    let base = assembly.bodies[0].boundary_nodes(Boundary::Base);
    let pressing = -base.iter().map(|&a| supports[a as usize][1]).sum::<f64>();
    let borne = |contact| contact_points(problem, contact, state).iter().map(|point| point.force_mn).sum::<f64>();
    let [bond, wall] = [borne(0), borne(1)];
    println!("{pressing} mN; bond {bond}, wall {wall}");
    assert!(((bond + wall) / pressing - 1.0).abs() < 1e-6, "{pressing} mN; bond {bond}, wall {wall}");
    assert!((bond / pressing - 1.0).abs() > 1e-5, "the wall bears nothing: {wall} mN");
}
