//! Small problems of elasticity: what holds them, and their solution.

use super::StabilityError;
use crate::mechanics::mesh::{Mesh, Resolution};
use crate::mechanics::newton::{LinearSolver, Solver};
use crate::mechanics::path::follow;
use crate::mechanics::problem::{Problem, State, Support};

/// Brings a problem to its whole load, by way of `loads`.
///
/// # Errors
/// `Path` where a load is not reached, however short the steps.
pub fn solve(problem: &Problem, loads: &[f64]) -> Result<State, StabilityError> {
    Ok(follow(&mut Solver::new(problem, LinearSolver::Direct), problem.start(), &mut None, loads, &mut |_| true)?)
}

/// Prescribes one component of the displacement wherever `at` holds.
pub fn held(
    mesh: &Mesh,
    at: impl Fn([f64; 3]) -> bool,
    axis: usize,
    displacement_mm: impl Fn([f64; 3]) -> f64,
) -> Vec<Support> {
    let nodes = (0u32..).zip(&mesh.nodes).filter(|(_, x)| at(**x));
    nodes.map(|(node, x)| Support { node, axis, displacement_mm: displacement_mm(*x) }).collect()
}

/// Elements of one size within the contact and around its edge, larger ones far away.
pub fn graded(edge_mm: f64, contact_mm: f64, coarsest_mm: f64, growth: f64, subdivision: usize) -> Resolution {
    Resolution {
        edge_mm,
        ring_share: 1.0,
        contact_mm,
        coarsest_mm,
        growth,
        rim_mm: 0.0,
        rim_divisions: 1.0,
        inclusion_divisions: 4.0,
        subdivision,
    }
}
