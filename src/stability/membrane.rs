//! Cook's membrane: bending and shear of a tapered panel, nearly incompressible, the classic test of locking.

use super::StabilityError;
use super::solved::{held, solve};
use crate::mechanics::kinematics::Kinematics;
use crate::mechanics::material::{Law, Material};
use crate::mechanics::mesh::{Boundary, shapes};
use crate::mechanics::problem::Problem;
use crate::mechanics::read_out::traction_forces;

/// First Lame modulus, kPa.
pub const LAMBDA: f64 = 7500.0;
/// Shear modulus, kPa.
pub const SHEAR: f64 = 0.375;
/// Deflection of the loaded edge's middle under a load of 1 in all, mm.
pub const DEFLECTION: f64 = 16.4326;

/// Deflection of the loaded edge's middle, mm, on `divisions` (even) elements along each side.
///
/// # Errors
/// `Mesh` for no divisions or too many, `Path` where no balance is found.
pub fn deflection(divisions: usize) -> Result<f64, StabilityError> {
    let mesh = shapes::cook(divisions)?;
    let poisson = LAMBDA / (2.0 * (LAMBDA + SHEAR));
    let mut supports = held(&mesh, |x| x[0] == 0.0, 0, |_| 0.0);
    supports.extend(held(&mesh, |x| x[0] == 0.0, 1, |_| 0.0));
    let loaded = mesh.boundary_facets(Boundary::Touched);
    let forces = traction_forces(Kinematics::PlaneStrain, &mesh, &loaded, &|_, _| [0.0, 1.0 / 16.0, 0.0]);
    let materials = vec![Material::elastic(Law::Linear { shear_kpa: SHEAR }, poisson)?];
    let problem = Problem { supports, forces, ..Problem::free(Kinematics::PlaneStrain, mesh, materials) };
    let state = solve(&problem, &[1.0])?;
    let middle = problem.mesh.nodes.iter().position(|x| x[0] == 48.0 && (x[1] - 52.0).abs() < 1e-9);
    let middle = middle.and_then(|node| state.displacement.get(node));
    middle.map(|u| u[1]).ok_or(StabilityError::Missing("Cook's membrane has no node in the middle of its edge"))
}
