//! Multigrid for the stiffness of triquadratic hexahedra: an approximate inverse whose cost grows as the unknowns do.
//!
//! Three levels: all nodes; the corners of the elements, with trilinear functions between them; aggregates of these
//! that move as rigid bodies, solved directly. Smoothing is Chebyshev's over the diagonal blocks, in single precision.
//! It wants a stiffness that is not nearly incompressible.

mod aggregates;
mod blocks;
mod smoother;
#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;
mod transfer;

use super::mesh::Mesh;
use super::sparse::SparseError;
use aggregates::Aggregates;
use blocks::{Block, BlockMatrix};
use rayon::prelude::*;
use smoother::Smoother;
use transfer::{CORNERS, Lists, NODES, Transfer};

/// A hierarchy over a mesh of hexahedra.
pub struct Multigrid {
    fine: BlockMatrix,
    coarse: BlockMatrix,
    transfer: Transfer,
    /// For each node the elements that have it, ascending, and its place in them.
    elements_of: Lists<(u32, u32)>,
    /// Of both levels, for their present entries.
    smoothers: Option<[Smoother; 2]>,
    /// Their grouping stays; what they are made of follows the entries.
    aggregates: Option<Aggregates>,
}

impl Multigrid {
    /// For a mesh whose nodes couple by its elements and by further `groups`.
    pub fn new(mesh: &Mesh, held: Vec<[bool; 3]>, groups: &[Vec<u32>]) -> Self {
        let transfer = Transfer::new(mesh, held);
        let mut elements_of: Vec<Vec<(u32, u32)>> = vec![Vec::new(); mesh.nodes.len()];
        for e in 0..mesh.element_count() {
            for (a, &node) in mesh.element(e).iter().enumerate() {
                elements_of[node as usize].push((e as u32, a as u32));
            }
        }
        let elements = (0..mesh.element_count()).map(|e| mesh.element(e));
        let all: Vec<&[u32]> = elements.chain(groups.iter().map(Vec::as_slice)).collect();
        let above: Vec<Vec<u32>> = all.iter().map(|group| transfer.above(group)).collect();
        Self {
            fine: BlockMatrix::new(mesh.nodes.len(), all.into_iter()),
            coarse: BlockMatrix::new(transfer.positions.len(), above.iter().map(Vec::as_slice)),
            transfer,
            elements_of: Lists::new(elements_of),
            smoothers: None,
            aggregates: None,
        }
    }

    /// Bytes of the matrices.
    pub fn bytes(&self) -> usize {
        (self.fine.blocks() + self.coarse.blocks()) * (size_of::<Block>() + 4)
    }

    /// Sets all entries to 0.
    pub fn clear(&mut self) {
        self.smoothers = None;
        self.fine.clear();
        self.coarse.clear();
    }

    /// Whether the pattern couples these nodes with one another.
    pub fn couples(&self, nodes: &[u32]) -> bool {
        nodes.iter().all(|&a| nodes.iter().all(|&b| self.fine.row(a as usize).any(|(column, _)| column == b)))
    }

    /// The elements that have a node, ascending, and its place in each.
    pub fn elements_of(&self, node: usize) -> &[(u32, u32)] {
        self.elements_of.of(node)
    }

    /// Adds the full, row-major stiffnesses of elements, given with their nodes.
    pub fn add_elements(&mut self, elements: &[(&[u32], &[f64])]) {
        const SIZE: usize = 3 * NODES;
        let held = &self.transfer.held[0];
        let block = |g: usize, a: usize, b: usize| -> [f64; 9] {
            let (nodes, stiffness) = elements[g];
            let [p, q] = [a, b].map(|k| held[nodes[k] as usize]);
            std::array::from_fn(|k| {
                let (i, j) = (k / 3, k % 3);
                if p[i] || q[j] { 0.0 } else { stiffness[(3 * a + i) * SIZE + 3 * b + j] }
            })
        };
        let nodes: Vec<&[u32]> = elements.iter().map(|(nodes, _)| *nodes).collect();
        self.fine.add_groups(&nodes, |g, a, b| block(g, a, b).map(|v| v as f32));
        let transfer = &self.transfer;
        let all = (0..elements.len()).into_par_iter();
        let sums: Vec<_> = all.map(|g| transfer.blocks_above(|a, b| block(g, a, b))).collect();
        let corners: Vec<[u32; CORNERS]> = nodes.iter().map(|nodes| transfer.corners(nodes)).collect();
        let groups: Vec<&[u32]> = corners.iter().map(|group| group.as_slice()).collect();
        self.coarse
            .add_groups(&groups, |g, a, b| transfer.masked(1, corners[g][a], corners[g][b], &sums[g][a * CORNERS + b]));
    }

    /// Adds to the stiffness of a pair of nodes, in this order alone.
    pub fn add_pair(&mut self, row: u32, column: u32, block: &[f64; 9]) {
        let own = self.transfer.masked(0, row, column, block);
        self.fine.add(row, column, &own);
        for &(above, w) in self.transfer.parents(row) {
            for &(beside, v) in self.transfer.parents(column) {
                let share = own.map(|c| f64::from(c) * f64::from(w * v));
                self.coarse.add(above, beside, &self.transfer.masked(1, above, beside, &share));
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
        let smoothers = [&self.fine, &self.coarse].map(Smoother::new);
        let (coarse, held) = (&smoothers[1], &self.transfer.held[1]);
        match &mut self.aggregates {
            Some(aggregates) => aggregates.renew(&self.coarse, coarse, held)?,
            none => *none = Some(Aggregates::new(&self.coarse, coarse, &self.transfer.positions, held)?),
        }
        self.smoothers = Some(smoothers);
        Ok(())
    }

    /// out = A x; held components are 0.
    pub fn multiply(&self, x: &[f64], out: &mut [f64]) {
        self.fine.multiply(x, out);
    }

    /// An approximate solution of A x = b: one cycle.
    pub fn cycle(&mut self, b: &[f64]) -> Vec<f64> {
        let (Some([fine, coarse]), Some(aggregates)) = (&self.smoothers, &mut self.aggregates) else {
            return b.to_vec();
        };
        // Single precision spans less than forces may.
        let size = b.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
        if size == 0.0 {
            return b.to_vec();
        }
        let b: Vec<f32> = b.iter().map(|v| (v / size) as f32).collect();
        let mut x = vec![0.0; b.len()];
        fine.smooth(&self.fine, &b, &mut x, true);
        let below = self.transfer.restricted(&residual(&self.fine, &b, &x));
        let mut correction = vec![0.0; below.len()];
        coarse.smooth(&self.coarse, &below, &mut correction, true);
        let rest = residual(&self.coarse, &below, &correction);
        aggregates.correct(&rest, &mut correction);
        coarse.smooth(&self.coarse, &below, &mut correction, false);
        self.transfer.prolong(&correction, &mut x);
        fine.smooth(&self.fine, &b, &mut x, false);
        x.into_iter().map(|v| f64::from(v) * size).collect()
    }
}

fn residual(matrix: &BlockMatrix, b: &[f32], x: &[f32]) -> Vec<f32> {
    let mut out = vec![0.0; b.len()];
    matrix.multiply(x, &mut out);
    out.par_iter_mut().zip(b).with_min_len(4096).for_each(|(out, b)| *out = b - *out);
    out
}
