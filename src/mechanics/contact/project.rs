//! The point of a deformable counterpart's face that a point of the touched face meets.

use crate::mechanics::element::ShapeFunctions;
use glam::Vec3A;
use obvhs::aabb::Aabb;
use obvhs::bvh2::{Bvh2, builder::build_bvh2};
use obvhs::{BvhBuildParams, ray::Ray};
use std::time::Duration;

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
}

/// Where a line along the touched face's normal meets the counterpart.
#[derive(Debug, Clone)]
pub struct Hit {
    /// The facet.
    pub facet: usize,
    /// Values of its shape functions there.
    pub value: [f64; 9],
    /// Their local gradients.
    pub gradient: [[f64; 2]; 9],
    /// How its local coordinates move with the motion of the line across itself.
    pub slide: [[f64; 3]; 2],
    /// Slopes of the facet's tangents towards the line.
    pub slopes: [f64; 2],
    /// Distance from the counterpart along the line, mm; negative inside the counterpart.
    pub gap: f64,
}

/// How far outside a facet, in local coordinates, a point still counts as above it.
const MARGIN: f64 = 1e-9;
/// Newton steps of a projection.
const STEPS: usize = 20;

/// Facets in their present positions: 3 or 9 nodes each, all with the same side outward.
pub struct OtherFace<'a> {
    /// 2 or 3, the dimensions of space.
    dim: usize,
    /// Positions of the nodes of each facet.
    facets: &'a [Vec<[f64; 3]>],
    /// A direction out of the counterpart, to orient the normals.
    outward: [f64; 3],
    /// Over the boxes of the facets' spheres.
    tree: Bvh2,
    /// Half the length of a line that passes them all from anywhere near, mm.
    reach: f64,
}

/// Room of a facet's box for single precision, as a share of its size.
const ROOM: f64 = 1e-3;

impl<'a> OtherFace<'a> {
    /// Of facets in a space of `dim` dimensions.
    pub fn new(dim: usize, facets: &'a [Vec<[f64; 3]>], outward: [f64; 3]) -> Self {
        let corner = |x: [f64; 3]| Vec3A::from_array(x.map(|c| c as f32));
        let of = |nodes: &Vec<[f64; 3]>| {
            let (middle, radius) = sphere(nodes);
            let [low, high] = [-1.0, 1.0].map(|side| corner(middle.map(|c| c + side * radius * (1.0 + ROOM))));
            Aabb::new(low, high)
        };
        let boxes: Vec<Aabb> = facets.iter().map(of).collect();
        let tree = build_bvh2(&boxes, BvhBuildParams::fastest_build(), &mut Duration::default());
        let all = boxes.iter().fold(Aabb::empty(), |all, one| all.union(one));
        let reach = if facets.is_empty() { 0.0 } else { f64::from(all.diagonal().length()) };
        Self { dim, facets, outward, tree, reach }
    }

    /// Facets whose sphere the line through `x` along `direction` passes, ascending.
    fn along(&self, x: [f64; 3], direction: [f64; 3]) -> Vec<usize> {
        if self.facets.is_empty() {
            return Vec::new();
        }
        // From beyond them all: as far as they are apart, and as far as `x` is from one of them.
        let far = self.reach + distance(x, self.facets[0][0]);
        let from = [0, 1, 2].map(|i| (x[i] - far * direction[i]) as f32);
        let direction_f32 = Vec3A::from_array(direction.map(|c| c as f32));
        let ray = Ray::new(Vec3A::from_array(from), direction_f32, 0.0, 2.0 * far as f32);
        let mut found = Vec::new();
        self.tree.ray_traverse_anyhit(ray, |_, place| {
            let facet = self.tree.primitive_indices[place] as usize;
            let (middle, radius) = sphere(&self.facets[facet]);
            if lateral(direction, x, middle) <= radius {
                found.push(facet);
            }
        });
        found.sort_unstable();
        found
    }

    /// The foot of a point; `None` where no facet lies below it.
    pub fn foot(&self, x: [f64; 3]) -> Option<Foot> {
        let feet =
            self.along(x, self.outward).into_iter().filter_map(|facet| self.project(facet, &self.facets[facet], x));
        nearest(feet, |foot| foot.gap)
    }

