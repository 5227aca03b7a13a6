//! Tail probabilities of the comparison test. `statrs` holds the special functions.

use statrs::distribution::{ChiSquared, ContinuousCDF, StudentsT};
use statrs::function::erf::{erfc, erfc_inv};

/// Above this many degrees of freedom Student's t is the normal distribution to 1e-4 at any z up to 6.
const NORMAL_FROM: f64 = 1.0e6;

/// Below this, a probability is as good as none; keeps normal equivalents finite (37 standard deviations).
const SMALLEST: f64 = 1.0e-300;

/// Probability that Student's t of `freedom` degrees exceeds `|z|` on either side.
pub(super) fn two_sided(z: f64, freedom: f64) -> f64 {
    let z = z.abs();
    let normal = || erfc(z / std::f64::consts::SQRT_2);
    if freedom >= NORMAL_FROM {
        return normal();
    }
    StudentsT::new(0.0, 1.0, freedom).map_or_else(|_| normal(), |t| 2.0 * t.sf(z))
}

/// The standard normal deviate that is exceeded on either side with probability `p`.
pub(super) fn normal_deviate(p: f64) -> f64 {
    std::f64::consts::SQRT_2 * erfc_inv(p.clamp(SMALLEST, 1.0))
}

/// Probability that chi-square of `freedom` degrees exceeds `value`.
pub(super) fn chi_square(value: f64, freedom: f64) -> f64 {
    ChiSquared::new(freedom).map_or(1.0, |chi| chi.sf(value))
}

/// Student's t of `freedom` degrees that holds 95 % between minus and plus itself.
pub fn quantile_95(freedom: f64) -> f64 {
    const NORMAL: f64 = 1.959_963_984_540_054;
    if freedom >= NORMAL_FROM {
        return NORMAL;
    }
    StudentsT::new(0.0, 1.0, freedom).map_or(NORMAL, |t| t.inverse_cdf(0.975))
}

/// The deviate that Student's t of `freedom` degrees exceeds on either side with probability `p`, to 1e-9.
pub(super) fn two_sided_quantile(p: f64, freedom: f64) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    while two_sided(high, freedom) > p && high < 1e12 {
        high *= 2.0;
    }
    while high - low > 1e-9 * high {
        let middle = 0.5 * (low + high);
        if two_sided(middle, freedom) > p { low = middle } else { high = middle }
    }
    high
}

/// How many standard errors a difference must have to exceed the deviate of `p` in 90 of 100 cases: the noncentral t by
/// its normal approximation (Johnson and Welch 1940).
pub(super) fn seen_in_90_percent(p: f64, freedom: f64) -> f64 {
    const NORMAL_90: f64 = 1.281_551_565_544_6;
    let deviate = two_sided_quantile(p, freedom);
    deviate * (1.0 - 0.25 / freedom) + NORMAL_90 * (1.0 + deviate * deviate / (2.0 * freedom)).sqrt()
}

/// Mean of independent values, and half of its 95 % interval; nothing is known of the spread of a single value.
pub fn mean_interval(values: &[f64]) -> [f64; 2] {
    let n = values.len().max(1) as f64;
    let freedom = (n - 1.0).max(1.0);
    let mean = values.iter().sum::<f64>() / n;
    let spread = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / freedom;
    [mean, quantile_95(freedom) * (spread / n).sqrt()]
}

/// Probability that the smallest of `tests` independent p-values is at most `p` (Sidak 1967).
pub(super) fn sidak(p: f64, tests: f64) -> f64 {
    -(tests * (-p.min(1.0)).ln_1p()).exp_m1()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values of scipy.stats, given there to 10 digits.
    #[test]
    fn tails_are_those_of_the_tables() {
        let close = |found: f64, expected: f64| {
            assert!((found / expected - 1.0).abs() < 1e-8, "{found} is not {expected}");
        };
        close(two_sided(2.131_449_546, 15.0), 0.05);
        close(two_sided(-6.0, f64::INFINITY), 1.973_175_290e-9);
        close(chi_square(18.307_038_05, 10.0), 0.05);
        close(quantile_95(15.0), 2.131_449_546);
        close(normal_deviate(0.05), 1.959_963_985);
        close(sidak(1e-12, 1e5), 1e-7 * (1.0 - 5e-8));
        close(two_sided_quantile(0.05, 15.0), 2.131_449_546);
        // Noncentralities at which scipy.stats.nct leaves 0.9 above the deviate; the approximation is good to 1e-3.
        for (p, freedom, exact) in [(0.05, 15.0, 3.470_88), (1e-3, 15.0, 5.603_04), (1e-7, 30.0, 8.622_95)] {
            assert!((seen_in_90_percent(p, freedom) / exact - 1.0).abs() < 1e-3, "{p}");
        }
        assert!((seen_in_90_percent(0.05, f64::INFINITY) - 3.241_515).abs() < 1e-5);
    }
}
