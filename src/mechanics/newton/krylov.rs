//! Linear systems that are not symmetric: GMRES (Saad and Schultz, SIAM J. Sci. Stat. Comput. 7, 856, 1986).

use rayon::prelude::*;

/// Solves for `right`, given how a vector is multiplied, until the residual is `tolerance` of the first or `directions`
/// are spent. The residual that is left comes second, as a share.
pub(super) fn gmres(
    right: Vec<f64>,
    multiply: &mut dyn FnMut(&[f64]) -> Vec<f64>,
    tolerance: f64,
    directions: usize,
) -> (Vec<f64>, f64) {
    let size = norm(&right);
    if size == 0.0 {
        return (right, 0.0);
    }
    // Orthonormal directions; the Hessenberg matrix's columns, turned upper triangular; the residual's components.
    let count = right.len();
    let mut basis = vec![scaled(right, 1.0 / size)];
    let (mut columns, mut turns): (Vec<Vec<f64>>, Vec<[f64; 2]>) = (Vec::new(), Vec::new());
    let mut residual = vec![size];
    for k in 0..directions {
        let mut next = multiply(&basis[k]);
        let mut column: Vec<f64> = Vec::with_capacity(k + 2);
        for b in &basis {
            let share = dot(b, &next);
            add(&mut next, -share, b);
            column.push(share);
        }
        let left = norm(&next);
        for (i, [c, s]) in turns.iter().enumerate() {
            (column[i], column[i + 1]) = (c * column[i] + s * column[i + 1], c * column[i + 1] - s * column[i]);
        }
        let diagonal = column[k].hypot(left);
        let turn = [column[k] / diagonal, left / diagonal];
        column[k] = diagonal;
        columns.push(column);
        turns.push(turn);
        residual.push(-turn[1] * residual[k]);
        residual[k] *= turn[0];
        if residual[k + 1].abs() <= tolerance * size {
            break;
        }
        basis.push(scaled(next, 1.0 / left));
    }
    let reached = residual[columns.len()].abs() / size;
    let mut x = vec![0.0; count];
    let mut shares = residual;
    for k in (0..columns.len()).rev() {
        shares[k] /= columns[k][k];
        let share = shares[k];
        (0..k).for_each(|i| shares[i] -= share * columns[k][i]);
        add(&mut x, share, &basis[k]);
    }
    (x, reached)
}

/// Entries that a thread takes at a time.
const CHUNK: usize = 1 << 14;

/// A scalar product whose bits do not depend on the number of threads.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let sums = a.par_chunks(CHUNK).zip(b.par_chunks(CHUNK));
    let sums: Vec<f64> = sums.map(|(a, b)| a.iter().zip(b).map(|(a, b)| a * b).sum()).collect();
    sums.iter().sum()
}

fn add(to: &mut [f64], share: f64, of: &[f64]) {
    to.par_chunks_mut(CHUNK).zip(of.par_chunks(CHUNK)).for_each(|(to, of)| {
        to.iter_mut().zip(of).for_each(|(to, of)| *to += share * of);
    });
}

fn scaled(mut v: Vec<f64>, by: f64) -> Vec<f64> {
    v.iter_mut().for_each(|v| *v *= by);
    v
}

fn norm(v: &[f64]) -> f64 {
    dot(v, v).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_unsymmetric_system_is_solved() {
        // A diagonal, and each unknown coupled with the next.
        let mut multiply = |v: &[f64]| -> Vec<f64> {
            (0..v.len()).map(|k| (1.0 + 0.3 * k as f64) * v[k] + 0.5 * v.get(k + 1).unwrap_or(&0.0)).collect()
        };
        let exact: Vec<f64> = (0..12).map(|k| f64::from(k).sin()).collect();
        let (found, reached) = gmres(multiply(&exact), &mut multiply, 1e-10, 240);
        assert!(reached <= 1e-10);
        for (found, exact) in found.iter().zip(&exact) {
            assert!((found - exact).abs() < 1e-8, "{found} {exact}");
        }
    }
}
