//! From loose elements to a mesh: nodes welded, faces of the boundary found and named.

use std::collections::HashMap;

use super::{Boundary, Facet, Lines, Mesh, MeshError, quality};

/// Nodes closer than this share of the smallest distance between neighbouring nodes of an element are one. Round-off is
/// far below, and two nodes of one element far above.
const WELD_SHARE: f64 = 1e-3;

/// Most elements of a mesh. In three dimensions they take 11 million unknowns and 28 GiB.
const MOST_ELEMENTS: usize = 400_000;

/// Collects elements as positions of their nodes.
pub(super) struct Builder {
    dim: usize,
    points: Vec<[f64; 3]>,
    region: Vec<u32>,
}

impl Builder {
    pub fn new(dim: usize) -> Self {
        Self { dim, points: Vec::new(), region: Vec::new() }
    }

    /// Fails where `more` elements would be too many, before they are made.
    pub fn expect_elements(&self, more: usize) -> Result<(), MeshError> {
        let elements = self.region.len().saturating_add(more);
        if elements > MOST_ELEMENTS { Err(MeshError::TooMany { elements, limit: MOST_ELEMENTS }) } else { Ok(()) }
    }

    /// Adds an element by the positions of its nodes; a left-handed one is mirrored along its first axis.
    pub fn add(&mut self, region: u32, at: impl Fn([usize; 3]) -> [f64; 3]) {
        let point = |a: usize| at([a % 3, a / 3 % 3, a / 9]);
        let mut nodes: Vec<[f64; 3]> = (0..3usize.pow(self.dim as u32)).map(point).collect();
        if quality::jacobian(self.dim, &nodes, [0.0; 3]).0 < 0.0 {
            nodes.chunks_mut(3).for_each(<[_]>::reverse);
        }
        self.points.extend(nodes);
        self.region.push(region);
    }

    /// Adds the cells of a tensor grid that `region` gives a region.
    pub fn add_grid(&mut self, axes: &[Lines], region: impl Fn([usize; 3]) -> Option<u32>) -> Result<(), MeshError> {
        let count = |axis: usize| axes.get(axis).map_or(1, Lines::cells);
        self.expect_elements(count(0).saturating_mul(count(1)).saturating_mul(count(2)))?;
        let nodes: Vec<Vec<f64>> = axes.iter().map(Lines::nodes).collect();
        for cell in cells([count(0), count(1), count(2)]) {
            if let Some(region) = region(cell) {
                let along = |local: [usize; 3], axis: usize| {
                    nodes.get(axis).map_or(0.0, |nodes| nodes[2 * cell[axis] + local[axis]])
                };
                self.add(region, |local| [along(local, 0), along(local, 1), along(local, 2)]);
            }
        }
        Ok(())
    }

    /// Welds, and names each face of the boundary by the positions of its nodes.
    pub fn finish(self, name: impl Fn(&[[f64; 3]]) -> Boundary) -> Result<Mesh, MeshError> {
        self.expect_elements(0)?;
        let (nodes, elements) = weld(self.dim, &self.points);
        let mut mesh = Mesh { dim: self.dim, nodes, elements, region: self.region, facets: Vec::new() };
        quality::unfolded(&mesh)?;
        mesh.facets = boundary(&mesh);
        for k in 0..mesh.facets.len() {
            let face: Vec<[f64; 3]> =
                mesh.facet_nodes(mesh.facets[k]).iter().map(|&node| mesh.nodes[node as usize]).collect();
            mesh.facets[k].boundary = name(&face);
        }
        Ok(mesh)
    }
}

/// All cells of a grid, first axis fastest.
pub(super) fn cells(counts: [usize; 3]) -> impl Iterator<Item = [usize; 3]> {
    (0..counts.iter().product()).map(move |k| [k % counts[0], k / counts[0] % counts[1], k / (counts[0] * counts[1])])
}

/// Names the faces of a body between two planes across the last axis.
pub(super) fn between_planes(
    dim: usize,
    touched: f64,
    base: f64,
    symmetry: [bool; 2],
) -> impl Fn(&[[f64; 3]]) -> Boundary {
    let tolerance = 1e-9 * (touched - base).abs();
    move |face| {
        let on = |axis: usize, at: f64| face.iter().all(|node| (node[axis] - at).abs() <= tolerance);
        if on(dim - 1, touched) {
            Boundary::Touched
        } else if on(dim - 1, base) {
            Boundary::Base
        } else if symmetry[0] && on(0, 0.0) {
            Boundary::SymmetryX
        } else if dim == 3 && symmetry[1] && on(1, 0.0) {
            Boundary::SymmetryY
        } else {
            Boundary::Side
        }
    }
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt()
}

/// One node for all points within the tolerance of each other.
fn weld(dim: usize, points: &[[f64; 3]]) -> (Vec<[f64; 3]>, Vec<u32>) {
    let size = 3usize.pow(dim as u32);
    let mut smallest = f64::INFINITY;
    for element in points.chunks(size) {
        for axis in 0..dim {
            let stride = 3usize.pow(axis as u32);
            for a in (0..size).filter(|a| a / stride % 3 < 2) {
                smallest = smallest.min(distance(element[a], element[a + stride]));
            }
        }
    }
    let tolerance = WELD_SHARE * smallest;
    let mut buckets: HashMap<[i64; 3], Vec<u32>> = HashMap::new();
    let (mut nodes, mut welded): (Vec<[f64; 3]>, Vec<u32>) = (Vec::new(), Vec::with_capacity(points.len()));
    for &point in points {
        let bucket = |shift: f64| point.map(|x| ((x / tolerance + shift) / 4.0).floor() as i64);
        let (low, high) = (bucket(-1.0), bucket(1.0));
        let found = (0..8)
            .map(|corner: usize| std::array::from_fn(|i| if corner >> i & 1 == 0 { low[i] } else { high[i] }))
            .filter_map(|key| buckets.get(&key))
            .flatten()
            .find(|&&node| distance(nodes[node as usize], point) <= tolerance);
        let node = found.copied().unwrap_or(nodes.len() as u32);
        if node as usize == nodes.len() {
            nodes.push(point);
            buckets.entry(bucket(0.0)).or_default().push(node);
        }
        welded.push(node);
    }
    (nodes, welded)
}

/// Faces that only one element has; a face is known by the node in its middle.
pub(super) fn boundary(mesh: &Mesh) -> Vec<Facet> {
    let all = || {
        (0..mesh.element_count()).flat_map(|e| {
            (0..2 * mesh.dim).map(move |side| Facet { element: e as u32, side: side as u8, boundary: Boundary::Side })
        })
    };
    let middle = |facet: Facet| {
        let face = mesh.facet_nodes(facet);
        face[face.len() / 2] as usize
    };
    let mut uses = vec![0u8; mesh.nodes.len()];
    all().for_each(|facet| uses[middle(facet)] = uses[middle(facet)].saturating_add(1));
    all().filter(|&facet| uses[middle(facet)] == 1).collect()
}
