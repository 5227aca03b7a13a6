//! Eigenvalues of a symmetric tensor by Jacobi's method (Golub and Van Loan, Matrix Computations, 8.5).
//!
//! It needs no case distinction where eigenvalues are equal or nearly so: the vectors are orthonormal to round-off
//! always.

use super::Tensor;

/// Eigenvalues of the symmetric `s`, in no order, and the unit eigenvectors as rows.
pub(super) fn eigen(s: &Tensor) -> ([f64; 3], Tensor) {
    let mut a = *s;
    let mut columns = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let size = s.iter().flatten().map(|entry| entry.abs()).fold(0.0, f64::max);
    // Convergence is quadratic: 4 or 5 sweeps. The bound only stops undefined input.
    for _ in 0..16 {
        if a[0][1].abs() + a[0][2].abs() + a[1][2].abs() <= 1e-17 * size {
            break;
        }
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            rotate(&mut a, &mut columns, p, q);
        }
    }
    ([a[0][0], a[1][1], a[2][2]], std::array::from_fn(|p| columns.map(|row| row[p])))
}

/// Turns axes p and q so that a[p][q] becomes 0.
fn rotate(a: &mut Tensor, columns: &mut Tensor, p: usize, q: usize) {
    let off = a[p][q];
    if off == 0.0 {
        return;
    }
    let theta = (a[q][q] - a[p][p]) / (2.0 * off);
    let tangent = theta.signum() / (theta.abs() + (theta * theta + 1.0).sqrt());
    let cosine = 1.0 / (tangent * tangent + 1.0).sqrt();
    let sine = tangent * cosine;
    a[p][p] -= tangent * off;
    a[q][q] += tangent * off;
    a[p][q] = 0.0;
    a[q][p] = 0.0;
    let r = 3 - p - q;
    let (rp, rq) = (a[r][p], a[r][q]);
    a[r][p] = cosine * rp - sine * rq;
    a[r][q] = sine * rp + cosine * rq;
    a[p][r] = a[r][p];
    a[q][r] = a[r][q];
    for row in columns {
        let (vp, vq) = (row[p], row[q]);
        row[p] = cosine * vp - sine * vq;
        row[q] = sine * vp + cosine * vq;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eigenvalues_and_vectors_rebuild_the_tensor_also_where_values_are_equal() {
        let mixed = [[2.0, 1.0, 0.5], [1.0, -1.0, 0.25], [0.5, 0.25, 0.75]];
        let twin = [[1.0, 0.0, 1e-9], [0.0, 1.0, 1e-13], [1e-9, 1e-13, 1.0]];
        let rank_one = [[1.0, 1.0, 1.0], [1.0, 1.0, 1.0], [1.0, 1.0, 1.0]];
        let graded = [[1e6, 1.0, 1e-3], [1.0, 1.0, 1e-3], [1e-3, 1e-3, 1e-6]];
        for s in [mixed, twin, rank_one, graded, [[0.0; 3]; 3]] {
            let (values, vectors) = eigen(&s);
            let size = s.iter().flatten().fold(0.0f64, |most, entry| most.max(entry.abs()));
            for i in 0..3 {
                for j in 0..3 {
                    let rebuilt = (0..3).map(|a| values[a] * vectors[a][i] * vectors[a][j]).sum::<f64>();
                    // Some thirty rotations of round-off each.
                    assert!((rebuilt - s[i][j]).abs() < 1e-14 * size.max(f64::MIN_POSITIVE), "{s:?}");
                    let product = (0..3).map(|k| vectors[i][k] * vectors[j][k]).sum::<f64>();
                    assert!((product - f64::from(u8::from(i == j))).abs() < 1e-14, "{s:?}");
                }
            }
        }
    }
}
