//! Hooke's law for small strain: P = 2 mu dev(eps), eps = sym(F - 1).

use super::{Response, Tensor};

#[inline]
pub(super) fn respond(f: &Tensor, mu: f64) -> Response {
    let strain = deviatoric_strain(f);
    let stress = strain.map(|e| 2.0 * mu * e);
    let energy = mu * strain.iter().map(|e| e * e).sum::<f64>();
    Response { energy, stress, tangent: tangent(mu) }
}

/// dev sym (F - 1), entry 3 i + j.
#[inline]
fn deviatoric_strain(f: &Tensor) -> [f64; 9] {
    let mean = ((f[0][0] - 1.0) + (f[1][1] - 1.0) + (f[2][2] - 1.0)) / 3.0;
    std::array::from_fn(|r| {
        let (i, j) = (r / 3, r % 3);
        if i == j { f[i][i] - 1.0 - mean } else { 0.5 * (f[i][j] + f[j][i]) }
    })
}

/// mu (d_ik d_jl + d_il d_jk - 2/3 d_ij d_kl).
#[inline]
fn tangent(mu: f64) -> [[f64; 9]; 9] {
    let delta = |a: usize, b: usize| if a == b { 1.0 } else { 0.0 };
    std::array::from_fn(|r| {
        std::array::from_fn(|c| {
            let (i, j, k, l) = (r / 3, r % 3, c / 3, c % 3);
            mu * (delta(i, k) * delta(j, l) + delta(i, l) * delta(j, k) - 2.0 / 3.0 * delta(i, j) * delta(k, l))
        })
    })
}
