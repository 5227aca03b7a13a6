//! Symmetric matrices of 3 x 3 blocks by pairs of nodes, in single precision: what a preconditioner needs.

use rayon::prelude::*;
use std::ops::{Add, Mul};

/// Entries of a block, row by row.
pub type Block = [f32; 9];

/// Rows that a thread takes at a time.
const ROWS: usize = 256;

/// A matrix of blocks, all of its rows whole. Held components have rows and columns of 0 and a diagonal of 1.
#[derive(Debug, Clone)]
pub struct BlockMatrix {
    start: Vec<u32>,
    column: Vec<u32>,
    /// Blocks, row by row.
    values: Vec<Block>,
}

impl BlockMatrix {
    /// A matrix of zeros that couples the nodes of each group, and each node with itself.
    pub fn new<'a>(count: usize, groups: impl Iterator<Item = &'a [u32]> + Clone) -> Self {
        let mut held_by: Vec<Vec<u32>> = vec![Vec::new(); count];
        for (g, group) in groups.clone().enumerate() {
            group.iter().for_each(|&a| held_by[a as usize].push(g as u32));
        }
        let groups: Vec<&[u32]> = groups.collect();
        let (mut start, mut column) = (vec![0u32], Vec::new());
        let mut seen = vec![u32::MAX; count];
        for (a, holders) in held_by.iter().enumerate() {
            let from = column.len();
            seen[a] = a as u32;
            column.push(a as u32);
            for &b in holders.iter().flat_map(|&g| groups[g as usize]) {
                if std::mem::replace(&mut seen[b as usize], a as u32) != a as u32 {
                    column.push(b);
                }
            }
            column[from..].sort_unstable();
            start.push(column.len() as u32);
        }
        let values = vec![[0.0; 9]; column.len()];
        Self { start, column, values }
    }

    /// Nodes.
    pub fn nodes(&self) -> usize {
        self.start.len() - 1
    }

    /// Blocks of the pattern.
    pub fn blocks(&self) -> usize {
        self.values.len()
    }

    /// Sets all entries to 0.
    pub fn clear(&mut self) {
        self.values.par_iter_mut().for_each(|block| *block = [0.0; 9]);
    }

    /// Adds to the block of a pair of nodes, if the pattern has it.
    pub fn add(&mut self, row: u32, column: u32, block: &Block) {
        if let Some(place) = self.position(row, column) {
            self.values[place].iter_mut().zip(block).for_each(|(sum, value)| *sum += value);
        }
    }

    /// Adds the blocks of groups of nodes, by group and places of row and column in it. Each row adds up its groups in
    /// their order, so the sums do not depend on the number of threads.
    pub fn add_groups(&mut self, groups: &[&[u32]], block: impl Fn(usize, usize, usize) -> Block + Sync) {
        let of = |(g, group): (usize, &&[u32])| -> Vec<(u32, u32, u32)> {
            group.iter().enumerate().map(|(a, &node)| (node, g as u32, a as u32)).collect()
        };
        let mut places: Vec<(u32, u32, u32)> = groups.iter().enumerate().flat_map(of).collect();
        places.sort_unstable();
        let (mut rows, mut rest, mut from) = (Vec::new(), self.values.as_mut_slice(), 0);
        for own in places.chunk_by(|p, q| p.0 == q.0) {
            let [start, end] = [0, 1].map(|k| self.start[own[0].0 as usize + k] as usize);
            let (values, after) = std::mem::take(&mut rest)[start - from..].split_at_mut(end - start);
            (rest, from) = (after, end);
            rows.push((own, &self.column[start..end], values));
        }
        rows.into_par_iter().with_min_len(64).for_each(|(own, columns, values)| {
            for &(_, g, a) in own {
                for (b, node) in groups[g as usize].iter().enumerate() {
                    if let Ok(place) = columns.binary_search(node) {
                        let block = block(g as usize, a as usize, b);
                        values[place].iter_mut().zip(block).for_each(|(sum, value)| *sum += value);
                    }
                }
            }
        });
    }

    fn position(&self, row: u32, column: u32) -> Option<usize> {
        let range = self.range(row as usize);
        self.column[range.clone()].binary_search(&column).ok().map(|k| range.start + k)
    }

    fn range(&self, row: usize) -> std::ops::Range<usize> {
        self.start[row] as usize..self.start[row + 1] as usize
    }

    /// Columns and blocks of a row.
    pub fn row(&self, row: usize) -> impl Iterator<Item = (u32, &Block)> {
        let range = self.range(row);
        self.column[range.clone()].iter().copied().zip(&self.values[range])
    }

    /// The diagonal block of a row.
    pub fn diagonal(&self, row: usize) -> Block {
        self.position(row as u32, row as u32).map_or([0.0; 9], |place| self.values[place])
    }

    /// Gives components that no stiffness holds a diagonal of 1.
    pub fn fix(&mut self) {
        for row in 0..self.nodes() {
            let Some(place) = self.position(row as u32, row as u32) else { continue };
            let block = &mut self.values[place];
            for c in 0..3 {
                if block[4 * c] == 0.0 {
                    block[4 * c] = 1.0;
                }
            }
        }
    }

    /// out = A x, in the precision of x.
    pub fn multiply<T: Entry>(&self, x: &[T], out: &mut [T]) {
        let wide = pulp::Arch::new();
        out.par_chunks_mut(3 * ROWS).enumerate().for_each(|(chunk, out)| {
            wide.dispatch(Product { matrix: self, x, first: chunk * ROWS, out });
        });
    }
}

/// What vectors are made of.
pub trait Entry: From<f32> + Copy + Send + Sync + Add<Output = Self> + Mul<Output = Self> {}

impl Entry for f32 {}
impl Entry for f64 {}

/// Some rows of a product of a matrix and a vector.
struct Product<'a, T> {
    matrix: &'a BlockMatrix,
    x: &'a [T],
    first: usize,
    out: &'a mut [T],
}

/// In vectors as wide as the CPU has: the nine products of a block side by side, a row's added up at its end.
impl<T: Entry> pulp::NullaryFnOnce for Product<'_, T> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { matrix, x, first, out } = self;
        let (nodes, _) = x.as_chunks::<3>();
        for (k, out) in out.chunks_exact_mut(3).enumerate() {
            let mut sum = [T::from(0.0); 9];
            let range = matrix.range(first + k);
            for (&column, block) in matrix.column[range.clone()].iter().zip(&matrix.values[range]) {
                let [a, b, c] = nodes[column as usize];
                let x = [a, b, c, a, b, c, a, b, c];
                for ((sum, &entry), x) in sum.iter_mut().zip(block).zip(x) {
                    *sum = *sum + T::from(entry) * x;
                }
            }
            for (i, out) in out.iter_mut().enumerate() {
                *out = sum[3 * i] + sum[3 * i + 1] + sum[3 * i + 2];
            }
        }
    }
}

/// The inverse of a block; of one that has none, 0.
pub fn inverse(b: &Block) -> Block {
    let m = b.map(f64::from);
    let minor = |i: usize, j: usize| {
        let (r, s) = ((i + 1) % 3, (i + 2) % 3);
        let (c, d) = ((j + 1) % 3, (j + 2) % 3);
        m[3 * r + c] * m[3 * s + d] - m[3 * r + d] * m[3 * s + c]
    };
    let determinant: f64 = (0..3).map(|j| m[j] * minor(0, j)).sum();
    if determinant == 0.0 {
        return [0.0; 9];
    }
    std::array::from_fn(|k| (minor(k % 3, k / 3) / determinant) as f32)
}
