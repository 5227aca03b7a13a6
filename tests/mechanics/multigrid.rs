//! Newton's method with multigrid finds the states that it finds with a factorisation, at a price that neither
//! incompressibility nor contrast drives up.

use tirtouch::mechanics::from_scene::press_setup;
use tirtouch::mechanics::newton::{LinearSolver, Solver};
use tirtouch::mechanics::press::{Assembly, contact_points};
use tirtouch::mechanics::problem::State;
use tirtouch::scene::{Dimensions, Elastic, Interface, preset};

/// A quarter of `phantom-size-8mm` in large elements, its sphere `contrast` times as stiff as its body.
fn assembly(poisson: f64, contrast: f64, interface: Interface) -> Assembly {
    let mut loaded = preset("phantom-size-8mm").unwrap();
    let elastic = |youngs_kpa: f64| Elastic::NeoHookean { youngs_kpa, poisson, relaxation: Vec::new() };
    let phantom = loaded.scene.phantom.as_mut().unwrap();
    phantom.material = elastic(5.0);
    phantom.inclusion[0].material = elastic(5.0 * contrast);
    let press = loaded.scene.press.as_mut().unwrap();
    (press.dimensions, press.resolution, press.interface) = (Dimensions::Three, 0.25, interface);
    press.edge_radius_mm = Some(0.0);
    let mut setup = press_setup(&loaded).unwrap();
    setup.phantom.resolution.inclusion_divisions = 1.0;
    Assembly::new(&setup).unwrap()
}

/// The state at half a millimetre, its force, and the cycles of an iteration.
fn pressed(assembly: &Assembly, method: LinearSolver) -> (State, f64, f64) {
    let mut solver = Solver::new(&assembly.problem, method);
    let start = assembly.problem.start();
    let state = solver.step(&start, &start, 0.5, true).unwrap();
    let force = contact_points(&assembly.problem, 0, &state).iter().map(|point| point.force_mn).sum();
    (state, force, solver.cycles as f64 / solver.iterations as f64)
}

#[test]
fn multigrid_finds_what_a_factorisation_finds() {
    let tied = Interface::Tied;
    let slides = Interface::Frictionless;
    for (poisson, contrast, interface) in [(0.5, 1e3, tied), (0.4, 1e-3, tied), (0.4999, 24.0, slides)] {
        let assembly = assembly(poisson, contrast, interface);
        let [direct, multigrid] =
            [LinearSolver::Direct, LinearSolver::Multigrid].map(|method| pressed(&assembly, method));
        let size = direct.0.displacement.iter().flatten().fold(0.0, |m: f64, u| m.max(u.abs()));
        let pairs = direct.0.displacement.iter().flatten().zip(multigrid.0.displacement.iter().flatten());
        let off = pairs.fold(0.0, |m: f64, (a, b)| m.max((a - b).abs())) / size;
        let cycles = multigrid.2;
        println!(
            "nu {poisson}, contrast {contrast}: off {off:.1e}, force {:.1e}, {cycles:.0} cycles",
            multigrid.1 / direct.1 - 1.0
        );
        assert!(off < 1e-6 && (multigrid.1 / direct.1 - 1.0).abs() < 1e-6, "{off} {} {}", multigrid.1, direct.1);
        assert!(cycles < 40.0, "nu {poisson}, contrast {contrast}: {cycles} cycles an iteration");
    }
}
