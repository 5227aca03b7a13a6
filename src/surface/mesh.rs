//! The touched face as triangles in a bounding-volume tree.

use glam::Vec3A;
use obvhs::{BvhBuildParams, bvh2::builder::build_bvh2, triangle::Triangle};
use std::time::Duration;

/// Triangles in the order of the tree's leaves, with the tree.
#[derive(Debug, Clone)]
pub struct Mesh {
    /// Corners of each triangle, counter-clockwise seen from above, mm.
    pub corners: Vec<[[f64; 3]; 3]>,
    /// Upward unit normals at the corners (of the facet where facets are flat).
    pub normals: Vec<[[f64; 3]; 3]>,
    /// Nodes of the tree; the root is the first.
    pub nodes: Vec<Node>,
    /// Lowest height of the mesh, mm.
    pub low_mm: f64,
    /// Highest height of the mesh, mm.
    pub high_mm: f64,
}

/// A node of the tree: a box over two children, or over triangles.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Node {
    /// Lowest corner, mm.
    pub low: [f32; 3],
    /// Triangles in this leaf; 0: an inner node.
    pub count: u32,
    /// Highest corner, mm.
    pub high: [f32; 3],
    /// First triangle, or first of two neighbouring children.
    pub first: u32,
}

impl Mesh {
    /// Builds the tree. Facets are turned to face upward; vertical ones are kept as they are.
    ///
    /// `smooth` interpolates normals between vertices, weighted by facet area. `None` for a mesh without triangles or
    /// with an index out of range.
    pub fn build(vertices: &[[f64; 3]], triangles: &[[u32; 3]], smooth: bool) -> Option<Self> {
        let corner = |i: u32| vertices.get(i as usize).copied();
        let mut faces = Vec::with_capacity(triangles.len());
        let mut at_vertex = vec![[0.0; 3]; vertices.len()];
        for t in triangles {
            let mut index = *t;
            let mut c = [corner(t[0])?, corner(t[1])?, corner(t[2])?];
            let mut facet = cross(sub(c[1], c[0]), sub(c[2], c[0]));
            if facet[2] < 0.0 {
                c.swap(1, 2);
                index.swap(1, 2);
                facet = facet.map(|v| -v);
            }
            if dot(facet, facet) == 0.0 {
                continue;
            }
            for i in index {
                let sum = &mut at_vertex[i as usize];
                *sum = [sum[0] + facet[0], sum[1] + facet[1], sum[2] + facet[2]];
            }
            faces.push((index, c, facet));
        }
        if faces.is_empty() {
            return None;
        }
        let triangle = |c: &[[f64; 3]; 3]| {
            let v = c.map(|p| Vec3A::from_array(p.map(|x| x as f32)));
            Triangle { v0: v[0], v1: v[1], v2: v[2] }
        };
        let boxes: Vec<Triangle> = faces.iter().map(|(_, c, _)| triangle(c)).collect();
        let tree = build_bvh2(&boxes, BvhBuildParams::medium_build(), &mut Duration::default());
        let order = tree.primitive_indices.iter().map(|&k| &faces[k as usize]);
        let (mut corners, mut normals) = (Vec::new(), Vec::new());
        for (index, c, facet) in order {
            corners.push(*c);
            normals.push(index.map(|i| unit(if smooth { at_vertex[i as usize] } else { *facet })));
        }
        let nodes = tree
            .nodes
            .iter()
            .map(|n| Node {
                low: n.aabb.min.to_array(),
                count: n.prim_count,
                high: n.aabb.max.to_array(),
                first: n.first_index,
            })
            .collect();
        let heights = || corners.iter().flatten().map(|p| p[2]);
        Some(Self {
            low_mm: heights().fold(f64::INFINITY, f64::min),
            high_mm: heights().fold(f64::NEG_INFINITY, f64::max),
            corners,
            normals,
            nodes,
        })
    }
}

impl Mesh {
    /// Largest slope of a facet, mm/mm; infinite where one stands upright.
    pub fn steepest(&self) -> f64 {
        let slope = |c: &[[f64; 3]; 3]| {
            let facet = cross(sub(c[1], c[0]), sub(c[2], c[0]));
            facet[0].hypot(facet[1]) / facet[2].abs()
        };
        self.corners.iter().map(slope).fold(0.0, f64::max)
    }
}

fn sub(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn unit(a: [f64; 3]) -> [f64; 3] {
    let length = dot(a, a).sqrt();
    a.map(|v| v / length)
}