    fn project(&self, facet: usize, nodes: &[[f64; 3]], x: [f64; 3]) -> Option<Foot> {
        let axes = self.dim - 1;
        let mut xi = [0.0; 3];
        for _ in 0..STEPS {
            let shape = ShapeFunctions::at(axes, xi);
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
        let shape = ShapeFunctions::at(axes, xi);
        let (foot, tangents) = self.place(nodes, &shape);
        let mut normal =
            if axes == 1 { [-tangents[0][1], tangents[0][0], 0.0] } else { cross(tangents[0], tangents[1]) };
        let length = dot(normal, normal).sqrt() * dot(normal, self.outward).signum();
        normal = normal.map(|c| c / length);
        let mut value = [0.0; 9];
        value[..nodes.len()].copy_from_slice(&shape.value[..nodes.len()]);
        Some(Foot { facet, value, normal, gap: dot(normal, subtract(x, foot)) })
    }

    /// Where the line through `x` along `normal` (out of the counterpart) meets the face; `None` where it does not.
    pub fn hit(&self, x: [f64; 3], normal: [f64; 3], across: [[f64; 3]; 2]) -> Option<Hit> {
        let facets = self.along(x, normal).into_iter();
        nearest(facets.filter_map(|facet| self.cross(facet, &self.facets[facet], x, normal, across)), |hit| hit.gap)
    }

    fn cross(
        &self,
        facet: usize,
        nodes: &[[f64; 3]],
        x: [f64; 3],
        normal: [f64; 3],
        across: [[f64; 3]; 2],
    ) -> Option<Hit> {
        let axes = self.dim - 1;
        let mut xi = [0.0; 3];
        for _ in 0..STEPS {
            let shape = ShapeFunctions::at(axes, xi);
            let (place, tangents) = self.place(nodes, &shape);
            let slide = slides(axes, across, tangents)?;
            let away = subtract(x, place);
            let mut last: f64 = 0.0;
            for axis in 0..axes {
                let step = dot(slide[axis], away);
                last = last.max(step.abs());
                xi[axis] = (xi[axis] + step).clamp(-1.5, 1.5);
            }
            if last < 1e-13 {
                break;
            }
        }
        if xi.iter().any(|c| c.abs() > 1.0 + MARGIN) {
            return None;
        }
        let shape = ShapeFunctions::at(axes, xi);
        let (place, tangents) = self.place(nodes, &shape);
        let slide = slides(axes, across, tangents)?;
        let away = subtract(x, place);
        if slide.iter().any(|slide| dot(*slide, away).abs() > 1e-9) {
            return None;
        }
        let mut hit = Hit {
            facet,
            value: [0.0; 9],
            gradient: [[0.0; 2]; 9],
            slide,
            slopes: tangents.map(|t| dot(t, normal)),
            gap: dot(normal, away),
        };
        for a in 0..nodes.len() {
            hit.value[a] = shape.value[a];
            hit.gradient[a] = [shape.gradient[a][0], shape.gradient[a][1]];
        }
        Some(hit)
    }

    fn place(&self, nodes: &[[f64; 3]], shape: &ShapeFunctions) -> ([f64; 3], [[f64; 3]; 2]) {
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

/// The first of those with the least distance.
fn nearest<T>(found: impl Iterator<Item = T>, gap: impl Fn(&T) -> f64) -> Option<T> {
    found.reduce(|best, next| if gap(&next).abs() < gap(&best).abs() { next } else { best })
}

/// A facet's middle, and its largest extent from there.
fn sphere(nodes: &[[f64; 3]]) -> ([f64; 3], f64) {
    (nodes[nodes.len() / 2], distance(nodes[0], nodes[nodes.len() - 1]))
}

/// How local coordinates move with points above: the inverse of the components of a facet's tangents along `across`,
/// times these. Along the facet's own tangents these are their duals. `None` where the facet is edge-on.
pub fn slides(axes: usize, across: [[f64; 3]; 2], tangents: [[f64; 3]; 2]) -> Option<[[f64; 3]; 2]> {
    let m = across.map(|a| tangents.map(|t| dot(a, t)));
    if axes == 1 {
        return (m[0][0] != 0.0).then(|| [across[0].map(|c| c / m[0][0]), [0.0; 3]]);
    }
    let determinant = m[0][0] * m[1][1] - m[0][1] * m[1][0];
    let row = |p: f64, q: f64| [0, 1, 2].map(|i| (p * across[0][i] + q * across[1][i]) / determinant);
    (determinant != 0.0).then(|| [row(m[1][1], -m[0][1]), row(-m[1][0], m[0][0])])
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

/// Vector product.
pub fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A bent face of 12 x 9 facets of uneven sizes, in three dimensions.
    fn bent() -> Vec<Vec<[f64; 3]>> {
        let at = |i: f64, j: f64| [0.1 * i * i - 5.0, 1.3 * j - 6.0, 0.4 * i.sin() + 0.02 * j * j];
        let facet = |k: usize| {
            let (i, j) = ((k % 12) as f64, (k / 12) as f64);
            (0..9).map(|a| at(i + 0.5 * (a % 3) as f64, j + 0.5 * (a / 3) as f64)).collect()
        };
        (0..108).map(facet).collect()
    }

    #[test]
    fn the_tree_misses_no_facet_that_a_line_passes() {
        let facets = bent();
        // Lines of 500 along which a face is not met where the facets are, and how often they are.
        let tried = |face: &OtherFace| {
            let (mut missed, mut passed) = (0, 0);
            for k in 0..500 {
                let turn = |scale: f64| (f64::from(k) * scale).fract() - 0.5;
                let x = [20.0 * turn(0.618_034), 16.0 * turn(0.754_878), 300.0 * turn(0.569_84).powi(3)];
                let tilt = [turn(0.819_173), turn(0.671_044), 1.0];
                let direction = tilt.map(|c| c / dot(tilt, tilt).sqrt());
                let near = |nodes: &Vec<[f64; 3]>| lateral(direction, x, nodes[4]) <= distance(nodes[0], nodes[8]);
                let all: Vec<usize> = (0..facets.len()).filter(|&facet| near(&facets[facet])).collect();
                missed += usize::from(face.along(x, direction) != all);
                passed += all.len();
            }
            (missed, passed)
        };
        let (missed, passed) = tried(&OtherFace::new(3, &facets, [0.0, 0.0, 1.0]));
        assert!(missed == 0 && passed > 1000, "{missed} of {passed}");
        // One facet is lost.
        assert!(tried(&OtherFace::new(3, &facets[..facets.len() - 1], [0.0, 0.0, 1.0])).0 > 0);
    }
}
