//! Ogden's law in principal stretches (Ogden, Non-Linear Elastic Deformations, 1984, chapter 6).
//!
//! F = sum of l_a n_a N_a. With the principal Kirchhoff stresses beta_a and log strains e_a, in the basis n_a N_b: P_aa
//! = beta_a / l_a; the tangent is (dbeta_a/de_b - d_ab beta_a)/(l_a l_b) between diagonal entries, and between entries
//! ab and ab, ab and ba: r = (beta_a - beta_b)/(l_a^2 - l_b^2) and (r (l_a^2 + l_b^2) - beta_a - beta_b)/(2 l_a l_b).
//! Only r needs care where stretches are equal.

use super::algebra::{determinant, twice_green_strain};
use super::spectrum::eigen;
use super::{Response, Tensor};

/// Pairs of principal axes.
const PAIRS: [(usize, usize); 3] = [(0, 1), (0, 2), (1, 2)];

/// A term of Ogden's law.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OgdenTerm {
    /// mu_k, of the sign of the exponent.
    pub shear_kpa: f64,
    /// alpha_k, not 0.
    pub exponent: f64,
}

/// Sums over the terms, at the principal stretches.
#[derive(Default)]
struct Sums {
    energy: f64,
    /// Sum of mu_k (lbar_a^alpha_k - 1): beta_a is its deviator.
    stress: [f64; 3],
    /// Its derivative by log lbar_a.
    stiffness: [f64; 3],
    /// (beta_a - beta_b)/(l_a^2 - l_b^2), by [`PAIRS`].
    quotient: [f64; 3],
}

/// `None` when det F is not positive.
pub(super) fn respond(f: &Tensor, terms: &[OgdenTerm]) -> Option<Response> {
    let det = determinant(f);
    if !(det > 0.0 && det.is_finite()) {
        return None;
    }
    // Stretches from F^T F - 1: small strains keep their digits.
    let (excess, right) = eigen(&twice_green_strain(f));
    let stretch = excess.map(|excess| (1.0 + excess).sqrt());
    let sums = sums(terms, &excess, &stretch);
    // left[a] = F N_a / l_a; basis[3 a + b] = n_a N_b.
    let left: Tensor = std::array::from_fn(|a| {
        std::array::from_fn(|i| (0..3).map(|j| f[i][j] * right[a][j]).sum::<f64>() / stretch[a])
    });
    let basis: [[f64; 9]; 9] =
        std::array::from_fn(|p| std::array::from_fn(|r| left[p / 3][r / 3] * right[p % 3][r % 3]));
    let mean = sums.stress.iter().sum::<f64>() / 3.0;
    let beta = sums.stress.map(|stress| stress - mean);
    let stress = std::array::from_fn(|r| (0..3).map(|a| beta[a] / stretch[a] * basis[4 * a][r]).sum());
    let rows = tangent_rows(&sums, &beta, &stretch, &basis);
    let mut tangent = [[0.0; 9]; 9];
    for (r, row) in tangent.iter_mut().enumerate() {
        for (outer, inner) in basis.iter().zip(&rows) {
            for (entry, i) in row.iter_mut().zip(inner) {
                *entry += outer[r] * i;
            }
        }
    }
    Some(Response { energy: sums.energy, stress, tangent })
}

fn sums(terms: &[OgdenTerm], excess: &[f64; 3], stretch: &[f64; 3]) -> Sums {
    let log = excess.map(|excess| 0.5 * excess.ln_1p());
    let mean = (log[0] + log[1] + log[2]) / 3.0;
    let log = log.map(|log| log - mean);
    let mut sums = Sums::default();
    for &OgdenTerm { shear_kpa: mu, exponent: alpha } in terms {
        let power = log.map(|log| (alpha * log).exp_m1());
        sums.energy += mu / alpha * (power[0] + power[1] + power[2]);
        for (a, power) in power.into_iter().enumerate() {
            sums.stress[a] += mu * power;
            sums.stiffness[a] += mu * alpha * (1.0 + power);
        }
        for (pair, (a, b)) in PAIRS.into_iter().enumerate() {
            let apart = log[a] - log[b];
            // The plain quotient loses digits as 1/apart. The other form is exact too, and its own limit at 0.
            sums.quotient[pair] += mu
                * if apart.abs() > 1e-3 {
                    (power[a] - power[b]) / (excess[a] - excess[b])
                } else {
                    let middle = ((1.0 + power[a]) * (1.0 + power[b])).sqrt() / (stretch[a] * stretch[b]);
                    0.5 * alpha * middle * sinh_quotient(0.5 * alpha * apart) / sinh_quotient(apart)
                };
        }
    }
    sums
}

/// sinh(y)/y.
fn sinh_quotient(y: f64) -> f64 {
    if y.abs() < 1e-4 { 1.0 + y * y / 6.0 } else { y.sinh() / y }
}

/// The tangent in the basis n_a N_b, times the basis: its 21 entries that are not 0.
fn tangent_rows(sums: &Sums, beta: &[f64; 3], stretch: &[f64; 3], basis: &[[f64; 9]; 9]) -> [[f64; 9]; 9] {
    let stiffness = &sums.stiffness;
    let total = stiffness.iter().sum::<f64>();
    let mut rows = [[0.0; 9]; 9];
    let mut add = |p: usize, q: usize, factor: f64| {
        for (entry, base) in rows[p].iter_mut().zip(&basis[q]) {
            *entry += factor * base;
        }
    };
    for a in 0..3 {
        for b in 0..3 {
            // dbeta_a/de_b for isochoric stretches.
            let own = if a == b { stiffness[a] - beta[a] } else { 0.0 };
            let slope = own - (stiffness[a] + stiffness[b]) / 3.0 + total / 9.0;
            add(4 * a, 4 * b, slope / (stretch[a] * stretch[b]));
        }
    }
    for ((a, b), r) in PAIRS.into_iter().zip(sums.quotient) {
        let (la, lb) = (stretch[a], stretch[b]);
        let cross = (r * (la * la + lb * lb) - beta[a] - beta[b]) / (2.0 * la * lb);
        for (p, q) in [(3 * a + b, 3 * b + a), (3 * b + a, 3 * a + b)] {
            add(p, p, r);
            add(p, q, cross);
        }
    }
    rows
}
