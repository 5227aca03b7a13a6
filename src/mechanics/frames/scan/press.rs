//! One position: the boundary value problem and its solution.

use super::ScanSetup;
use super::compliance::{Balanced, Compliance};
use crate::mechanics::contact::{Contact, Counterpart};
use crate::mechanics::kinematics::Kinematics;
use crate::mechanics::mesh::{Boundary, Facet, Mesh};
use crate::mechanics::newton::{LinearSolver, Solver};
use crate::mechanics::path::{PathError, follow};
use crate::mechanics::press::assembly::supports;
use crate::mechanics::problem::{Problem, State};

/// A position in balance.
pub(super) struct Pressed {
    pub problem: Problem,
    pub state: State,
    pub iterations: usize,
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
