//! Gauss points of a touched facet, with the hats of its nodes.

use super::project::dot;
use crate::mechanics::element::{GAUSS_3, ShapeFunctions};
use crate::mechanics::kinematics::Kinematics;

/// A Gauss point of the touched face.
#[derive(Debug, Clone)]
pub struct TouchPoint {
    /// The facet.
    pub facet: usize,
    /// ShapeFunctions functions of the facet's nodes.
    pub shape: [f64; 9],
    /// Their local gradients.
    pub gradient: [[f64; 2]; 9],
    /// Hats of the facet's nodes: linear on half facets.
    pub hat: [f64; 9],
    /// Area that the point stands for, mm^2 (mm in plane strain).
    pub weight: f64,
}

/// Distance from the axis of a point on a facet.
pub fn radius(positions: &[[f64; 3]], point: &TouchPoint) -> f64 {
    positions.iter().zip(&point.shape).map(|(x, n)| n * x[0]).sum()
}

/// Three Gauss points along each half of each axis of a facet, with the hats of its lattice.
pub fn touch_points(kinematics: Kinematics, facet: usize, positions: &[[f64; 3]]) -> Vec<TouchPoint> {
    let axes = kinematics.dim() - 1;
    let line: Vec<[f64; 2]> =
        [-0.5, 0.5].iter().flat_map(|middle| GAUSS_3.map(|[at, weight]| [middle + 0.5 * at, 0.5 * weight])).collect();
    let hats = |xi: f64| [(-xi).max(0.0), 1.0 - xi.abs(), xi.max(0.0)];
    (0..line.len().pow(axes as u32))
        .map(|q| {
            let (i, j) = (q % line.len(), q / line.len());
            let second = if axes == 2 { line[j] } else { [0.0, 1.0] };
            let shape = ShapeFunctions::at(axes, [line[i][0], second[0], 0.0]);
            let mut tangents = [[0.0; 3]; 2];
            for (a, x) in positions.iter().enumerate() {
                for c in 0..3 {
                    tangents[0][c] += shape.gradient[a][0] * x[c];
                    tangents[1][c] += shape.gradient[a][1] * x[c];
                }
            }
            let stretch = match axes {
                1 => dot(tangents[0], tangents[0]).sqrt(),
                _ => {
                    let [a, b] = tangents;
                    (dot(a, a) * dot(b, b) - dot(a, b).powi(2)).max(0.0).sqrt()
                }
            };
            let mut point = TouchPoint { facet, shape: [0.0; 9], gradient: [[0.0; 2]; 9], hat: [0.0; 9], weight: 0.0 };
            for (gradient, local) in point.gradient.iter_mut().zip(&shape.gradient).take(positions.len()) {
                *gradient = [local[0], local[1]];
            }
            let (first, other) = (hats(line[i][0]), hats(second[0]));
            for (a, (shape_a, hat_a)) in point.shape.iter_mut().zip(&mut point.hat).enumerate().take(positions.len()) {
                *shape_a = shape.value[a];
                *hat_a = first[a % 3] * if axes == 2 { other[a / 3] } else { 1.0 };
            }
            point.weight = line[i][1] * second[1] * stretch * kinematics.weight(radius(positions, &point));
            point
        })
        .collect()
}
