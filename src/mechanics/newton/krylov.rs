//! A linear system close to one that is factorised: GMRES (Saad and Schultz, SIAM J. Sci. Stat. Comput. 7, 856, 1986).

/// Least residual, as a share of the first.
const TOLERANCE: f64 = 1e-10;
/// Most directions, each of one solve: more than what is not symmetric has ranks, for near a snap all of them count.
const DIRECTIONS: usize = 240;

/// Solves (A + B) x = `right`, where `solve` solves with A in place and `rest` multiplies by B.
pub(super) fn gmres(
    mut right: Vec<f64>,
    solve: &mut dyn FnMut(&mut [f64]),
    rest: &mut dyn FnMut(&[f64]) -> Vec<f64>,
) -> Vec<f64> {
    solve(&mut right);
    let size = norm(&right);
    if size == 0.0 {
        return right;
    }
    // Orthonormal directions; the Hessenberg matrix's columns, turned upper triangular; the residual's components.
    let mut basis = vec![right.iter().map(|r| r / size).collect::<Vec<f64>>()];
    let (mut columns, mut turns): (Vec<Vec<f64>>, Vec<[f64; 2]>) = (Vec::new(), Vec::new());
    let mut residual = vec![size];
    for k in 0..DIRECTIONS {
        let mut next = rest(&basis[k]);
        solve(&mut next);
        next.iter_mut().zip(&basis[k]).for_each(|(next, b)| *next += b);
        let mut column: Vec<f64> = Vec::with_capacity(k + 2);
        for b in &basis {
            let share: f64 = b.iter().zip(&next).map(|(b, n)| b * n).sum();
            next.iter_mut().zip(b).for_each(|(n, b)| *n -= share * b);
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
        if residual[k + 1].abs() <= TOLERANCE * size {
            break;
        }
        basis.push(next.into_iter().map(|n| n / left).collect());
    }
    let mut x = vec![0.0; right.len()];
    let mut shares = residual;
    for k in (0..columns.len()).rev() {
        shares[k] /= columns[k][k];
        let share = shares[k];
        (0..k).for_each(|i| shares[i] -= share * columns[k][i]);
        x.iter_mut().zip(&basis[k]).for_each(|(x, b)| *x += share * b);
    }
    x
}

fn norm(v: &[f64]) -> f64 {
    v.iter().map(|c| c * c).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_unsymmetric_system_is_solved() {
        // A is diagonal, B couples each unknown with the next.
        let diagonal = |k: usize| 1.0 + 0.3 * k as f64;
        let rest = |v: &[f64]| -> Vec<f64> { (0..v.len()).map(|k| 0.5 * v.get(k + 1).unwrap_or(&0.0)).collect() };
        let exact: Vec<f64> = (0..12).map(|k| f64::from(k).sin()).collect();
        let right: Vec<f64> =
            rest(&exact).iter().zip(&exact).enumerate().map(|(k, (r, x))| r + diagonal(k) * x).collect();
        let solve = &mut |v: &mut [f64]| v.iter_mut().enumerate().for_each(|(k, v)| *v /= diagonal(k));
        let found = gmres(right, solve, &mut |v| rest(v));
        for (found, exact) in found.iter().zip(&exact) {
            assert!((found - exact).abs() < 1e-8, "{found} {exact}");
        }
    }
}
