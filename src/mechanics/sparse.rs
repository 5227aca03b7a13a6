//! Symmetric sparse systems as L D L^T: one symbolic factorisation, many numeric ones (faer). Newton's tangents may be
//! indefinite on the way to a balance (docs/decisions/factorisation.md).
//!
//! Unknowns come by nodes, and every node couples with whole nodes: the pattern is gathered, ordered and addressed by
//! nodes, and only spelled out by unknowns for the factorisation.

use super::memory::{GIB, limit_gib};
use super::ordering::nested_dissection;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::ldlt::factor::LdltRegularization;
use faer::linalg::triangular_inverse::invert_unit_lower_triangular;
use faer::perm::PermRef;
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::supernodal::SupernodalLdltRef;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LdltRef, SymbolicCholesky, SymbolicCholeskyRaw, SymmetricOrdering,
    factorize_symbolic_cholesky,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, Mat, MatMut, Par, Side};
use thiserror::Error;

/// Why a system could not be solved.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum SparseError {
    /// A pivot was not positive: the structure is loose or unstable.
    #[error("the tangent stiffness is not positive definite")]
    Indefinite,
    /// The factor does not fit in memory.
    #[error("the stiffness matrix is too large to be factorised")]
    TooLarge,
    /// The factor would need more memory than is allowed.
    #[error(
        "the factor of {unknowns} unknowns takes {factor_gib:.1} GiB, the limit is {limit_gib:.1} GiB: coarsen the mesh"
    )]
    Memory {
        /// Unknowns.
        unknowns: usize,
        /// Size of the factor, GiB.
        factor_gib: f64,
        /// The limit, GiB.
        limit_gib: f64,
    },
}

/// Entries of the factor from which threads share its work. The dense blocks of smaller ones are not worth the
/// handing over: 1.6 million entries (a plane press) take 18 ms with one thread and 25 with two.
const LEAST_SHARED: usize = 5_000_000;

/// A symmetric matrix of fixed pattern, its lower triangle by columns, and its Cholesky factor.
pub struct SparseLdl {
    columns: Vec<u32>,
    rows: Vec<u32>,
    /// Entries of the lower triangle.
    pub values: Vec<f64>,
    /// First unknown of each node, and their number.
    first: Vec<u32>,
    /// Later nodes that each node couples with, and how many entries of a column come between it and them.
    coupled: Coupled,
    symbolic: SymbolicCholesky<u32>,
    factor: Vec<f64>,
    scratch: MemBuffer,
    threads: Par,
}

/// Pairs of nodes: for each node the later ones, ascending.
struct Coupled {
    start: Vec<u32>,
    node: Vec<u32>,
    /// Unknowns of the nodes listed before.
    offset: Vec<u32>,
}

impl Coupled {
    /// The pairs of all groups. Nodes without unknowns count for nothing.
    fn new(first: &[u32], groups: &[Vec<u32>]) -> Result<Self, SparseError> {
        let count = first.len() - 1;
        let size = |a: u32| first[a as usize + 1] - first[a as usize];
        let mut held_by: Vec<Vec<u32>> = vec![Vec::new(); count];
        for (g, group) in groups.iter().enumerate() {
            group.iter().filter(|&&a| size(a) > 0).for_each(|&a| held_by[a as usize].push(g as u32));
        }
        let mut seen = vec![u32::MAX; count];
        let mut coupled = Self { start: vec![0], node: Vec::new(), offset: Vec::new() };
        for (a, holders) in held_by.iter().enumerate() {
            let from = coupled.node.len();
            for &g in holders {
                for &b in &groups[g as usize] {
                    if b as usize > a && size(b) > 0 && std::mem::replace(&mut seen[b as usize], a as u32) != a as u32 {
                        coupled.node.push(b);
                    }
                }
            }
            coupled.node[from..].sort_unstable();
            let mut offset = 0;
            for &b in &coupled.node[from..] {
                coupled.offset.push(offset);
                offset += size(b);
            }
            coupled.start.push(u32::try_from(coupled.node.len()).map_err(|_| SparseError::TooLarge)?);
        }
        Ok(coupled)
    }

