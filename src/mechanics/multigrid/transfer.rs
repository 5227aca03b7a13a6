//! Between all nodes of a mesh and the corners of its elements.

use super::blocks::Block;
use crate::mechanics::mesh::Mesh;
use rayon::prelude::*;

/// Nodes of an element, and its corners.
pub const NODES: usize = 27;
pub const CORNERS: usize = 8;

/// Lists one after the other.
pub struct Lists<T> {
    start: Vec<u32>,
    all: Vec<T>,
}

impl<T> Lists<T> {
    /// Of lists.
    pub fn new(lists: Vec<Vec<T>>) -> Self {
        let mut made = Self { start: vec![0], all: Vec::new() };
        for list in lists {
            made.all.extend(list);
            made.start.push(made.all.len() as u32);
        }
        made
    }

    /// One of them.
    pub fn of(&self, k: usize) -> &[T] {
        &self.all[self.start[k] as usize..self.start[k + 1] as usize]
    }
}

/// Corners of an element's lattice that a node lies between, with their weights.
pub fn weights(node: usize) -> impl Iterator<Item = (usize, f64)> {
    (0..CORNERS).filter_map(move |corner| {
        let along = |axis: usize| match node / 3usize.pow(axis as u32) % 3 {
            1 => 0.5,
            end => f64::from(u8::from(end / 2 == corner >> axis & 1)),
        };
        let weight = along(0) * along(1) * along(2);
        (weight > 0.0).then_some((corner, weight))
    })
}

/// The node of an element's lattice at a corner.
pub fn corner_node(corner: usize) -> usize {
    (0..3).map(|axis| 2 * (corner >> axis & 1) * 3usize.pow(axis as u32)).sum()
}

/// The corners of a mesh, and how they move its nodes.
pub struct Transfer {
    /// For each node the corners that it lies between.
    parents: Lists<(u32, f32)>,
    /// For each corner the nodes that it moves.
    children: Lists<(u32, f32)>,
    /// Number of the corner at a node.
    corner_of: Vec<u32>,
    /// Positions of the corners.
    pub positions: Vec<[f64; 3]>,
    /// Held components of all nodes, and of the corners.
    pub held: [Vec<[bool; 3]>; 2],
}

impl Transfer {
    /// Of a mesh with some components held.
    pub fn new(mesh: &Mesh, held: Vec<[bool; 3]>) -> Self {
        let mut corner_of = vec![u32::MAX; mesh.nodes.len()];
        let (mut positions, mut held_corners) = (Vec::new(), Vec::new());
        for e in 0..mesh.element_count() {
            for corner in 0..CORNERS {
                let node = mesh.element(e)[corner_node(corner)] as usize;
                if corner_of[node] == u32::MAX {
                    corner_of[node] = positions.len() as u32;
                    positions.push(mesh.nodes[node]);
                    held_corners.push(held[node]);
                }
            }
        }
        let mut parents: Vec<Vec<(u32, f32)>> = vec![Vec::new(); mesh.nodes.len()];
        let mut children: Vec<Vec<(u32, f32)>> = vec![Vec::new(); positions.len()];
        for e in 0..mesh.element_count() {
            let element = mesh.element(e);
            for (a, &node) in element.iter().enumerate() {
                if !parents[node as usize].is_empty() {
                    continue;
                }
                for (corner, weight) in weights(a) {
                    let corner = corner_of[element[corner_node(corner)] as usize];
                    parents[node as usize].push((corner, weight as f32));
                    children[corner as usize].push((node, weight as f32));
                }
            }
        }
        let held = [held, held_corners];
        Self { parents: Lists::new(parents), children: Lists::new(children), corner_of, positions, held }
    }

    /// The corners that a node lies between, with their weights.
    pub fn parents(&self, node: u32) -> &[(u32, f32)] {
        self.parents.of(node as usize)
    }

    /// The corners that move some nodes, each once.
    pub fn above(&self, nodes: &[u32]) -> Vec<u32> {
        let mut corners: Vec<u32> = nodes.iter().flat_map(|&a| self.parents(a)).map(|(corner, _)| *corner).collect();
        corners.sort_unstable();
        corners.dedup();
        corners
    }

    /// The corners of an element.
    pub fn corners(&self, element: &[u32]) -> [u32; CORNERS] {
        std::array::from_fn(|corner| self.corner_of[element[corner_node(corner)] as usize])
    }

    /// Forces on the corners.
    pub fn restricted(&self, fine: &[f32]) -> Vec<f32> {
        let mut sums = vec![0.0; 3 * self.positions.len()];
        sums.par_chunks_mut(3).enumerate().with_min_len(256).for_each(|(corner, sum)| {
            for &(node, weight) in self.children.of(corner) {
                for i in self.free(node, corner as u32) {
                    sum[i] += weight * fine[3 * node as usize + i];
                }
            }
        });
        sums
    }

    /// Adds the motion of the corners to all nodes.
    pub fn prolong(&self, coarse: &[f32], fine: &mut [f32]) {
        fine.par_chunks_mut(3).enumerate().with_min_len(1024).for_each(|(node, motion)| {
            for &(corner, weight) in self.parents.of(node) {
                for i in self.free(node as u32, corner) {
                    motion[i] += weight * coarse[3 * corner as usize + i];
                }
            }
        });
    }

    /// Components that are free at a node and at a corner.
    fn free(&self, node: u32, corner: u32) -> impl Iterator<Item = usize> {
        let (own, above) = (self.held[0][node as usize], self.held[1][corner as usize]);
        (0..3).filter(move |&i| !own[i] && !above[i])
    }

    /// A block without the components that are held, on a level.
    pub fn masked(&self, level: usize, row: u32, column: u32, block: &[f64; 9]) -> Block {
        let [p, q] = [row, column].map(|k| self.held[level][k as usize]);
        std::array::from_fn(|k| if p[k / 3] || q[k % 3] { 0.0 } else { block[k] as f32 })
    }

    /// What the corners of an element feel of its blocks, row by row: sums over the nodes between them.
    pub fn blocks_above(&self, block: impl Fn(usize, usize) -> [f64; 9]) -> [[f64; 9]; CORNERS * CORNERS] {
        let mut half = vec![[0.0; 9]; CORNERS * NODES];
        for a in 0..NODES {
            for b in 0..NODES {
                let block = block(a, b);
                for (corner, weight) in weights(a) {
                    half[corner * NODES + b].iter_mut().zip(&block).for_each(|(sum, v)| *sum += weight * v);
                }
            }
        }
        let mut sums = [[0.0; 9]; CORNERS * CORNERS];
        for row in 0..CORNERS {
            for b in 0..NODES {
                for (column, weight) in weights(b) {
                    let sum = sums[row * CORNERS + column].iter_mut();
                    sum.zip(&half[row * NODES + b]).for_each(|(sum, v)| *sum += weight * v);
                }
            }
        }
        sums
    }
}
