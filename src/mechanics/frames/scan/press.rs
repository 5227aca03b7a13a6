//! One position: the boundary value problem and its solution.

use super::ScanSetup;
use super::compliance::{Balanced, Compliance};
use crate::mechanics::contact::{Contact, Counterpart};
use crate::mechanics::kinematics::Kinematics;
use crate::mechanics::mesh::{Boundary, Facet, Mesh};
use crate::mechanics::newton::{LinearSolver, Solver};
use crate::mechanics::path::{PathError, follow};
use crate::mechanics::press::assembly::supports;
use crate::mechanics::press::contact_points;
use crate::mechanics::problem::{Problem, State};

/// A position in balance.
pub(super) struct Pressed {
    pub problem: Problem,
    pub state: State,
    pub iterations: usize,
}

impl Pressed {
    /// Force on the indenter, N per mm of its length.
    pub fn force_n_per_mm(&self) -> f64 {
        1e-3 * contact_points(&self.problem, 0, &self.state).iter().map(|point| point.force_mn).sum::<f64>()
    }
}

/// The problem of one position in which these facets may touch; the load factor is the motion of the base in mm.
pub(super) fn problem(setup: &ScanSetup, mesh: &Mesh, position_mm: f64, touched: &[Facet]) -> Problem {
    let kinematics = Kinematics::PlaneStrain;
    // The tissue's own: a softer inclusion below does not matter to the contact.
    let shear = setup.materials.first().map_or(0.0, |tissue| tissue.law.shear_kpa());
    let counterpart = Counterpart::Rigid { profile: setup.indenter.clone(), center: [position_mm, 0.0] };
    let contact = Contact::new(kinematics, mesh, touched, counterpart, setup.grip, shear, 1.0);
    Problem {
        supports: supports(mesh, 0, kinematics, Boundary::Base, -1.0),
        contacts: vec![contact],
        ..Problem::free(kinematics, mesh.clone(), setup.materials.clone())
    }
}

/// Presses the indenter in at one position.
pub(super) fn press(
    setup: &ScanSetup,
    mesh: &Mesh,
    position_mm: f64,
    observe: &mut dyn FnMut(f64) -> bool,
) -> Result<Pressed, PathError> {
    let problem = problem(setup, mesh, position_mm, &mesh.boundary_facets(Boundary::Touched));
    let mut solver = Solver::new(&problem, LinearSolver::Direct);
    let state = follow(&mut solver, problem.start(), &mut None, &[setup.depth_mm], observe)?;
    let iterations = solver.iterations;
    Ok(Pressed { state, iterations, problem })
}

/// The same for linear tissue by its compliance; `None` where that does not settle. The state holds the face only.
pub(super) fn press_linear(
    setup: &ScanSetup,
    mesh: &Mesh,
    compliance: &Compliance,
    position_mm: f64,
) -> Option<Pressed> {
    let problem = problem(setup, mesh, position_mm, &compliance.facets);
    let Balanced { state, iterations } = compliance.press(&problem, setup.depth_mm)?;
    Some(Pressed { problem, state, iterations })
}

/// Steps of the search for a depth, and how near its force must be, as a share.
const STEPS: usize = 30;
const FORCE_TOLERANCE: f64 = 1e-7;

/// The same to the depth at which the indenter's force is this, N/mm; `None` where none is found within the dense part
/// of the face. Between depths the force is a power of the depth, near enough.
pub(super) fn press_to_force(
    setup: &ScanSetup,
    mesh: &Mesh,
    compliance: &Compliance,
    position_mm: f64,
    force_n_per_mm: f64,
) -> Option<Pressed> {
    let mut setup = setup.clone();
    let mut before: Option<[f64; 2]> = None;
    let mut power = 1.3;
    for _ in 0..STEPS {
        if !Compliance::suits(&setup) {
            return None;
        }
        let pressed = press_linear(&setup, mesh, compliance, position_mm)?;
        let force = pressed.force_n_per_mm();
        if (force / force_n_per_mm - 1.0).abs() < FORCE_TOLERANCE {
            return Some(pressed);
        }
        let here = [setup.depth_mm.ln(), force.ln()];
        if let Some([depth, force]) = before {
            power = ((here[1] - force) / (here[0] - depth)).clamp(0.5, 4.0);
        }
        before = Some(here);
        setup.depth_mm *= (force_n_per_mm / force).powf(1.0 / power);
    }
    None
}