    fn of(&self, a: u32) -> (&[u32], &[u32]) {
        let range = self.start[a as usize] as usize..self.start[a as usize + 1] as usize;
        (&self.node[range.clone()], &self.offset[range])
    }

    /// Columns and rows of the lower triangle.
    fn spell_out(&self, first: &[u32]) -> Result<(Vec<u32>, Vec<u32>), SparseError> {
        let (mut columns, mut rows) = (vec![0u32], Vec::new());
        for a in 0..first.len() as u32 - 1 {
            let end = first[a as usize + 1];
            for column in first[a as usize]..end {
                rows.extend(column..end);
                for &b in self.of(a).0 {
                    rows.extend(first[b as usize]..first[b as usize + 1]);
                }
                columns.push(u32::try_from(rows.len()).map_err(|_| SparseError::TooLarge)?);
            }
        }
        Ok((columns, rows))
    }
}

impl SparseLdl {
    /// A matrix that couples the nodes of each group with one another. The unknowns of node `a` are `first[a]` up to
    /// `first[a + 1]`.
    ///
    /// # Errors
    /// [`SparseError::TooLarge`], [`SparseError::Memory`].
    pub fn new(first: Vec<u32>, positions: &[[f64; 3]], groups: &[Vec<u32>]) -> Result<Self, SparseError> {
        let order = nested_dissection(groups, positions);
        Self::within(limit_gib(), first, &order, groups, CholeskySymbolicParams::default())
    }

