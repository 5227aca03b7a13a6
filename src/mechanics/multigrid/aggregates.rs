//! The coarsest level: aggregates of nodes that move as rigid bodies, smoothed once (Vanek, Mandel and Brezina,
//! Computing 56, 179, 1996).

use super::blocks::BlockMatrix;
use super::smoother::Smoother;
use crate::mechanics::sparse::{SparseError, SparseLdl};
use rayon::prelude::*;
use std::collections::HashMap;

/// Motions of an aggregate.
const MODES: usize = 6;
/// Coupling below which neighbours are not joined, over the geometric mean of their diagonals.
const WEAK: f64 = 0.02;
/// Least share of a motion that the others before it do not have.
const LEAST: f64 = 1e-6;
/// Damping of the smoothing over the largest eigenvalue.
const DAMPING: f64 = 4.0 / 3.0;

/// How a node moves with an aggregate: 3 x 6, row by row.
type Motion = [f64; 3 * MODES];

/// The aggregates and their factorised stiffness.
pub struct Aggregates {
    /// Aggregate of each node, and their number.
    of: Vec<u32>,
    count: usize,
    /// Each node's share of its aggregate's rigid motions.
    rigid: Vec<Motion>,
    /// Aggregates that move each node.
    moves: Vec<Vec<(u32, Motion)>>,
    factor: SparseLdl,
}

impl Aggregates {
    /// Of the nodes of a matrix, at their positions; `held` tells which components are.
    ///
    /// # Errors
    /// What the factorisation says.
    pub fn new(
        matrix: &BlockMatrix,
        smoother: &Smoother,
        positions: &[[f64; 3]],
        held: &[[bool; 3]],
    ) -> Result<Self, SparseError> {
        let (of, count) = aggregates(matrix);
        let rigid = rigid_motions(&of, count, positions, held);
        let mut middles = vec![[0.0; 4]; count];
        for (&a, x) in of.iter().zip(positions) {
            let sum = &mut middles[a as usize];
            (0..3).for_each(|i| sum[i] += x[i]);
            sum[3] += 1.0;
        }
        let middles: Vec<[f64; 3]> = middles.iter().map(|m| [0, 1, 2].map(|i| m[i] / m[3].max(1.0))).collect();
        let moves = smoothed(matrix, smoother, &of, &rigid, held);
        let groups: Vec<Vec<u32>> = product(matrix, &moves).into_keys().map(|(a, b)| vec![a, b]).collect();
        let first = (0..=count as u32).map(|a| MODES as u32 * a).collect();
        let factor = SparseLdl::new(first, &middles, &groups)?;
        let mut made = Self { of, count, rigid, moves, factor };
        made.factorise(matrix)?;
        Ok(made)
    }

    /// The same aggregates for other entries of the matrix.
    ///
    /// # Errors
    /// What the factorisation says.
    pub fn renew(&mut self, matrix: &BlockMatrix, smoother: &Smoother, held: &[[bool; 3]]) -> Result<(), SparseError> {
        self.moves = smoothed(matrix, smoother, &self.of, &self.rigid, held);
        self.factorise(matrix)
    }

    fn factorise(&mut self, matrix: &BlockMatrix) -> Result<(), SparseError> {
        let factor = &mut self.factor;
        factor.values.fill(0.0);
        for (&(a, b), block) in &product(matrix, &self.moves) {
            for (k, value) in block.iter().enumerate() {
                let (row, column) = (a * MODES as u32 + (k / MODES) as u32, b * MODES as u32 + (k % MODES) as u32);
                if row >= column
                    && let Some(place) = factor.position(row, column)
                {
                    factor.values[place] += value;
                }
            }
        }
        // Motions that an aggregate does not have.
        for k in 0..(MODES * self.count) as u32 {
            if let Some(place) = factor.position(k, k)
                && factor.values[place] == 0.0
            {
                factor.values[place] = 1.0;
            }
        }
        factor.factorize()
    }

