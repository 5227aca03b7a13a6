//! Multigrid for the stiffness of triquadratic hexahedra: an approximate inverse whose cost grows as the unknowns do.
//!
//! Three levels: all nodes; the corners of the elements, with trilinear functions between them; aggregates of these that
//! move as rigid bodies, solved directly. Smoothing is Chebyshev's over the diagonal blocks, all in single precision.
//! It wants a stiffness that is not nearly incompressible.

mod aggregates;
mod blocks;
mod smoother;

use super::mesh::Mesh;
use super::sparse::SparseError;
use aggregates::Aggregates;
use blocks::{Block, BlockMatrix};
use rayon::prelude::*;
use smoother::Smoother;

/// Nodes of an element, and its corners.
const NODES: usize = 27;
const CORNERS: usize = 8;

/// Corners of an element's lattice that a node lies between, with their weights.
fn weights(node: usize) -> impl Iterator<Item = (usize, f64)> {
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
fn corner_node(corner: usize) -> usize {
    (0..3).map(|axis| 2 * (corner >> axis & 1) * 3usize.pow(axis as u32)).sum()
}

/// A hierarchy over a mesh of hexahedra.
pub struct Multigrid {
    fine: BlockMatrix,
    coarse: BlockMatrix,
    /// Held components of all nodes, and of the corners.
    held: [Vec<[bool; 3]>; 2],
    /// For each node the corners that it lies between: where they start in `parents`.
    first: Vec<u32>,
    parents: Vec<(u32, f32)>,
    /// Corners of the elements, by number of the corner.
    corner_of: Vec<u32>,
    positions: Vec<[f64; 3]>,
    levels: Option<Levels>,
}

/// What depends on the entries.
struct Levels {
    fine: Smoother,
    coarse: Smoother,
    aggregates: Aggregates,
}

impl Multigrid {
    /// For a mesh whose nodes couple by its elements and by further `groups`.
    pub fn new(mesh: &Mesh, held: Vec<[bool; 3]>, groups: &[Vec<u32>]) -> Self {
        let count = mesh.nodes.len();
        let mut corner_of = vec![u32::MAX; count];
        let mut positions = Vec::new();
        for e in 0..mesh.element_count() {
            for corner in 0..CORNERS {
                let node = mesh.element(e)[corner_node(corner)] as usize;
                if corner_of[node] == u32::MAX {
                    corner_of[node] = positions.len() as u32;
                    positions.push(mesh.nodes[node]);
                }
            }
        }
        let mut lists: Vec<Vec<(u32, f32)>> = vec![Vec::new(); count];
        for e in 0..mesh.element_count() {
            let element = mesh.element(e);
            for (a, &node) in element.iter().enumerate() {
                let list = &mut lists[node as usize];
                if list.is_empty() {
                    list.extend(weights(a).map(|(c, w)| (corner_of[element[corner_node(c)] as usize], w as f32)));
                }
            }
        }
        let mut first = vec![0];
        let mut parents = Vec::new();
        for list in lists {
            parents.extend(list);
            first.push(parents.len() as u32);
        }
        let elements: Vec<&[u32]> = (0..mesh.element_count()).map(|e| mesh.element(e)).collect();
        let all = elements.iter().copied().chain(groups.iter().map(Vec::as_slice));
        let fine = BlockMatrix::new(count, all);
        let of = |a: u32| &parents[first[a as usize] as usize..first[a as usize + 1] as usize];
        let above = |group: &[u32]| -> Vec<u32> {
            let mut corners: Vec<u32> = group.iter().flat_map(|&a| of(a)).map(|(corner, _)| *corner).collect();
            corners.sort_unstable();
            corners.dedup();
            corners
        };
        let corners: Vec<Vec<u32>> =
            elements.iter().map(|element| above(element)).chain(groups.iter().map(|group| above(group))).collect();
        let coarse = BlockMatrix::new(positions.len(), corners.iter().map(Vec::as_slice));
        let mut held_corners = vec![[false; 3]; positions.len()];
        for (held, &corner) in held.iter().zip(&corner_of).filter(|(_, corner)| **corner != u32::MAX) {
            held_corners[corner as usize] = *held;
        }
        let held = [held, held_corners];
        Self { fine, coarse, held, first, parents, corner_of, positions, levels: None }
    }

    /// Bytes of the matrices.
    pub fn bytes(&self) -> usize {
        (self.fine.blocks() + self.coarse.blocks()) * (size_of::<Block>() + 4)
    }

    /// Sets all entries to 0.
    pub fn clear(&mut self) {
        self.levels = None;
        self.fine.clear();
        self.coarse.clear();
    }

    /// Whether the pattern couples these nodes with one another.
    pub fn couples(&self, nodes: &[u32]) -> bool {
        nodes.iter().all(|&a| nodes.iter().all(|&b| self.fine.row(a as usize).any(|(column, _)| column == b)))
    }

    /// Adds the full, row-major stiffness of an element.
    pub fn add_element(&mut self, nodes: &[u32], stiffness: &[f64]) {
        let size = 3 * NODES;
        let block = |a: usize, b: usize| -> [f64; 9] {
            let [p, q] = [a, b].map(|k| self.held[0][nodes[k] as usize]);
            std::array::from_fn(|k| {
                let (i, j) = (k / 3, k % 3);
                if p[i] || q[j] { 0.0 } else { stiffness[(3 * a + i) * size + 3 * b + j] }
            })
        };
        let mut half = vec![[0.0; 9]; CORNERS * NODES];
        for a in 0..NODES {
            for b in 0..NODES {
                let block = block(a, b);
                self.fine.add(nodes[a], nodes[b], &block.map(|v| v as f32));
                for (corner, weight) in weights(a) {
                    half[corner * NODES + b].iter_mut().zip(&block).for_each(|(sum, v)| *sum += weight * v);
                }
            }
        }
        let corner = |c: usize| self.corner_of[nodes[corner_node(c)] as usize];
        for row in 0..CORNERS {
            let mut sums = [[0.0; 9]; CORNERS];
            for b in 0..NODES {
                for (column, weight) in weights(b) {
                    sums[column].iter_mut().zip(&half[row * NODES + b]).for_each(|(sum, v)| *sum += weight * v);
                }
            }
            for (column, sum) in sums.iter().enumerate() {
                let masked = self.masked(1, corner(row), corner(column), sum);
                self.coarse.add(corner(row), corner(column), &masked);
            }
        }
    }

    /// A block without the components that are held on a level.
    fn masked(&self, level: usize, row: u32, column: u32, block: &[f64; 9]) -> Block {
        let [p, q] = [row, column].map(|k| self.held[level][k as usize]);
        std::array::from_fn(|k| if p[k / 3] || q[k % 3] { 0.0 } else { block[k] as f32 })
    }

    /// Adds to the stiffness of a pair of nodes, in this order alone.
    pub fn add_pair(&mut self, row: u32, column: u32, block: &[f64; 9]) {
        let masked = self.masked(0, row, column, block);
        self.fine.add(row, column, &masked);
        let masked = masked.map(f64::from);
        for k in self.first[row as usize]..self.first[row as usize + 1] {
            let (above, w) = self.parents[k as usize];
            for l in self.first[column as usize]..self.first[column as usize + 1] {
                let (beside, v) = self.parents[l as usize];
                let share = self.masked(1, above, beside, &masked.map(|c| c * f64::from(w * v)));
                self.coarse.add(above, beside, &share);
            }
        }
    }

    /// Readies the levels for the present entries.
    ///
    /// # Errors
    /// What the factorisation of the coarsest says.
    pub fn finish(&mut self) -> Result<(), SparseError> {
        self.fine.fix();
        self.coarse.fix();
        let [fine, coarse] = [&self.fine, &self.coarse].map(Smoother::new);
        let aggregates = Aggregates::new(&self.coarse, &coarse, &self.positions, &self.held[1])?;
        self.levels = Some(Levels { fine, coarse, aggregates });
        Ok(())
    }

    /// out = A x; held components are 0.
    pub fn multiply(&self, x: &[f64], out: &mut [f64]) {
        self.fine.multiply(x, out);
    }

    /// An approximate solution of A x = b: one cycle.
    pub fn cycle(&mut self, b: &[f64]) -> Vec<f64> {
        let Some(mut levels) = self.levels.take() else { return b.to_vec() };
        // Single precision spans less than forces may.
        let size = b.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
        if size == 0.0 {
            self.levels = Some(levels);
            return b.to_vec();
        }
        let b: Vec<f32> = b.iter().map(|v| (v / size) as f32).collect();
        let mut x = vec![0.0; b.len()];
        levels.fine.smooth(&self.fine, &b, &mut x, true);
        let below = self.restricted(&self.residual(&self.fine, &b, &x));
        let mut correction = vec![0.0; below.len()];
        levels.coarse.smooth(&self.coarse, &below, &mut correction, true);
        let rest = self.residual(&self.coarse, &below, &correction);
        levels.aggregates.correct(&rest, &mut correction);
        levels.coarse.smooth(&self.coarse, &below, &mut correction, false);
        self.prolong(&correction, &mut x);
        levels.fine.smooth(&self.fine, &b, &mut x, false);
        self.levels = Some(levels);
        x.into_iter().map(|v| f64::from(v) * size).collect()
    }

    fn residual(&self, matrix: &BlockMatrix, b: &[f32], x: &[f32]) -> Vec<f32> {
        let mut out = vec![0.0; b.len()];
        matrix.multiply(x, &mut out);
        out.par_iter_mut().zip(b).with_min_len(4096).for_each(|(out, b)| *out = b - *out);
        out
    }

    /// Forces on the corners.
    fn restricted(&self, fine: &[f32]) -> Vec<f32> {
        let mut sums = vec![0.0; 3 * self.positions.len()];
        for (node, force) in fine.chunks_exact(3).enumerate() {
            let own = self.held[0][node];
            for k in self.first[node]..self.first[node + 1] {
                let (corner, weight) = self.parents[k as usize];
                for i in (0..3).filter(|&i| !own[i] && !self.held[1][corner as usize][i]) {
                    sums[3 * corner as usize + i] += weight * force[i];
                }
            }
        }
        sums
    }

    /// Adds the motion of the corners to all nodes.
    fn prolong(&self, coarse: &[f32], fine: &mut [f32]) {
        fine.par_chunks_mut(3).enumerate().with_min_len(1024).for_each(|(node, motion)| {
            let own = self.held[0][node];
            for k in self.first[node]..self.first[node + 1] {
                let (corner, weight) = self.parents[k as usize];
                for i in (0..3).filter(|&i| !own[i] && !self.held[1][corner as usize][i]) {
                    motion[i] += weight * coarse[3 * corner as usize + i];
                }
            }
        });
    }
}
