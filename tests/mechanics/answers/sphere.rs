//! A thick sphere b = 2 a (a = 1 mm) under inner pressure.

use super::{Answer, Solved, held};
use tirtouch::mechanics::kinematics::Kinematics;
use tirtouch::mechanics::material::Material;
use tirtouch::mechanics::mesh::{Boundary, Mesh, shapes};
use tirtouch::mechanics::problem::{Problem, Support};
use tirtouch::mechanics::read_out::{reactions, traction_forces};

fn shell(rung: usize) -> (Mesh, Vec<Support>) {
    let mesh = shapes::shell(1.0, 2.0, 2 * rung, 3 * rung).unwrap();
    let mut supports = held(&mesh, |x| x[0] == 0.0, 0, |_| 0.0);
    supports.extend(held(&mesh, |x| x[1] == 0.0, 1, |_| 0.0));
    (mesh, supports)
}

/// Linear, nu = 0.5, E = p = 1: the inner face moves by 6/7 mm. In plane strain the same mesh is a cylinder.
pub fn linear(rung: usize, kinematics: Kinematics) -> Answer {
    let (mesh, supports) = shell(rung);
    let inner = mesh.boundary_facets(Boundary::Touched);
    let forces = traction_forces(kinematics, &mesh, &inner, &|_, normal| normal.map(|n| -n));
    let materials = vec![Material::linear(1.0, 0.5).unwrap()];
    let solved =
        Solved::new(Problem { supports, forces, ..Problem::free(kinematics, mesh, materials) }, &[1.0]).unwrap();
    let nodes = solved.problem.mesh.boundary_nodes(Boundary::Touched);
    let moved = |node: &u32| {
        let (x, u) = (solved.problem.mesh.nodes[*node as usize], solved.state.displacement[*node as usize]);
        x[0] * u[0] + x[1] * u[1]
    };
    let mean = nodes.iter().map(moved).sum::<f64>() / nodes.len() as f64;
    solved.answer(vec![("u(a), mm", mean, 6.0 / 7.0)])
}

/// Neo-Hookean, mu = 1, nu = 0.5, the inner face moved out to `stretch`.
pub fn inflate(rung: usize, stretch: f64) -> Solved {
    let (mesh, mut supports) = shell(rung);
    for node in mesh.boundary_nodes(Boundary::Touched) {
        for axis in 0..2 {
            let displacement_mm = (stretch - 1.0) * mesh.nodes[node as usize][axis];
            supports.push(Support { node, axis, displacement_mm });
        }
    }
    let materials = vec![Material::neo_hookean(3.0, 0.5).unwrap()];
    let kinematics = Kinematics::Axisymmetric;
    Solved::new(Problem { supports, ..Problem::free(kinematics, mesh, materials) }, &[1.0]).unwrap()
}

/// Pressure in the hollow: work of the reactions over a radial motion, by the volume that it adds (half a sphere here).
pub fn inner_pressure(solved: &Solved) -> f64 {
    let forces = reactions(&solved.problem, &solved.state).unwrap();
    let mesh = &solved.problem.mesh;
    let (mut work, mut radius) = (0.0, 0.0);
    for node in mesh.boundary_nodes(Boundary::Touched) {
        let (x, force) = (mesh.nodes[node as usize], forces[node as usize]);
        work += x[0] * force[0] + x[1] * force[1];
        radius = (x[0] + solved.state.displacement[node as usize][0])
            .hypot(x[1] + solved.state.displacement[node as usize][1]);
    }
    work / (std::f64::consts::TAU * radius * radius)
}

/// Pressure, mu = 1, at which the inner face is stretched by `stretch`: [2/l + 1/(2 l^4)] between the faces.
///
/// From d(sigma_rr)/dr = 2 (l^2 - l^-4)/r with the hoop stretch l = r/R and dr/r = dl/(l (1 - l^3)).
pub fn inflation_pressure(stretch: f64) -> f64 {
    let outer = (1.0 + (stretch.powi(3) - 1.0) / 8.0).cbrt();
    let radial = |l: f64| 2.0 / l + 0.5 / l.powi(4);
    radial(outer) - radial(stretch)
}

pub fn inflated(rung: usize) -> Answer {
    let solved = inflate(rung, 2.0);
    solved.answer(vec![("p / mu", inner_pressure(&solved), inflation_pressure(2.0))])
}