    /// Adds to `x` what the aggregates do under the forces `b`.
    pub fn correct(&mut self, b: &[f32], x: &mut [f32]) {
        let mut coarse = vec![0.0; MODES * self.count];
        for (moves, b) in self.moves.iter().zip(b.chunks_exact(3)) {
            for (a, motion) in moves {
                for m in 0..MODES {
                    let work: f64 = (0..3).map(|i| motion[MODES * i + m] * f64::from(b[i])).sum();
                    coarse[*a as usize * MODES + m] += work;
                }
            }
        }
        self.factor.solve(&mut coarse);
        for (moves, x) in self.moves.iter().zip(x.chunks_exact_mut(3)) {
            for (a, motion) in moves {
                let of = &coarse[*a as usize * MODES..];
                for i in 0..3 {
                    x[i] += (0..MODES).map(|m| motion[MODES * i + m] * of[m]).sum::<f64>() as f32;
                }
            }
        }
    }
}

/// The aggregate of each node, and their number.
fn aggregates(matrix: &BlockMatrix) -> (Vec<u32>, usize) {
    let size = |block: &[f32; 9]| block.iter().map(|&c| f64::from(c).powi(2)).sum::<f64>().sqrt();
    let diagonal: Vec<f64> = (0..matrix.nodes()).map(|row| size(&matrix.diagonal(row))).collect();
    let strong = |row: usize| -> Vec<usize> {
        let bound = |b: usize| WEAK * (diagonal[row] * diagonal[b]).sqrt();
        let row = matrix.row(row).map(|(b, block)| (b as usize, size(block)));
        row.filter(|&(b, size)| size > bound(b)).map(|(b, _)| b).collect()
    };
    const NONE: u32 = u32::MAX;
    let mut of = vec![NONE; matrix.nodes()];
    let mut count = 0;
    for row in 0..matrix.nodes() {
        let near = strong(row);
        if of[row] == NONE && near.iter().all(|&b| of[b] == NONE) {
            near.iter().for_each(|&b| of[b] = count);
            of[row] = count;
            count += 1;
        }
    }
    let roots = of.clone();
    for row in 0..matrix.nodes() {
        if of[row] == NONE
            && let Some(&b) = strong(row).iter().find(|&&b| roots[b] != NONE)
        {
            of[row] = roots[b];
        }
    }
    for row in 0..matrix.nodes() {
        if of[row] == NONE {
            for b in strong(row) {
                if of[b] == NONE {
                    of[b] = count;
                }
            }
            of[row] = count;
            count += 1;
        }
    }
    (of, count as usize)
}

/// Orthonormal rigid motions of each aggregate at its nodes.
fn rigid_motions(of: &[u32], count: usize, positions: &[[f64; 3]], held: &[[bool; 3]]) -> Vec<Motion> {
    let mut members: Vec<Vec<usize>> = vec![Vec::new(); count];
    of.iter().enumerate().for_each(|(node, &a)| members[a as usize].push(node));
    let mut motions = vec![[0.0; 3 * MODES]; of.len()];
    for nodes in &members {
        let middle = [0, 1, 2].map(|i| nodes.iter().map(|&n| positions[n][i]).sum::<f64>() / nodes.len().max(1) as f64);
        for &n in nodes {
            let [x, y, z] = [0, 1, 2].map(|i| positions[n][i] - middle[i]);
            let rows = [[1.0, 0.0, 0.0, 0.0, z, -y], [0.0, 1.0, 0.0, -z, 0.0, x], [0.0, 0.0, 1.0, y, -x, 0.0]];
            for i in (0..3).filter(|&i| !held[n][i]) {
                motions[n][MODES * i..MODES * (i + 1)].copy_from_slice(&rows[i]);
            }
        }
        for m in 0..MODES {
            let dot = |motions: &[Motion], p: usize| -> f64 {
                let at = |n: usize, i: usize| motions[n][MODES * i + m] * motions[n][MODES * i + p];
                nodes.iter().map(|&n| (0..3).map(|i| at(n, i)).sum::<f64>()).sum()
            };
            let whole = dot(&motions, m);
            // Twice, so that rounding leaves nothing of the others.
            for p in (0..m).chain(0..m) {
                let share = dot(&motions, p);
                for &n in nodes {
                    (0..3).for_each(|i| motions[n][MODES * i + m] -= share * motions[n][MODES * i + p]);
                }
            }
            let left = dot(&motions, m);
            let scale = if left > LEAST * whole { left.sqrt().recip() } else { 0.0 };
            nodes.iter().for_each(|&n| (0..3).for_each(|i| motions[n][MODES * i + m] *= scale));
        }
    }
    motions
}

