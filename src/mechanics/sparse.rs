//! Symmetric positive definite sparse systems: one symbolic factorisation, many numeric ones (faer).

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::ldlt::factor::LdltRegularization;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LdltRef, SymbolicCholesky, SymmetricOrdering, factorize_symbolic_cholesky,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, MatMut, Par, Side};
use thiserror::Error;

/// Why a system could not be solved.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum SparseError {
    /// A pivot was not positive: the structure is loose or unstable.
    #[error("the tangent stiffness is not positive definite")]
    Indefinite,
    /// The factor does not fit in memory.
    #[error("the stiffness matrix is too large to be factorised")]
    TooLarge,
}

/// A symmetric matrix of fixed pattern, its lower triangle by columns, and its Cholesky factor.
pub struct SparseCholesky {
    columns: Vec<u32>,
    rows: Vec<u32>,
    /// Entries of the lower triangle.
    pub values: Vec<f64>,
    symbolic: SymbolicCholesky<u32>,
    factor: Vec<f64>,
    scratch: MemBuffer,
}

impl SparseCholesky {
    /// A matrix with `n` rows that couples the unknowns of each group with one another.
    ///
    /// # Errors
    /// [`SparseError::TooLarge`].
    pub fn new<'a>(n: usize, groups: impl Iterator<Item = &'a [u32]>) -> Result<Self, SparseError> {
        let mut pairs: Vec<Vec<u32>> = (0..n as u32).map(|k| vec![k]).collect();
        for group in groups {
            for &column in group {
                let list = &mut pairs[column as usize];
                list.extend(group.iter().filter(|&&row| row > column));
                if list.len() > 4 * MERGE {
                    list.sort_unstable();
                    list.dedup();
                }
            }
        }
        let mut columns = vec![0u32];
        let mut rows = Vec::new();
        for list in &mut pairs {
            list.sort_unstable();
            list.dedup();
            rows.append(list);
            columns.push(u32::try_from(rows.len()).map_err(|_| SparseError::TooLarge)?);
        }
        let pattern = SymbolicSparseColMatRef::new_checked(n, n, &columns, None, &rows);
        let symbolic = factorize_symbolic_cholesky(
            pattern,
            Side::Lower,
            SymmetricOrdering::Amd,
            CholeskySymbolicParams::default(),
        )
        .map_err(|_| SparseError::TooLarge)?;
        let need = symbolic
            .factorize_numeric_ldlt_scratch::<f64>(Par::rayon(0), Default::default())
            .or(symbolic.solve_in_place_scratch::<f64>(1, Par::rayon(0)));
        let scratch = MemBuffer::try_new(need).map_err(|_| SparseError::TooLarge)?;
        let factor = vec![0.0; symbolic.len_val()];
        Ok(Self { values: vec![0.0; rows.len()], columns, rows, symbolic, factor, scratch })
    }

    /// Where the entry (row, column) of the lower triangle is held, if the pattern has it.
    pub fn position(&self, row: u32, column: u32) -> Option<usize> {
        let (row, column) = (row.max(column), row.min(column) as usize);
        let start = self.columns[column] as usize;
        let list = &self.rows[start..self.columns[column + 1] as usize];
        list.binary_search(&row).ok().map(|k| start + k)
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
                Par::rayon(0),
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
            Par::rayon(0),
            MemStack::new(&mut self.scratch),
        );
    }

    /// Solves for several right sides, one column after the other, with the last factor, in place.
    ///
    /// # Errors
    /// [`SparseError::TooLarge`] where there is no memory for the work.
    pub fn solve_columns(&self, columns: &mut [f64]) -> Result<(), SparseError> {
        let n = self.columns.len() - 1;
        let count = columns.len() / n.max(1);
        let need = self.symbolic.solve_in_place_scratch::<f64>(count, Par::rayon(0));
        let mut scratch = MemBuffer::try_new(need).map_err(|_| SparseError::TooLarge)?;
        LdltRef::new(&self.symbolic, &self.factor).solve_in_place_with_conj(
            Conj::No,
            MatMut::from_column_major_slice_mut(columns, n, count),
            Par::rayon(0),
            MemStack::new(&mut scratch),
        );
        Ok(())
    }

    /// Bytes held by the factor.
    pub fn factor_bytes(&self) -> usize {
        8 * self.factor.len()
    }
}

/// Entries of a column after which repeated ones are merged while the pattern is gathered.
const MERGE: usize = 512;
