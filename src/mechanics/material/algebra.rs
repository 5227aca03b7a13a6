//! Tensors of three dimensions.

use super::Tensor;

/// Determinant.
#[inline]
pub(super) fn determinant(f: &Tensor) -> f64 {
    let c = cofactor(f);
    f[0][0] * c[0][0] + f[0][1] * c[0][1] + f[0][2] * c[0][2]
}

/// Cofactor J F^(-T).
#[inline]
pub(super) fn cofactor(f: &Tensor) -> Tensor {
    let [x, y, z] = f;
    [cross(y, z), cross(z, x), cross(x, y)]
}

#[inline]
fn cross(a: &[f64; 3], b: &[f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Row by row, as in [`super::Response::stress`].
#[inline]
pub(super) fn flat(f: &Tensor) -> [f64; 9] {
    let [x, y, z] = f;
    [x[0], x[1], x[2], y[0], y[1], y[2], z[0], z[1], z[2]]
}

/// F^T F - 1, from F - 1: good to round-off of the strain where the strain is small and the rotation too.
#[inline]
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
#[inline]
pub(super) fn trace(s: &Tensor) -> f64 {
    s[0][0] + s[1][1] + s[2][2]
}