/// (1 - w D^-1 A) applied to the rigid motions.
fn smoothed(
    matrix: &BlockMatrix,
    smoother: &Smoother,
    of: &[u32],
    rigid: &[Motion],
    held: &[[bool; 3]],
) -> Vec<Vec<(u32, Motion)>> {
    let damping = DAMPING / f64::from(smoother.largest);
    let row = |row: usize| {
        let mut sums: Vec<(u32, Motion)> = vec![(of[row], [0.0; 3 * MODES])];
        for (b, block) in matrix.row(row) {
            let motion = &rigid[b as usize];
            let aggregate = of[b as usize];
            let place = sums.iter().position(|(a, _)| *a == aggregate).unwrap_or_else(|| {
                sums.push((aggregate, [0.0; 3 * MODES]));
                sums.len() - 1
            });
            for i in 0..3 {
                for m in 0..MODES {
                    sums[place].1[MODES * i + m] +=
                        (0..3).map(|j| f64::from(block[3 * i + j]) * motion[MODES * j + m]).sum::<f64>();
                }
            }
        }
        let inverse = smoother.inverse_of(row);
        for (aggregate, sum) in &mut sums {
            let force = *sum;
            for i in 0..3 {
                for m in 0..MODES {
                    let own = if *aggregate == of[row] { rigid[row][MODES * i + m] } else { 0.0 };
                    let step: f64 =
                        (0..3).map(|j| f64::from(inverse[3 * i + j]) * force[MODES * j + m]).sum::<f64>() * damping;
                    sum[MODES * i + m] = if held[row][i] { 0.0 } else { own - step };
                }
            }
        }
        sums
    };
    (0..matrix.nodes()).into_par_iter().map(row).collect()
}

/// Blocks of 6 x 6 by pairs of aggregates.
type Blocks = HashMap<(u32, u32), [f64; MODES * MODES]>;

/// Rows of a matrix that are multiplied together.
const ROWS: usize = 4096;

/// P^T A P: sums over parts of the rows, then over the parts, so that they do not depend on the number of threads.
fn product(matrix: &BlockMatrix, moves: &[Vec<(u32, Motion)>]) -> Blocks {
    let starts: Vec<usize> = (0..matrix.nodes()).step_by(ROWS).collect();
    let part = |&start: &usize| product_of(matrix, moves, start..(start + ROWS).min(matrix.nodes()));
    let parts: Vec<Blocks> = starts.par_iter().map(part).collect();
    let mut sums = Blocks::new();
    for (pair, block) in parts.into_iter().flatten() {
        let sum = sums.entry(pair).or_insert([0.0; MODES * MODES]);
        sum.iter_mut().zip(block).for_each(|(sum, value)| *sum += value);
    }
    sums
}

fn product_of(matrix: &BlockMatrix, moves: &[Vec<(u32, Motion)>], rows: std::ops::Range<usize>) -> Blocks {
    let mut sums = Blocks::new();
    for row in rows {
        let mut forces: Vec<(u32, Motion)> = Vec::new();
        for (b, block) in matrix.row(row) {
            for (aggregate, motion) in &moves[b as usize] {
                let place = forces.iter().position(|(a, _)| a == aggregate).unwrap_or_else(|| {
                    forces.push((*aggregate, [0.0; 3 * MODES]));
                    forces.len() - 1
                });
                for i in 0..3 {
                    for m in 0..MODES {
                        forces[place].1[MODES * i + m] +=
                            (0..3).map(|j| f64::from(block[3 * i + j]) * motion[MODES * j + m]).sum::<f64>();
                    }
                }
            }
        }
        for (a, motion) in &moves[row] {
            for (b, force) in forces.iter().filter(|(b, _)| b <= a) {
                let sum = sums.entry((*a, *b)).or_insert([0.0; MODES * MODES]);
                for i in 0..3 {
                    for m in 0..MODES {
                        for p in 0..MODES {
                            sum[MODES * m + p] += motion[MODES * i + m] * force[MODES * i + p];
                        }
                    }
                }
            }
        }
    }
    sums
}
