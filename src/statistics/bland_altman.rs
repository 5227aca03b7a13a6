//! Limits of agreement of estimate and truth, or of two methods.

use super::distributions::{normal_quantile, student_quantile};
use super::{Pair, StatisticsError, check_count, check_finite};
use crate::estimate::Value;

/// Where the differences estimate - truth lie, in the unit of the pairs, each with its 95 % interval.
///
/// For differences that are normal and do not grow with the size of what is measured (Bland & Altman 1999, section 2).
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct BlandAltman {
    /// Mean difference.
    pub mean: Value,
    /// Mean less 1.96 standard deviations: one difference in 40 is lower.
    pub low_limit: Value,
    /// Mean plus 1.96 standard deviations: one difference in 40 is higher.
    pub high_limit: Value,
}

impl BlandAltman {
    /// The limits of two pairs or more.
    ///
    /// With the variance s^2 of n differences, that of their mean is s^2 / n and that of a limit s^2 (1 / n + 1.96^2 /
    /// (2 (n - 1))), both taken as Student's t of n - 1 degrees. The paper of 1986 rounds the latter to 3 s^2 / n.
    ///
    /// # Errors
    /// Fewer than two pairs; a number that is not finite.
    pub fn of(pairs: &[Pair]) -> Result<Self, StatisticsError> {
        check_count("pairs", pairs.len(), 2)?;
        check_finite(pairs.iter().flat_map(|pair| [pair.truth, pair.estimate]))?;
        let n = pairs.len() as f64;
        let differences = || pairs.iter().map(|pair| pair.estimate - pair.truth);
        let mean = differences().sum::<f64>() / n;
        let deviation = (differences().map(|d| (d - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt();
        let (z, t) = (normal_quantile(0.975), student_quantile(n - 1.0, 0.975));
        let about = |value: f64, variance: f64| {
            let half = t * deviation * variance.sqrt();
            Value::known(value, value - half, value + half)
        };
        let limit = |side: f64| about(mean + side * z * deviation, 1.0 / n + z * z / (2.0 * (n - 1.0)));
        Ok(Self { mean: about(mean, 1.0 / n), low_limit: limit(-1.0), high_limit: limit(1.0) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::numbers;

    /// Peak expiratory flow in l/min of 17 people by two meters: table 1 of Bland & Altman (1986).
    const LARGE: [f64; 17] = [
        494.0, 395.0, 516.0, 434.0, 476.0, 557.0, 413.0, 442.0, 650.0, 433.0, 417.0, 656.0, 267.0, 478.0, 178.0, 423.0,
        427.0,
    ];
    const MINI: [f64; 17] = [
        512.0, 430.0, 520.0, 428.0, 500.0, 600.0, 364.0, 380.0, 658.0, 445.0, 432.0, 626.0, 260.0, 477.0, 259.0, 350.0,
        451.0,
    ];

    fn all(truth: [f64; 17], estimate: [f64; 17]) -> [[f64; 3]; 3] {
        let pairs: Vec<Pair> =
            truth.into_iter().zip(estimate).map(|(truth, estimate)| Pair { truth, estimate }).collect();
        let BlandAltman { mean, low_limit, high_limit } = BlandAltman::of(&pairs).unwrap();
        [&mean, &low_limit, &high_limit].map(numbers)
    }

    /// SciPy 1.17.1: `stats.t.interval(0.95, 16, loc, scale)` with the standard errors of the paper of 1999. Means and
    /// limits, and the mean's interval, are those of pingouin 0.7.0 `plot_blandaltman`.
    #[test]
    fn limits_and_their_intervals_are_those_of_scipy() {
        let pinned = [
            [-2.117_647_058_824, -22.048_837_696_645, 17.813_543_578_998],
            [-78.095_905_467_112, -112.851_553_139_311, -43.340_257_794_913],
            [73.860_611_349_465, 39.104_963_677_266, 108.616_259_021_664],
        ];
        for (found, pinned) in all(MINI, LARGE).iter().flatten().zip(pinned.iter().flatten()) {
            assert!((found - pinned).abs() < 1e-10, "{found} {pinned}");
        }
    }

    /// Limits of the paper are by 2 standard deviations of 38.8, not 1.96, and by 3 s^2 / n, whose root is 0.5 % below
    /// ours: 0.04 and 2.12 * 0.42 * 0.5 % of 38.8 apart, and 0.1 by rounding.
    #[test]
    fn limits_are_those_of_the_paper_to_its_roundings() {
        let paper = [-2.1, -22.0, 17.8, -79.7, -114.3, -45.1, 75.5, 40.9, 110.1];
        for (place, (found, paper)) in all(MINI, LARGE).iter().flatten().zip(paper).enumerate() {
            let rounding = if place < 3 { 0.1 } else { 0.05 * 38.8 + 0.1 };
            assert!((found - paper).abs() < rounding, "{found} {paper}");
        }
    }

    #[test]
    fn a_planted_bias_moves_all_and_a_swap_mirrors_all() {
        let [fair, biased, swapped] = [all(MINI, LARGE), all(MINI, LARGE.map(|x| x + 10.0)), all(LARGE, MINI)];
        for (fair, biased) in fair.iter().flatten().zip(biased.iter().flatten()) {
            assert!((biased - fair - 10.0).abs() < 1e-10);
        }
        for (limit, mirrored) in [(0, 0), (1, 2), (2, 1)] {
            let [value, low, high] = fair[limit];
            assert!([value, high, low].iter().zip(swapped[mirrored]).all(|(a, b)| (a + b).abs() < 1e-10));
        }
    }

    #[test]
    fn one_pair_is_refused_and_equal_differences_are_a_point() {
        let pair = Pair { truth: 1.0, estimate: 3.0 };
        assert!(BlandAltman::of(&[pair]).is_err());
        assert_eq!(BlandAltman::of(&[pair; 4]).unwrap().low_limit, Value::known(2.0, 2.0, 2.0));
    }
}
