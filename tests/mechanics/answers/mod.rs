//! Problems with a known answer, each on a ladder of meshes: rung 1, 2, 3, ... divides every element once, twice, ...
//!
//! The tests hold one rung of each to its tolerance; `benches/mechanics_ladder.rs` climbs them all.

pub mod cook;
pub mod eshelby;
pub mod hayes;
pub mod hertz;
pub mod phantom;
pub mod press;
pub mod sphere;

use std::time::Instant;
use tirtouch::mechanics::mesh::{Boundary, Mesh};
use tirtouch::mechanics::newton::{LinearSolver, Solver};
use tirtouch::mechanics::path::{PathError, follow};
use tirtouch::mechanics::problem::{Problem, State, Support};
pub use tirtouch::stability::solved::{graded, held};

/// A solved problem and what it took.
pub struct Solved {
    pub problem: Problem,
    pub state: State,
    pub iterations: usize,
    pub seconds: f64,
}

/// One rung: what was computed, beside what is known.
pub struct Answer {
    pub unknowns: usize,
    pub iterations: usize,
    pub seconds: f64,
    pub figures: Vec<Figure>,
}

/// A number with its reference. An exact 0 means that `value` is itself an error.
pub struct Figure {
    pub name: &'static str,
    pub value: f64,
    pub exact: f64,
}

impl Solved {
    /// Solves in asked steps of the load.
    pub fn new(problem: Problem, loads: &[f64]) -> Result<Self, PathError> {
        let start = Instant::now();
        let mut solver = Solver::new(&problem, LinearSolver::Direct);
        let state = follow(&mut solver, problem.start(), &mut None, loads, &mut |_| true)?;
        let (iterations, seconds) = (solver.iterations, start.elapsed().as_secs_f64());
        Ok(Self { problem, state, iterations, seconds })
    }

    pub fn answer(&self, figures: Vec<(&'static str, f64, f64)>) -> Answer {
        let figures = figures.into_iter().map(|(name, value, exact)| Figure { name, value, exact }).collect();
        Answer { unknowns: self.problem.unknowns(), iterations: self.iterations, seconds: self.seconds, figures }
    }
}

impl Figure {
    pub fn error(&self) -> f64 {
        if self.exact == 0.0 { self.value } else { self.value / self.exact - 1.0 }
    }
}

/// The axis held against r, the base moved along z and held against r.
pub fn on_a_base(mesh: &Mesh, height: f64, base_mm: f64) -> Vec<Support> {
    let on_base = |x: [f64; 3]| x[1] >= height * (1.0 - 1e-12);
    let mut supports = held(mesh, |x| x[0] == 0.0 || on_base(x), 0, |_| 0.0);
    supports.extend(held(mesh, on_base, 1, |_| base_mm));
    supports
}

/// Prescribes all components on the whole boundary.
pub fn held_around(mesh: &Mesh, displacement_mm: impl Fn([f64; 3]) -> [f64; 3]) -> Vec<Support> {
    let mut nodes: Vec<u32> = mesh.facets.iter().flat_map(|facet| mesh.facet_nodes(*facet)).collect();
    nodes.sort_unstable();
    nodes.dedup();
    let support = |node: u32, axis: usize| Support {
        node,
        axis,
        displacement_mm: displacement_mm(mesh.nodes[node as usize])[axis],
    };
    let support = &support;
    nodes.iter().flat_map(|&node| (0..mesh.dim).map(move |axis| support(node, axis))).collect()
}

/// Facets of the touched face within a distance of the axis.
pub fn touched(mesh: &Mesh, radius: f64) -> Vec<tirtouch::mechanics::mesh::Facet> {
    let mut facets = mesh.boundary_facets(Boundary::Touched);
    facets.retain(|facet| {
        mesh.facet_nodes(*facet).iter().all(|&a| mesh.nodes[a as usize][0].abs() <= radius * (1.0 + 1e-9))
    });
    facets
}

/// Distance from the axis, pressure along z, and undeformed area of each touched node, outwards.
pub fn face(solved: &Solved) -> Vec<[f64; 3]> {
    let (contact, nodes) = (&solved.problem.contacts[0], &solved.problem.mesh.nodes);
    let areas = contact.present_areas(nodes);
    let up = solved.problem.kinematics.dim() - 1;
    let tractions = solved.state.traction[0].iter().map(|traction| traction.normal + traction.vector[up]);
    let radii = contact.nodes.iter().map(|&a| nodes[a as usize][0]);
    let mut rows: Vec<[f64; 3]> = radii.zip(tractions.zip(areas)).map(|(r, (p, area))| [r, p, area]).collect();
    rows.sort_by(|a, b| a[0].total_cmp(&b[0]));
    rows
}
