//! The nearest point of a deformable counterpart's face.

use crate::mechanics::element::{Shape, lagrange};

/// A point of the counterpart's face.
#[derive(Debug, Clone)]
pub struct Foot {
    /// The facet.
    pub facet: usize,
    /// Values of its shape functions there.
    pub value: [f64; 9],
    /// Unit normal, outward from the counterpart.
    pub normal: [f64; 3],
    /// Distance along the normal, mm; negative inside the counterpart.
    pub gap: f64,
    /// How the gap bends as points move.
    pub bend: Bend,
}

/// First and second derivatives of a facet at a foot.
#[derive(Debug, Clone)]
pub struct Bend {
    /// Tangents along the local axes.
    pub tangents: [[f64; 3]; 2],
    /// Inverse of the metric.
    pub metric: [[f64; 2]; 2],
    /// Local gradients of the shape functions.
    pub gradient: [[f64; 2]; 9],
    /// Normal part of the second derivatives of the position.
    pub curvature: [[f64; 2]; 2],
}

/// How far outside a facet, in local coordinates, a point still counts as above it.
const MARGIN: f64 = 1e-9;
/// Newton steps of a projection.
const STEPS: usize = 20;

/// Facets in their present positions: 3 or 9 nodes each, all with the same side outward.
pub struct Face<'a> {
    /// 2 or 3, the dimensions of space.
    pub dim: usize,
    /// Positions of the nodes of each facet.
    pub facets: &'a [Vec<[f64; 3]>],
    /// A direction out of the counterpart, to orient the normals.
    pub outward: [f64; 3],
}

impl Face<'_> {
    /// The foot of a point; `None` where no facet lies below it.
    pub fn foot(&self, x: [f64; 3]) -> Option<Foot> {
        let mut best: Option<Foot> = None;
        for (k, nodes) in self.facets.iter().enumerate() {
            let middle = nodes[nodes.len() / 2];
            let size = distance(nodes[0], nodes[nodes.len() - 1]);
            if lateral(self.outward, x, middle) > size {
                continue;
            }
            if let Some(foot) = self.project(k, nodes, x)
                && best.as_ref().is_none_or(|b| foot.gap.abs() < b.gap.abs())
            {
                best = Some(foot);
            }
        }
        best
    }

    fn project(&self, facet: usize, nodes: &[[f64; 3]], x: [f64; 3]) -> Option<Foot> {
        let axes = self.dim - 1;
        let mut xi = [0.0; 3];
        for _ in 0..STEPS {
            let shape = Shape::at(axes, xi);
            let (foot, tangents) = self.place(nodes, &shape);
            let away = subtract(x, foot);
            // Gauss-Newton on the tangential distances.
            let r = [dot(away, tangents[0]), dot(away, tangents[1])];
            let m = [dot(tangents[0], tangents[0]), dot(tangents[0], tangents[1]), dot(tangents[1], tangents[1])];
            let step = if axes == 1 {
                [r[0] / m[0], 0.0]
            } else {
                let determinant = m[0] * m[2] - m[1] * m[1];
                [(m[2] * r[0] - m[1] * r[1]) / determinant, (m[0] * r[1] - m[1] * r[0]) / determinant]
            };
            for axis in 0..axes {
                xi[axis] = (xi[axis] + step[axis]).clamp(-1.5, 1.5);
            }
            if step[0].abs().max(step[1].abs()) < 1e-13 {
                break;
            }
        }
        if xi.iter().any(|c| c.abs() > 1.0 + MARGIN) {
            return None;
        }
        let shape = Shape::at(axes, xi);
        let (foot, tangents) = self.place(nodes, &shape);
        let mut normal = if axes == 1 { [-tangents[0][1], tangents[0][0], 0.0] } else { cross(tangents[0], tangents[1]) };
        let length = dot(normal, normal).sqrt() * dot(normal, self.outward).signum();
        normal = normal.map(|c| c / length);
        let mut value = [0.0; 9];
        value[..nodes.len()].copy_from_slice(&shape.value[..nodes.len()]);
        let bend = bend(axes, nodes, xi, &shape, tangents, normal);
        Some(Foot { facet, value, normal, gap: dot(normal, subtract(x, foot)), bend })
    }

    fn place(&self, nodes: &[[f64; 3]], shape: &Shape) -> ([f64; 3], [[f64; 3]; 2]) {
        let mut point = [0.0; 3];
        let mut tangents = [[0.0; 3]; 2];
        for (a, node) in nodes.iter().enumerate() {
            for i in 0..3 {
                point[i] += shape.value[a] * node[i];
                tangents[0][i] += shape.gradient[a][0] * node[i];
                tangents[1][i] += shape.gradient[a][1] * node[i];
            }
        }
        (point, tangents)
    }
}

fn bend(
    axes: usize,
    nodes: &[[f64; 3]],
    xi: [f64; 3],
    shape: &Shape,
    tangents: [[f64; 3]; 2],
    normal: [f64; 3],
) -> Bend {
    let m = [[0, 0], [0, 1], [1, 1]].map(|[i, j]| dot(tangents[i], tangents[j]));
    let metric = if axes == 1 {
        [[1.0 / m[0], 0.0], [0.0, 0.0]]
    } else {
        let determinant = m[0] * m[2] - m[1] * m[1];
        [[m[2] / determinant, -m[1] / determinant], [-m[1] / determinant, m[0] / determinant]]
    };
    let second = second_derivatives(axes, xi);
    let mut bend = Bend { tangents, metric, gradient: [[0.0; 2]; 9], curvature: [[0.0; 2]; 2] };
    for (a, node) in nodes.iter().enumerate() {
        bend.gradient[a] = [shape.gradient[a][0], shape.gradient[a][1]];
        let along = dot(*node, normal);
        for i in 0..2 {
            for j in 0..2 {
                bend.curvature[i][j] += second[a][i][j] * along;
            }
        }
    }
    bend
}

/// Second derivatives of a facet's shape functions.
fn second_derivatives(axes: usize, xi: [f64; 3]) -> [[[f64; 2]; 2]; 9] {
    let lines = [lagrange(xi[0]), lagrange(xi[1])];
    let twice = [1.0, -2.0, 1.0];
    let mut second = [[[0.0; 2]; 2]; 9];
    for (a, d) in second.iter_mut().enumerate().take(3usize.pow(axes as u32)) {
        let (i, j) = (a % 3, a / 3);
        if axes == 1 {
            d[0][0] = twice[i];
        } else {
            let mixed = lines[0][i][1] * lines[1][j][1];
            *d = [[twice[i] * lines[1][j][0], mixed], [mixed, lines[0][i][0] * twice[j]]];
        }
    }
    second
}

/// Distance of two points across a direction.
fn lateral(direction: [f64; 3], a: [f64; 3], b: [f64; 3]) -> f64 {
    let d = subtract(a, b);
    let along = dot(d, direction);
    (dot(d, d) - along * along).max(0.0).sqrt()
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    let d = subtract(a, b);
    dot(d, d).sqrt()
}

/// a - b.
pub fn subtract(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// Scalar product.
pub fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
