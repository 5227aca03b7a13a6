//! Cook's membrane: bending and shear of a tapered panel, the classic test of locking.

use super::{Answer, Solved, held};
use tirtouch::mechanics::kinematics::Kinematics;
use tirtouch::mechanics::material::{Law, Material};
use tirtouch::mechanics::mesh::{Boundary, shapes};
use tirtouch::mechanics::problem::Problem;
use tirtouch::mechanics::read_out::traction_forces;

/// Lame's moduli, kPa.
pub const LAMBDA: f64 = 7500.0;
pub const SHEAR: f64 = 0.375;
/// Deflection of the loaded edge's middle under a load of 1 in all, mm.
pub const DEFLECTION: f64 = 16.4326;

pub fn solve(rung: usize) -> Answer {
    let mesh = shapes::cook(4 * rung).unwrap();
    let poisson = LAMBDA / (2.0 * (LAMBDA + SHEAR));
    let mut supports = held(&mesh, |x| x[0] == 0.0, 0, |_| 0.0);
    supports.extend(held(&mesh, |x| x[0] == 0.0, 1, |_| 0.0));
    let loaded = mesh.boundary_facets(Boundary::Touched);
    let forces = traction_forces(Kinematics::PlaneStrain, &mesh, &loaded, &|_, _| [0.0, 1.0 / 16.0, 0.0]);
    let materials = vec![Material::elastic(Law::Linear { shear_kpa: SHEAR }, poisson).unwrap()];
    let problem = Problem { supports, forces, ..Problem::free(Kinematics::PlaneStrain, mesh, materials) };
    let solved = Solved::new(problem, &[1.0]).unwrap();
    let nodes = &solved.problem.mesh.nodes;
    let middle = nodes.iter().position(|x| x[0] == 48.0 && (x[1] - 52.0).abs() < 1e-9).unwrap();
    solved.answer(vec![("deflection, mm", solved.state.displacement[middle][1], DEFLECTION)])
}