    /// The same, eliminating some nodes last, in their order: then [`Self::inverse_of_last`] is had for little.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn ending_with(
        last: &[u32],
        first: Vec<u32>,
        positions: &[[f64; 3]],
        groups: &[Vec<u32>],
    ) -> Result<Self, SparseError> {
        let mut is_last = vec![false; positions.len()];
        last.iter().for_each(|&a| is_last[a as usize] = true);
        let mut order = nested_dissection(groups, positions);
        order.retain(|&a| !is_last[a as usize]);
        order.extend(last);
        let by_blocks = CholeskySymbolicParams {
            supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SUPERNODAL,
            ..Default::default()
        };
        Self::within(limit_gib(), first, &order, groups, by_blocks)
    }

    /// Nodes in their order of elimination, and a factor of at most `limit_gib`.
    fn within(
        limit_gib: f64,
        first: Vec<u32>,
        nodes: &[u32],
        groups: &[Vec<u32>],
        parameters: CholeskySymbolicParams<'_>,
    ) -> Result<Self, SparseError> {
        let coupled = Coupled::new(&first, groups)?;
        let (columns, rows) = coupled.spell_out(&first)?;
        let n = columns.len() - 1;
        let forward: Vec<u32> = nodes.iter().flat_map(|&a| first[a as usize]..first[a as usize + 1]).collect();
        let mut inverse = vec![0u32; n];
        (0u32..).zip(&forward).for_each(|(k, &old)| inverse[old as usize] = k);
        let pattern = SymbolicSparseColMatRef::new_checked(n, n, &columns, None, &rows);
        let order = SymmetricOrdering::Custom(PermRef::new_checked(&forward, &inverse, n));
        let symbolic =
            factorize_symbolic_cholesky(pattern, Side::Lower, order, parameters).map_err(|_| SparseError::TooLarge)?;
        let factor_gib = symbolic.len_val() as f64 * 8.0 / GIB;
        if factor_gib > limit_gib {
            return Err(SparseError::Memory { unknowns: n, factor_gib, limit_gib });
        }
        let threads = if symbolic.len_val() < LEAST_SHARED { Par::Seq } else { Par::rayon(0) };
        let need = symbolic
            .factorize_numeric_ldlt_scratch::<f64>(threads, Default::default())
            .or(symbolic.solve_in_place_scratch::<f64>(1, threads));
        let scratch = MemBuffer::try_new(need).map_err(|_| SparseError::TooLarge)?;
        let factor = vec![0.0; symbolic.len_val()];
        Ok(Self { values: vec![0.0; rows.len()], columns, rows, first, coupled, symbolic, factor, scratch, threads })
    }

    /// Where the entry (row, column) of the lower triangle is held, if the pattern has it.
    pub fn position(&self, row: u32, column: u32) -> Option<usize> {
        let (row, column) = (row.max(column), row.min(column) as usize);
        let start = self.columns[column] as usize;
        let list = &self.rows[start..self.columns[column + 1] as usize];
        list.binary_search(&row).ok().map(|k| start + k)
    }

    /// Whether the pattern couples all of these nodes, ascending, with one another.
    pub fn couples(&self, nodes: &[u32]) -> bool {
        let free = |a: u32| self.first[a as usize] < self.first[a as usize + 1];
        nodes.iter().enumerate().filter(|(_, a)| free(**a)).all(|(k, &a)| {
            let mut known = self.coupled.of(a).0.iter();
            nodes[k + 1..].iter().filter(|b| free(**b)).all(|b| known.any(|known| known == b))
        })
    }

    /// Adds a group's full symmetric matrix, row-major, of which the lower triangle by unknowns is read. `numbers` are
    /// its unknowns, `per_node` for each node, ascending in each; those held are `u32::MAX`.
    pub fn add(&mut self, nodes: &[u32], numbers: &[u32], matrix: &[f64]) {
        let per_node = numbers.len() / nodes.len().max(1);
        let size = numbers.len();
        for (i, &a) in nodes.iter().enumerate() {
            let (later, offsets) = self.coupled.of(a);
            let end = self.first[a as usize + 1];
            for (j, &b) in nodes.iter().enumerate().filter(|(_, b)| **b >= a) {
                let offset = match later.binary_search(&b) {
                    Ok(k) => offsets[k],
                    Err(_) if a == b => 0,
                    Err(_) => continue,
                };
                for p in i * per_node..(i + 1) * per_node {
                    let column = numbers[p];
                    if column == u32::MAX {
                        continue;
                    }
                    let start = self.columns[column as usize];
                    // The rows of b stand in a line: the place of each is its number plus this.
                    let base = if a == b {
                        start.wrapping_sub(column)
                    } else {
                        (start + (end - column) + offset).wrapping_sub(self.first[b as usize])
                    };
                    for q in j * per_node..(j + 1) * per_node {
                        let row = numbers[q];
                        if row != u32::MAX && row >= column {
                            self.values[base.wrapping_add(row) as usize] += matrix[p * size + q];
                        }
                    }
                }
            }
        }
    }

    /// Factorises the present entries.
    ///
    /// # Errors
    /// [`SparseError::Indefinite`].
    pub fn factorize(&mut self) -> Result<(), SparseError> {
        let n = self.columns.len() - 1;
        let pattern = SymbolicSparseColMatRef::new_checked(n, n, &self.columns, None, &self.rows);
        self.symbolic
            .factorize_numeric_ldlt(
                &mut self.factor,
                SparseColMatRef::new(pattern, &self.values),
                Side::Lower,
                LdltRegularization::default(),
                self.threads,
                MemStack::new(&mut self.scratch),
                Default::default(),
            )
            .map(|_| ())
            .map_err(|_| SparseError::Indefinite)
    }

    /// Solves with the last factor, in place.
    pub fn solve(&mut self, vector: &mut [f64]) {
        let n = vector.len();
        LdltRef::new(&self.symbolic, &self.factor).solve_in_place_with_conj(
            Conj::No,
            MatMut::from_column_major_slice_mut(vector, n, 1),
            self.threads,
            MemStack::new(&mut self.scratch),
        );
    }

    /// The last `count` rows and columns of the inverse, in the order of elimination, by the last factor. Where
    /// A = L D L^T, the inverse of A ends with that of L_e D_e L_e^T, L_e and D_e being the ends of L and D. `None`
    /// where the factor is not held by blocks, as that of [`Self::ending_with`] is.
    pub fn inverse_of_last(&self, count: usize) -> Option<Mat<f64>> {
        let SymbolicCholeskyRaw::Supernodal(symbolic) = self.symbolic.raw() else { return None };
        let factor = SupernodalLdltRef::new(symbolic, &self.factor);
        let before = symbolic.nrows().checked_sub(count)?;
        let mut lower = Mat::<f64>::identity(count, count);
        let mut pivots = vec![1.0; count];
        for block in (0..symbolic.n_supernodes()).map(|s| factor.supernode(s)) {
            let (entries, start) = (block.val(), block.start());
            for j in before.saturating_sub(start)..entries.ncols() {
                let column = start + j - before;
                pivots[column] = entries[(j, j)];
                let below = (start + j + 1..start + entries.ncols()).chain(block.pattern().iter().map(|&i| i as usize));
                for (k, row) in below.enumerate() {
                    lower[(row - before, column)] = entries[(j + 1 + k, j)];
                }
            }
        }
        let mut inverse = Mat::zeros(count, count);
        invert_unit_lower_triangular(inverse.as_mut(), lower.as_ref(), self.threads);
        // Which is written below its diagonal alone.
        (0..count).for_each(|j| inverse[(j, j)] = 1.0);
        let scaled = Mat::from_fn(count, count, |i, j| inverse[(i, j)] / pivots[i]);
        Some(inverse.transpose() * scaled)
    }

    /// Bytes held by the factor.
    pub fn factor_bytes(&self) -> usize {
        8 * self.factor.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::noise::PixelRandom;

    /// A chain of nodes with 2, 0, 1, 2, 2 unknowns; the elements couple neighbours, and the last with the first.
    fn chain() -> (Vec<u32>, Vec<Vec<u32>>, SparseLdl) {
        let first = vec![0, 2, 2, 3, 5, 7];
        let groups = vec![vec![1, 0], vec![2, 1], vec![3, 2], vec![3, 4], vec![4, 0]];
        let matrix = SparseLdl::new(first.clone(), &[[0.0; 3]; 5], &groups).unwrap();
        (first, groups, matrix)
    }

    /// Equations of the nodes' components; those not free are held.
    fn numbers(first: &[u32], nodes: &[u32], per_node: u32) -> Vec<u32> {
        let number = |a: u32, c: u32| {
            let at = first[a as usize] + c;
            if at < first[a as usize + 1] { at } else { u32::MAX }
        };
        nodes.iter().flat_map(|&a| (0..per_node).map(move |c| number(a, c))).collect()
    }

    #[test]
    fn added_matrices_are_solved_as_if_dense() {
        let (first, groups, mut matrix) = chain();
        let mut dense = [[0.0; 7]; 7];
        for (g, group) in groups.iter().enumerate() {
            let part: Vec<f64> = (0..16)
                .map(|k| {
                    let (i, j) = (k / 4, k % 4);
                    if i == j { 5.0 + g as f64 } else { 1.0 / (1.0 + (i + j) as f64 + g as f64) }
                })
                .collect();
            let numbers = numbers(&first, group, 2);
            matrix.add(group, &numbers, &part);
            for (i, &row) in numbers.iter().enumerate().filter(|(_, n)| **n != u32::MAX) {
                for (j, &column) in numbers.iter().enumerate().filter(|(_, n)| **n != u32::MAX) {
                    dense[row as usize][column as usize] += part[4 * i + j];
                }
            }
        }
        let expected: [f64; 7] = std::array::from_fn(|k| k as f64 - 2.5);
        let right: Vec<f64> = dense.iter().map(|row| row.iter().zip(&expected).map(|(a, x)| a * x).sum()).collect();
        let off = |matrix: &mut SparseLdl| {
            let mut vector = right.clone();
            matrix.solve(&mut vector);
            vector.iter().zip(expected).map(|(x, expected)| (x - expected).abs()).fold(0.0, f64::max)
        };
        matrix.factorize().unwrap();
        assert!(off(&mut matrix) < 1e-13);
        // The factor of a matrix that has changed since is no factor of it.
        matrix.values.iter_mut().for_each(|value| *value *= 1.5);
        matrix.factorize().unwrap();
        matrix.values.iter_mut().for_each(|value| *value /= 1.5);
        assert!(off(&mut matrix) > 0.1);
        matrix.factorize().unwrap();
        assert!(off(&mut matrix) < 1e-13);
    }

    #[test]
    fn the_pattern_knows_its_pairs() {
        let (_, _, matrix) = chain();
        // Node 1 has no unknowns and couples with anything.
        for (nodes, known) in [(vec![0, 1, 4], true), (vec![1, 3], true), (vec![0, 2], false), (vec![0, 3, 4], false)] {
            assert_eq!(matrix.couples(&nodes), known, "{nodes:?}");
        }
        assert!(matrix.position(3, 6).is_some() && matrix.position(0, 2).is_none());
    }

    /// 300 times nodes of 1 to 3 unknowns, elements of neighbours and of random pairs, pivots of either sign.
    #[test]
    fn the_end_of_an_inverse_is_that_of_whole_solutions() {
        for case in 0..300 {
            let mut random = PixelRandom::new(3, case);
            let mut below = |most: u32| (random.uniform() * f64::from(most)) as u32;
            let count = 2 + below(40);
            let first: Vec<u32> = (0..=count).scan(0, |n, _| Some(std::mem::replace(n, *n + 1 + below(3)))).collect();
            let mut groups: Vec<Vec<u32>> = (1..count).map(|a| vec![a - 1, a]).collect();
            groups.extend((0..count / 4).map(|_| vec![below(count), below(count)]).filter(|pair| pair[0] != pair[1]));
            let positions: Vec<[f64; 3]> = (0..count).map(|a| [f64::from(a), 0.0, 0.0]).collect();
            let mut last: Vec<u32> = (0..count).filter(|_| below(3) == 0).collect();
            last.reverse();
            let mut matrix = SparseLdl::ending_with(&last, first.clone(), &positions, &groups).unwrap();
            for group in &groups {
                let numbers = numbers(&first, group, 3);
                let size = numbers.len();
                let part: Vec<f64> = (0..size * size)
                    .map(|k| match (k / size, k % size) {
                        (i, j) if i != j => ((i + j + i * j) % 5) as f64 - 2.0,
                        (i, _) => f64::from(20 + below(9)) * if numbers[i].is_multiple_of(3) { -1.0 } else { 1.0 },
                    })
                    .collect();
                matrix.add(group, &numbers, &part);
            }
            matrix.factorize().unwrap();
            let unknowns: Vec<u32> = last.iter().flat_map(|&a| first[a as usize]..first[a as usize + 1]).collect();
            let inverse = matrix.inverse_of_last(unknowns.len()).unwrap();
            for (j, &k) in unknowns.iter().enumerate() {
                let mut column = vec![0.0; first[count as usize] as usize];
                column[k as usize] = 1.0;
                matrix.solve(&mut column);
                for (i, &row) in unknowns.iter().enumerate() {
                    let (by_end, whole) = (inverse[(i, j)], column[row as usize]);
                    assert!((by_end - whole).abs() < 1e-14, "case {case}, {i} {j}: {by_end} {whole}");
                }
            }
        }
    }

    #[test]
    fn a_factor_beyond_the_limit_is_refused_by_its_size() {
        let parameters = CholeskySymbolicParams::default();
        let error = SparseLdl::within(1e-7, vec![0, 3, 6], &[0, 1], &[vec![0, 1]], parameters).err();
        assert!(matches!(error, Some(SparseError::Memory { unknowns: 6, .. })), "{error:?}");
    }
}
