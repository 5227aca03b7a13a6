//! How good a mesh is: Jacobians, aspect ratios, measures.

use super::{Mesh, MeshError};

/// Positions and weights of three-point Gauss quadrature on (-1, 1).
const GAUSS: [(f64, f64); 3] =
    [(-0.774_596_669_241_483_4, 5.0 / 9.0), (0.0, 8.0 / 9.0), (0.774_596_669_241_483_4, 5.0 / 9.0)];

/// The quality of a mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quality {
    /// Number of elements.
    pub elements: usize,
    /// Number of nodes.
    pub nodes: usize,
    /// Smallest Jacobian determinant at the quadrature points, in units of the element's mean.
    pub least_jacobian: f64,
    /// Smallest scaled Jacobian (determinant over the product of its columns' lengths) at nodes and quadrature points:
    /// 1 for bricks, 0 for a collapsed angle.
    pub least_scaled_jacobian: f64,
    /// Largest ratio of an element's lengths along its axes, in its middle.
    pub worst_aspect: f64,
}

/// Values and slopes of the three quadratic shape functions at `x`.
fn shapes(x: f64) -> [[f64; 3]; 2] {
    [[0.5 * x * (x - 1.0), 1.0 - x * x, 0.5 * x * (x + 1.0)], [x - 0.5, -2.0 * x, x + 0.5]]
}

/// Position in an element at local coordinates.
pub(super) fn position(dim: usize, nodes: &[[f64; 3]], local: [f64; 3]) -> [f64; 3] {
    weighted(nodes, |a| (0..dim).map(|axis| shapes(local[axis])[0][a / 3usize.pow(axis as u32) % 3]).product())
}

fn weighted(nodes: &[[f64; 3]], weight: impl Fn(usize) -> f64) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for (a, node) in nodes.iter().enumerate() {
        let w = weight(a);
        (0..3).for_each(|i| sum[i] += w * node[i]);
    }
    sum
}

/// Determinant of an element's Jacobian at local coordinates and the lengths of its columns.
pub(super) fn jacobian(dim: usize, nodes: &[[f64; 3]], local: [f64; 3]) -> (f64, [f64; 3]) {
    let mut columns = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let shape = local.map(shapes);
    for (along, column) in columns.iter_mut().enumerate().take(dim) {
        *column = weighted(nodes, |a| {
            (0..dim).map(|axis| shape[axis][usize::from(axis == along)][a / 3usize.pow(axis as u32) % 3]).product()
        });
    }
    let [a, b, c] = columns;
    let determinant =
        a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0]);
    (determinant, columns.map(|column| column.iter().map(|x| x * x).sum::<f64>().sqrt()))
}

/// Local coordinates and weights of the 3^dim Gauss points.
fn gauss(dim: usize) -> impl Iterator<Item = ([f64; 3], f64)> {
    (0..3usize.pow(dim as u32)).map(move |k| {
        let along = |axis: usize| if axis < dim { GAUSS[k / 3usize.pow(axis as u32) % 3] } else { (0.0, 1.0) };
        let [x, y, z] = [along(0), along(1), along(2)];
        ([x.0, y.0, z.0], x.1 * y.1 * z.1)
    })
}

/// An error that names the first element with a Jacobian not positive at a quadrature point.
pub(super) fn unfolded(mesh: &Mesh) -> Result<(), MeshError> {
    for element in 0..mesh.element_count() {
        let nodes = mesh.element_positions(element);
        let least = gauss(mesh.dim).map(|(at, _)| jacobian(mesh.dim, &nodes, at).0).fold(f64::INFINITY, f64::min);
        if least.is_nan() || least <= 0.0 {
            let at_mm = position(mesh.dim, &nodes, [0.0; 3]);
            return Err(MeshError::Folded { element, at_mm, jacobian: least });
        }
    }
    Ok(())
}

impl Mesh {
    /// Positions of an element's nodes, mm.
    pub fn element_positions(&self, element: usize) -> Vec<[f64; 3]> {
        self.element(element).iter().map(|&node| self.nodes[node as usize]).collect()
    }

    /// Integral of `function` (region, position in mm) over the mesh by 3^dim Gauss points an element.
    pub fn integral(&self, function: impl Fn(u32, [f64; 3]) -> f64) -> f64 {
        let over = |element: usize| {
            let nodes = self.element_positions(element);
            let at = |(local, weight)| {
                let value = function(self.region[element], position(self.dim, &nodes, local));
                weight * value * jacobian(self.dim, &nodes, local).0
            };
            gauss(self.dim).map(at).sum::<f64>()
        };
        (0..self.element_count()).map(over).sum()
    }

    /// Jacobians and aspect ratios of all elements.
    pub fn quality(&self) -> Quality {
        let (mut least_jacobian, mut least_scaled, mut worst_aspect) = (f64::INFINITY, f64::INFINITY, 1.0_f64);
        for element in 0..self.element_count() {
            let nodes = self.element_positions(element);
            let corners_and_middles = (0..nodes.len()).map(|a| [a % 3, a / 3 % 3, a / 9].map(|i| i as f64 - 1.0));
            let inside: Vec<f64> = gauss(self.dim).map(|(at, _)| jacobian(self.dim, &nodes, at).0).collect();
            let mean = inside.iter().sum::<f64>() / inside.len() as f64;
            least_jacobian = inside.iter().fold(least_jacobian, |least, determinant| least.min(determinant / mean));
            for at in corners_and_middles.chain(gauss(self.dim).map(|(at, _)| at)) {
                let (determinant, lengths) = jacobian(self.dim, &nodes, at);
                least_scaled = least_scaled.min(determinant / lengths.iter().product::<f64>());
            }
            let lengths = jacobian(self.dim, &nodes, [0.0; 3]).1;
            let longest = lengths[..self.dim].iter().copied().fold(0.0, f64::max);
            worst_aspect = worst_aspect.max(longest / lengths[..self.dim].iter().copied().fold(longest, f64::min));
        }
        Quality {
            elements: self.element_count(),
            nodes: self.nodes.len(),
            least_jacobian,
            least_scaled_jacobian: least_scaled,
            worst_aspect,
        }
    }
}

/// Length of an edge, or area of a face, by Gauss quadrature.
#[cfg(test)]
pub(super) fn face_measure(dim: usize, nodes: &[[f64; 3]]) -> f64 {
    let mut sum = 0.0;
    for (at, weight) in gauss(dim - 1) {
        let tangent = |along: usize| {
            weighted(nodes, |a| {
                (0..dim - 1).map(|i| shapes(at[i])[usize::from(i == along)][a / 3usize.pow(i as u32) % 3]).product()
            })
        };
        let t = tangent(0);
        let s = if dim == 3 { tangent(1) } else { [0.0, 0.0, 1.0] };
        let normal = [t[1] * s[2] - t[2] * s[1], t[2] * s[0] - t[0] * s[2], t[0] * s[1] - t[1] * s[0]];
        sum += weight * normal.iter().map(|x| x * x).sum::<f64>().sqrt();
    }
    sum
}
