//! Cook's membrane with plain bilinear displacement elements: the fault that mixed elements cure.

use tirtouch::mechanics::mesh::shapes;
use tirtouch::mechanics::sparse::SparseLdl;
use tirtouch::stability::membrane::SHEAR;

/// Deflection of the loaded edge's middle with plain bilinear elements, 2 x 2 Gauss points.
pub fn bilinear_cook(lambda: f64, n: usize) -> f64 {
    // The nodes of half as many biquadratic elements are those of a bilinear mesh.
    let mesh = shapes::cook(n / 2).unwrap();
    let cells: Vec<[u32; 4]> = (0..mesh.element_count())
        .flat_map(|e| {
            let q = mesh.element(e);
            [0, 1, 3, 4].map(|k| [q[k], q[k + 1], q[k + 3], q[k + 4]])
        })
        .collect();
    let free: Vec<u32> = (0u32..).zip(&mesh.nodes).filter(|(_, x)| x[0] > 0.0).map(|(node, _)| node).collect();
    let equation = |node: u32, axis: u32| free.binary_search(&node).ok().map(|k| 2 * k as u32 + axis);
    let equations = |cell: &[u32; 4]| [0, 1, 2, 3, 4, 5, 6, 7].map(|k| equation(cell[k / 2], k as u32 % 2));
    let node = |a: &u32| free.binary_search(a).ok().map(|k| k as u32);
    let groups: Vec<Vec<u32>> = cells.iter().map(|cell| cell.iter().filter_map(node).collect()).collect();
    let positions: Vec<[f64; 3]> = free.iter().map(|&a| mesh.nodes[a as usize]).collect();
    let first = (0..=free.len() as u32).map(|k| 2 * k).collect();
    let mut matrix = SparseLdl::new(first, &positions, &groups).unwrap();
    for cell in &cells {
        let stiffness = bilinear_stiffness(cell.map(|a| mesh.nodes[a as usize]), lambda);
        let numbers = equations(cell);
        for (i, row) in numbers.iter().enumerate() {
            for (j, column) in numbers.iter().enumerate() {
                if let (Some(row), Some(column)) = (row, column)
                    && row >= column
                {
                    let place = matrix.position(*row, *column).unwrap();
                    matrix.values[place] += stiffness[i][j];
                }
            }
        }
    }
    let mut right = vec![0.0; 2 * free.len()];
    for (node, x) in (0u32..).zip(&mesh.nodes).filter(|(_, x)| x[0] == 48.0) {
        let end = x[1] == 44.0 || x[1] == 60.0;
        right[equation(node, 1).unwrap() as usize] = if end { 0.5 } else { 1.0 } / n as f64;
    }
    matrix.factorize().unwrap();
    matrix.solve(&mut right);
    let middle = mesh.nodes.iter().position(|x| x[0] == 48.0 && (x[1] - 52.0).abs() < 1e-9).unwrap();
    right[equation(middle as u32, 1).unwrap() as usize]
}

/// Stiffness of a quadrilateral, its nodes on a lattice of 2 x 2.
fn bilinear_stiffness(nodes: [[f64; 3]; 4], lambda: f64) -> [[f64; 8]; 8] {
    let mut stiffness = [[0.0; 8]; 8];
    let at = 1.0 / 3.0f64.sqrt();
    for [xi, eta] in [[-at, -at], [at, -at], [-at, at], [at, at]] {
        let local: [[f64; 2]; 4] = [0, 1, 2, 3].map(|a| {
            let (s, t) = ([-1.0, 1.0][a % 2], [-1.0, 1.0][a / 2]);
            [0.25 * s * (1.0 + t * eta), 0.25 * t * (1.0 + s * xi)]
        });
        let mut jacobian = [[0.0; 2]; 2];
        for (node, gradient) in nodes.iter().zip(&local) {
            (0..4).for_each(|k| jacobian[k / 2][k % 2] += node[k / 2] * gradient[k % 2]);
        }
        let [[a, b], [c, d]] = jacobian;
        let det = a * d - b * c;
        let gradient = local.map(|[s, t]| [(s * d - t * c) / det, (t * a - s * b) / det]);
        for i in 0..8 {
            for j in 0..8 {
                let (m, n, g, h) = (i % 2, j % 2, gradient[i / 2], gradient[j / 2]);
                let same = if m == n { g[0] * h[0] + g[1] * h[1] } else { 0.0 };
                stiffness[i][j] += det * (lambda * g[m] * h[n] + SHEAR * (same + g[n] * h[m]));
            }
        }
    }
    stiffness
}
