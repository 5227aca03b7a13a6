//! A flat frictionless punch on a layer bonded to a rigid base (Hayes et al., J. Biomech. 5, 1972), and on a half
//! space.

use super::{Answer, Solved, graded, held, on_a_base, touched};
use tirtouch::mechanics::kinematics::Kinematics;
use tirtouch::mechanics::material::Material;
use tirtouch::mechanics::mesh::{Footprint, Mesh, PhantomMesh, PhantomShape};
use tirtouch::mechanics::problem::Problem;
use tirtouch::mechanics::read_out::{reactions, traction_forces};

/// a/h and kappa at nu = 0.45 and 0.5: force P = 2 E a w kappa/(1 - nu^2).
pub const KAPPA: [[f64; 3]; 4] =
    [[0.2, 1.2523, 1.2806], [0.4, 1.5993, 1.6837], [1.0, 3.0914, 3.6187], [2.0, 6.4206, 9.1495]];

/// Distance to the base and to the side that counts as infinite, mm: a far base stiffens by about 0.8 a over it.
const FAR: f64 = 4000.0;

/// A layer with elements graded to the edge of a contact of 1 mm.
fn layer(height: f64, radius: f64, rung: usize) -> Mesh {
    PhantomMesh {
        shape: PhantomShape::Cylinder { radius_mm: radius, height_mm: height },
        inclusions: Vec::new(),
        footprint: Footprint::Round { radius_mm: 1.0 },
        symmetry: [true, false],
        resolution: graded(0.01, 0.2, 0.4 * height, 0.6, rung),
        offset_mm: [0.0; 2],
        layers_mm: Vec::new(),
    }
    .build_2d()
    .unwrap()
}

/// kappa of a layer of height 1/`a_over_h` under a punch of radius 1 mm pressed by 1 mm (linear, E = 1).
pub fn kappa(rung: usize, a_over_h: f64, poisson: f64, exact: f64) -> Answer {
    let height = 1.0 / a_over_h;
    let solved = punch(rung, height, 1.0 + 8.0 * height, poisson);
    solved.answer(vec![("kappa", force(&solved) * (1.0 - poisson * poisson) / 2.0, exact)])
}

/// Force over 2 E* a w on a half space.
pub fn half_space(rung: usize, poisson: f64) -> Answer {
    let solved = punch(rung, FAR, FAR, poisson);
    solved.answer(vec![("P / (2 E* a w)", force(&solved) * (1.0 - poisson * poisson) / 2.0, 1.0)])
}

fn punch(rung: usize, height: f64, radius: f64, poisson: f64) -> Solved {
    let mesh = layer(height, radius, rung);
    let mut supports = on_a_base(&mesh, height, 0.0);
    supports.extend(held(&mesh, under_punch, 1, |_| 1.0));
    solve(mesh, supports, Vec::new(), poisson)
}

fn under_punch(x: [f64; 3]) -> bool {
    x[1] == 0.0 && x[0] <= 1.0 + 1e-9
}

fn force(solved: &Solved) -> f64 {
    let forces = reactions(&solved.problem, &solved.state).unwrap();
    solved.problem.mesh.nodes.iter().zip(&forces).filter(|(x, _)| under_punch(**x)).map(|(_, f)| f[1]).sum()
}

/// Deflection of a half space by a uniform pressure of 1 on a disc of 1 mm (E = 1), in its middle and at its edge.
pub fn disc_pressure(rung: usize, poisson: f64) -> Answer {
    let mesh = layer(FAR, FAR, rung);
    let supports = on_a_base(&mesh, FAR, 0.0);
    let forces =
        traction_forces(Kinematics::Axisymmetric, &mesh, &touched(&mesh, 1.0), &|_, normal| normal.map(|n| -n));
    let solved = solve(mesh, supports, forces, poisson);
    let at = |r: f64| {
        let node = solved.problem.mesh.nodes.iter().position(|x| x[1] == 0.0 && (x[0] - r).abs() < 1e-9).unwrap();
        solved.state.displacement[node][1]
    };
    let plane = 1.0 - poisson * poisson;
    solved.answer(vec![("middle, mm", at(0.0), 2.0 * plane), ("edge, mm", at(1.0), 4.0 * plane / std::f64::consts::PI)])
}

fn solve(
    mesh: Mesh,
    supports: Vec<tirtouch::mechanics::problem::Support>,
    forces: Vec<(u32, [f64; 3])>,
    poisson: f64,
) -> Solved {
    let materials = vec![Material::linear(1.0, poisson).unwrap()];
    let kinematics = Kinematics::Axisymmetric;
    Solved::new(Problem { supports, forces, ..Problem::free(kinematics, mesh, materials) }, &[1.0]).unwrap()
}
