//! A smooth incompressible flow of known forces: u = c (sin z + cos y, ...) in three dimensions, c (sin z, cos x) in
//! two.

use tirtouch::mechanics::element::{QuadraturePoint, ShapeFunctions};
use tirtouch::mechanics::kinematics::Kinematics;
use tirtouch::mechanics::mesh::Mesh;
use tirtouch::mechanics::problem::{Problem, State};
use tirtouch::mechanics::solid::{pressure_frame, pressure_functions};

/// Gauss points and weights on [-1, 1]: four, so that errors are not sampled where they happen to vanish.
const GAUSS_4: [[f64; 2]; 4] = [
    [-0.861_136_311_594_052_6, 0.347_854_845_137_453_85],
    [-0.339_981_043_584_856_26, 0.652_145_154_862_546_1],
    [0.339_981_043_584_856_26, 0.652_145_154_862_546_1],
    [0.861_136_311_594_052_6, 0.347_854_845_137_453_85],
];

/// The 4^dim points of an element.
pub fn points(dim: usize) -> Vec<QuadraturePoint> {
    let point = |q: usize| {
        let along = [q % 4, q / 4 % 4, q / 16].map(|k| GAUSS_4[k]);
        let weight = along[..dim].iter().map(|a| a[1]).product();
        QuadraturePoint { shape: ShapeFunctions::at(dim, along.map(|a| a[0])), weight }
    };
    (0..4usize.pow(dim as u32)).map(point).collect()
}

/// Displacement, mm. Its divergence is 0 and its Laplacian is -u.
pub fn displacement(dim: usize, x: [f64; 3]) -> [f64; 3] {
    match dim {
        2 => [x[1].sin(), x[0].cos(), 0.0],
        _ => [x[1].sin() + x[2].cos(), x[2].sin() + x[0].cos(), x[0].sin() + x[1].cos()],
    }
}

/// Pressure (tension positive), kPa, and its gradient.
pub fn pressure(dim: usize, x: [f64; 3]) -> (f64, [f64; 3]) {
    let phase: f64 = 2.0 * x[0] + x[1] + if dim == 3 { x[2] } else { 0.0 };
    let slope = phase.cos();
    (phase.sin(), [2.0 * slope, slope, if dim == 3 { slope } else { 0.0 }])
}

/// Stress for mu = 1, kPa.
pub fn stress(dim: usize, x: [f64; 3]) -> [[f64; 3]; 3] {
    let [[xy, xz], [yx, yz], [zx, zy]] = match dim {
        2 => [[x[1].cos(), 0.0], [-x[0].sin(), 0.0], [0.0, 0.0]],
        _ => [[x[1].cos(), -x[2].sin()], [-x[0].sin(), x[2].cos()], [x[0].cos(), -x[1].sin()]],
    };
    let p = pressure(dim, x).0;
    [[p, xy + yx, xz + zx], [xy + yx, p, yz + zy], [xz + zx, yz + zy, p]]
}

/// Nodal forces of the body force mu u - grad p that holds this flow.
pub fn body_forces(kinematics: Kinematics, mesh: &Mesh) -> Vec<(u32, [f64; 3])> {
    let dim = kinematics.dim();
    let mut forces = vec![[0.0; 3]; mesh.nodes.len()];
    for e in 0..mesh.element_count() {
        let element = mesh.element(e);
        let nodes: Vec<[f64; 3]> = element.iter().map(|&a| mesh.nodes[a as usize]).collect();
        for at in points(dim) {
            let point = kinematics.point(&nodes, &at).unwrap();
            let (u, (_, slope)) = (displacement(dim, point.position), pressure(dim, point.position));
            for (&node, value) in element.iter().zip(at.shape.value) {
                (0..dim).for_each(|i| forces[node as usize][i] += point.volume * value * (u[i] - slope[i]));
            }
        }
    }
    (0u32..).zip(forces).collect()
}

/// L2 norms of the errors of displacement and pressure.
pub fn errors(
    problem: &Problem,
    state: &State,
    displacement: &dyn Fn([f64; 3]) -> [f64; 3],
    pressure: &dyn Fn([f64; 3]) -> f64,
) -> [f64; 2] {
    let dim = problem.kinematics.dim();
    let mut squares = [0.0; 2];
    for e in 0..problem.mesh.element_count() {
        let element = problem.mesh.element(e);
        let nodes: Vec<[f64; 3]> = element.iter().map(|&a| problem.mesh.nodes[a as usize]).collect();
        let frame = pressure_frame(&nodes);
        for at in points(dim) {
            let point = problem.kinematics.point(&nodes, &at).unwrap();
            let exact = displacement(point.position);
            for (i, exact) in exact.iter().enumerate().take(dim) {
                let values = element.iter().zip(at.shape.value).map(|(&a, n)| n * state.displacement[a as usize][i]);
                squares[0] += point.volume * (values.sum::<f64>() - exact).powi(2);
            }
            let functions = pressure_functions(dim, &frame, point.position);
            let coefficients = &state.pressure[e * problem.pressures()..(e + 1) * problem.pressures()];
            let found: f64 = coefficients.iter().zip(&functions).map(|(p, f)| p * f).sum();
            squares[1] += point.volume * (found - pressure(point.position)).powi(2);
        }
    }
    squares.map(f64::sqrt)
}
