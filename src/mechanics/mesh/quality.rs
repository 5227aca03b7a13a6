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

/// Shape functions along each axis at local coordinates: values and slopes; those of axes beyond `dim` are 1
/// and constant.
fn along_axes(dim: usize, local: [f64; 3]) -> [[[f64; 3]; 2]; 3] {
    [0, 1, 2].map(|axis| if axis < dim { shapes(local[axis]) } else { [[1.0, 0.0, 0.0], [0.0; 3]] })
}

/// Sum of an element's nodes, each times the product of its three weights along the axes; x runs fastest.
fn weighted(nodes: &[[f64; 3]], weights: [[f64; 3]; 3]) -> [f64; 3] {
    let [along_x, along_y, along_z] = weights;
    let mut sum = [0.0; 3];
    for (plane, z) in nodes.chunks(9).zip(along_z) {
        for (row, y) in plane.chunks(3).zip(along_y) {
            for (node, x) in row.iter().zip(along_x) {
                let weight = x * y * z;
                (0..3).for_each(|i| sum[i] += weight * node[i]);
            }
        }
    }
    sum
}

/// Position in an element at local coordinates.
pub(super) fn position(dim: usize, nodes: &[[f64; 3]], local: [f64; 3]) -> [f64; 3] {
    weighted(nodes, along_axes(dim, local).map(|[values, _]| values))
}

/// Tangent along one local axis.
fn tangent(nodes: &[[f64; 3]], shape: &[[[f64; 3]; 2]; 3], along: usize) -> [f64; 3] {
    weighted(nodes, [0, 1, 2].map(|axis| shape[axis][usize::from(axis == along)]))
}

/// Determinant of an element's Jacobian at local coordinates and the lengths of its columns.
pub(super) fn jacobian(dim: usize, nodes: &[[f64; 3]], local: [f64; 3]) -> (f64, [f64; 3]) {
    let mut columns = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let shape = along_axes(dim, local);
    for (along, column) in columns.iter_mut().enumerate().take(dim) {
        *column = tangent(nodes, &shape, along);
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
        let shape = along_axes(dim - 1, at);
        let t = tangent(nodes, &shape, 0);
        let s = if dim == 3 { tangent(nodes, &shape, 1) } else { [0.0, 0.0, 1.0] };
        let normal = [t[1] * s[2] - t[2] * s[1], t[2] * s[0] - t[0] * s[2], t[0] * s[1] - t[1] * s[0]];
        sum += weight * normal.iter().map(|x| x * x).sum::<f64>().sqrt();
    }
    sum
}
