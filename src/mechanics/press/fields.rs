//! Fields of a state, for files and pictures.

use crate::mechanics::element::quadrature;
use crate::mechanics::problem::{Problem, State};
use crate::mechanics::solid::{determinant, pressure_frame, pressure_functions};

/// Mean compressive stress at each node of each element, kPa, in the order of the mesh's elements. It may jump between
/// elements: the pressure is discontinuous.
pub fn element_pressure(problem: &Problem, state: &State) -> Vec<f64> {
    let dim = problem.kinematics.dim();
    let mesh = &problem.mesh;
    let element = |e: usize| {
        let nodes = mesh.element_positions(e);
        let frame = pressure_frame(&nodes);
        let coefficients = &state.pressure[e * (dim + 1)..(e + 1) * (dim + 1)];
        let at = move |x: [f64; 3]| -> f64 {
            let functions = pressure_functions(dim, &frame, x);
            -coefficients.iter().zip(functions).map(|(p, f)| p * f).sum::<f64>()
        };
        nodes.into_iter().map(at)
    };
    (0..mesh.element_count()).flat_map(element).collect()
}

/// Smallest ratio of present to undeformed volume at the quadrature points of each element.
pub fn element_least_jacobian(problem: &Problem, state: &State) -> Vec<f64> {
    let dim = problem.kinematics.dim();
    let mesh = &problem.mesh;
    let element = |e: usize| {
        let nodes = mesh.element_positions(e);
        let displacement: Vec<[f64; 3]> = mesh.element(e).iter().map(|&a| state.displacement[a as usize]).collect();
        let ratio = |at| {
            let point = problem.kinematics.point(&nodes, at)?;
            let mut f = point.displacement_gradient(dim, &displacement);
            (0..3).for_each(|i| f[i][i] += 1.0);
            Some(determinant(&f))
        };
        quadrature(dim).iter().map(|at| ratio(at).unwrap_or(f64::NAN)).fold(f64::INFINITY, f64::min)
    };
    (0..mesh.element_count()).map(element).collect()
}
