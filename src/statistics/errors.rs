//! How far estimates lie from the truth.

use super::{Pair, StatisticsError, check_count, check_finite};

/// Errors of estimates, in the unit of the pairs where nothing else is said.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Errors {
    /// Mean of estimate - truth.
    pub bias: f64,
    /// Mean of |estimate - truth|.
    pub mean_absolute: f64,
    /// Root of the mean of (estimate - truth)^2.
    pub root_mean_square: f64,
    /// Mean of |estimate - truth| / |truth|, a ratio; `None` where a truth is 0.
    pub mean_relative: Option<f64>,
    /// Median of |estimate - truth| / |truth|, a ratio; `None` where a truth is 0.
    pub median_relative: Option<f64>,
}

impl Errors {
    /// Errors of one pair or more.
    ///
    /// # Errors
    /// No pair; a number that is not finite; numbers too large to be squared.
    pub fn of(pairs: &[Pair]) -> Result<Self, StatisticsError> {
        check_count("pairs", pairs.len(), 1)?;
        check_finite(pairs.iter().flat_map(|pair| [pair.truth, pair.estimate]))?;
        let n = pairs.len() as f64;
        let errors = || pairs.iter().map(|pair| pair.estimate - pair.truth);
        let relative = (pairs.iter().all(|pair| pair.truth != 0.0))
            .then(|| pairs.iter().map(|pair| ((pair.estimate - pair.truth) / pair.truth).abs()).collect::<Vec<f64>>());
        let found = Self {
            bias: errors().sum::<f64>() / n,
            mean_absolute: errors().map(f64::abs).sum::<f64>() / n,
            root_mean_square: (errors().map(|error| error * error).sum::<f64>() / n).sqrt(),
            mean_relative: relative.as_ref().map(|ratios| ratios.iter().sum::<f64>() / n),
            median_relative: relative.and_then(median),
        };
        let ratios = found.mean_relative.into_iter().chain(found.median_relative);
        check_finite([found.root_mean_square].into_iter().chain(ratios)).map_err(|_| StatisticsError::Overflow)?;
        Ok(found)
    }
}

/// The middle number, or the mean of the middle two.
fn median(mut numbers: Vec<f64>) -> Option<f64> {
    numbers.sort_by(f64::total_cmp);
    let [low, high] = [numbers.len().saturating_sub(1) / 2, numbers.len() / 2];
    Some(0.5 * (numbers.get(low)? + numbers.get(high)?))
}

#[cfg(test)]
mod tests {
    use super::*;

    const TRUTH: [f64; 8] = [2.0, 4.0, 6.0, 8.0, 3.0, 5.0, 7.0, 9.0];
    const FOUND: [f64; 8] = [2.3, 3.6, 6.6, 7.5, 3.1, 5.9, 6.8, 9.4];

    fn pairs(truth: [f64; 8], estimate: [f64; 8]) -> Vec<Pair> {
        truth.into_iter().zip(estimate).map(|(truth, estimate)| Pair { truth, estimate }).collect()
    }

    /// statsmodels 0.15.0, `tools.eval_measures`: `bias`, `meanabs`, `rmse` of (FOUND, TRUTH); the relative ones are
    /// `meanabs` and `medianabs` of (FOUND / TRUTH, 1).
    #[test]
    fn errors_are_those_of_statsmodels() {
        let errors = Errors::of(&pairs(TRUTH, FOUND)).unwrap();
        let ratios = [errors.mean_relative.unwrap(), errors.median_relative.unwrap()];
        let found = [errors.bias, errors.mean_absolute, errors.root_mean_square, ratios[0], ratios[1]];
        let pinned = [0.15, 0.425, 0.484_767_985_741_633, 0.087_356_150_793_651, 0.081_25];
        for (found, pinned) in found.iter().zip(pinned) {
            assert!((found - pinned).abs() < 1e-14, "{found} {pinned}");
        }
    }

    #[test]
    fn a_planted_bias_is_found_and_a_swap_turns_its_sign() {
        let errors = |truth, found| Errors::of(&pairs(truth, found)).unwrap();
        let [fair, biased] = [errors(TRUTH, FOUND), errors(TRUTH, FOUND.map(|found| found + 0.7))];
        assert!((biased.bias - fair.bias - 0.7).abs() < 1e-14);
        assert!(biased.root_mean_square > fair.root_mean_square);
        let swapped = errors(FOUND, TRUTH);
        assert!((swapped.bias + fair.bias).abs() < 1e-15 && swapped.mean_relative != fair.mean_relative);
    }

    #[test]
    fn what_cannot_be_told_is_said() {
        let zero = Errors::of(&[Pair { truth: 0.0, estimate: 1.0 }]).unwrap();
        assert_eq!((zero.bias, zero.mean_relative, zero.median_relative), (1.0, None, None));
        assert!(matches!(Errors::of(&[]), Err(StatisticsError::TooFew { needed: 1, .. })));
        let nan = Errors::of(&[Pair { truth: 1.0, estimate: f64::NAN }]);
        assert_eq!(nan, Err(StatisticsError::NotFinite(1)));
        assert_eq!(Errors::of(&[Pair { truth: 1e308, estimate: -1e308 }]), Err(StatisticsError::Overflow));
    }
}
