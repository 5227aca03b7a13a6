//! Laws W = g(x) of x = I1 - 3, I1 = J^(-2/3) tr(F^T F): stress g' D and tangent g'' D D + g' dD/dF, D = dI1/dF.
//!
//! x is of second order in the strain, and I1 - 3 as it stands would lose half of the digits. With the deviator A of
//! F^T F, divided by tr(F^T F)/3, and t = I1/3: t^-3 = det(1 + A) = 1 + q, q = -1/2 A:A + det A. So t - 1 =
//! -q t^3/(1 + t + t^2), where nothing cancels.

use super::algebra::{cofactor, determinant, flat, trace, twice_green_strain};
use super::{Response, Tensor};

/// g, g' and g'' at x.
pub(super) type Derivatives = [f64; 3];

/// The response of W = g(x); `None` when det F is not positive.
#[inline]
pub(super) fn respond(f: &Tensor, g: impl Fn(f64) -> Derivatives) -> Option<Response> {
    let cofactor = flat(&cofactor(f));
    let f9 = flat(f);
    let det = f9[0] * cofactor[0] + f9[1] * cofactor[1] + f9[2] * cofactor[2];
    // Written so that it refuses an undefined determinant too.
    if !(det > 0.0 && det.is_finite()) {
        return None;
    }
    let k = 1.0 / (det * det).cbrt();
    let trace_c = f9.iter().map(|entry| entry * entry).sum::<f64>();
    let inverse = cofactor.map(|entry| entry / det); // F^(-T)
    let slope: [f64; 9] = std::array::from_fn(|r| 2.0 * k * (f9[r] - trace_c / 3.0 * inverse[r]));
    let [energy, g1, g2] = g(excess(f, trace_c, k));
    let stress = slope.map(|entry| g1 * entry);
    // dD/dF = 2 k (d_ik d_JL + I1/3 (G_iL G_kJ - 2/3 G_iJ G_kL)) - 2/3 (D G + G D) with G = F^(-T), I1 = tr(F^T F).
    let shear = 2.0 / 3.0 * g1 * k * trace_c;
    let mut tangent = [[0.0; 9]; 9];
    for (r, row) in tangent.iter_mut().enumerate() {
        let (i, j) = (r / 3, r % 3);
        let along_slope = g2 * slope[r] - 2.0 / 3.0 * g1 * inverse[r];
        let along_inverse = -2.0 / 3.0 * (g1 * slope[r] + shear * inverse[r]);
        for m in 0..3 {
            let across = shear * inverse[3 * m + j];
            for l in 0..3 {
                let c = 3 * m + l;
                row[c] = along_slope * slope[c] + along_inverse * inverse[c] + across * inverse[3 * i + l];
            }
        }
        row[r] += 2.0 * g1 * k;
    }
    Some(Response { energy, stress, tangent })
}

/// x = I1 - 3, not negative; `k` is J^(-2/3) and `trace_c` tr(F^T F).
#[inline]
fn excess(f: &Tensor, trace_c: f64, k: f64) -> f64 {
    let mut a = twice_green_strain(f);
    let mean = trace(&a) / 3.0;
    for (i, row) in a.iter_mut().enumerate() {
        row[i] -= mean;
        for entry in row {
            *entry *= 3.0 / trace_c;
        }
    }
    let q = determinant(&a) - 0.5 * flat(&a).iter().map(|entry| entry * entry).sum::<f64>();
    let t = k * trace_c / 3.0;
    (-3.0 * q * t * t * t / (1.0 + t + t * t)).max(0.0)
}

/// g = mu/2 x.
#[inline]
pub(super) fn neo_hookean(x: f64, mu: f64) -> Derivatives {
    [0.5 * mu * x, 0.5 * mu, 0.0]
}

/// g = c1 x + c2 x^2 + c3 x^3.
#[inline]
pub(super) fn yeoh(x: f64, [c1, c2, c3]: &[f64; 3]) -> Derivatives {
    [x * (c1 + x * (c2 + x * c3)), c1 + x * (2.0 * c2 + x * 3.0 * c3), 2.0 * c2 + 6.0 * c3 * x]
}

/// g = (b/m) ((exp(m e) - 1)/m - e), e = sqrt(x/3).
///
/// With y = m e and psi = (exp(y) - 1 - y)/y^2: g = b e^2 psi, g' = b/6 (1 + y psi), g'' = b m/(36 e) (1 - (1 - y)
/// psi). g'' grows like 1/e towards e = 0, but D vanishes like e, so g'' D D does too. A floor of e below round-off
/// keeps it so.
#[inline]
pub(super) fn exponential(x: f64, b: f64, m: f64) -> Derivatives {
    let e = (x / 3.0).sqrt();
    let y = m * e;
    let psi = exponential_remainder(y);
    let curvature = 1.0 - (1.0 - y) * psi;
    [b * e * e * psi, b / 6.0 * (1.0 + y * psi), b * m * curvature / (36.0 * e.max(1e-15))]
}

/// (exp(y) - 1 - y)/y^2 for y >= 0. The series has 12 terms: the next is below 1e-16 for y < 0.5.
fn exponential_remainder(y: f64) -> f64 {
    if y < 0.5 {
        // 1/2 (1 + y/3 (1 + y/4 (1 + ...))).
        0.5 * (3..15).rev().fold(1.0, |sum, n| 1.0 + y / f64::from(n) * sum)
    } else {
        (y.exp_m1() - y) / (y * y)
    }
}
