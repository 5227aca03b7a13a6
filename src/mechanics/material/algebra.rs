//! Tensors of three dimensions.

use super::Tensor;

/// Determinant.
pub(super) fn determinant(f: &Tensor) -> f64 {
    let c = cofactor(f);
    f[0][0] * c[0][0] + f[0][1] * c[0][1] + f[0][2] * c[0][2]
}

/// Cofactor J F^(-T).
pub(super) fn cofactor(f: &Tensor) -> Tensor {
    let minor = |i: usize, j: usize| {
        let ([p, q], [r, s]) = (others(i), others(j));
        f[p][r] * f[q][s] - f[p][s] * f[q][r]
    };
    std::array::from_fn(|i| std::array::from_fn(|j| minor(i, j)))
}

/// The two axes after `axis`, cyclic.
pub(super) fn others(axis: usize) -> [usize; 2] {
    [(axis + 1) % 3, (axis + 2) % 3]
}

/// Row by row, as in [`super::Response::stress`].
pub(super) fn flat(f: &Tensor) -> [f64; 9] {
    std::array::from_fn(|r| f[r / 3][r % 3])
}

/// F^T F - 1, from F - 1: good to round-off of the strain where the strain is small and the rotation too.
pub(super) fn twice_green_strain(f: &Tensor) -> Tensor {
    let mut h = *f;
    for (i, row) in h.iter_mut().enumerate() {
        row[i] -= 1.0;
    }
    std::array::from_fn(|i| {
        std::array::from_fn(|j| h[i][j] + h[j][i] + (h[0][i] * h[0][j] + h[1][i] * h[1][j] + h[2][i] * h[2][j]))
    })
}

/// Trace.
pub(super) fn trace(s: &Tensor) -> f64 {
    s[0][0] + s[1][1] + s[2][2]
}
