//! Split conformal prediction: by what factor intervals must be widened to hold what they promise.

use super::{StatisticsError, check_finite, check_level};

/// The factor on the half width of an interval that lets it hold the truth with the probability 1 - `alpha` or more.
///
/// A score is |truth - value| / half width, of a calibration set that the intervals were not made with. The factor is
/// the ceil((n + 1) (1 - alpha))-th smallest of the n scores; it holds for what is exchangeable with them, on average
/// over calibration sets (Vovk et al. 2005; Lei et al. 2018, theorem 2.2).
///
/// # Errors
/// Fewer than 1 / alpha - 1 scores (19 for 95 %), of which no factor is known to be large enough; a score that is not
/// finite; an alpha that is not between 0 and 1.
pub fn conformal_factor(scores: &[f64], alpha: f64) -> Result<f64, StatisticsError> {
    check_level(alpha)?;
    check_finite(scores.iter().copied())?;
    // ceil((n + 1) (1 - alpha)) is n + 1 - floor((n + 1) alpha); the slack is for integers that rounding puts below.
    let slack = 1.0 + 4.0 * f64::EPSILON;
    let above = ((scores.len() as f64 + 1.0) * alpha * slack).floor() as usize;
    let place = scores.len().saturating_sub(above);
    let mut sorted = scores.to_vec();
    sorted.sort_by(f64::total_cmp);
    let needed = ((1.0 / (alpha * slack)).ceil() as usize - 1).max(1);
    sorted.get(place).copied().ok_or(StatisticsError::TooFew { what: "scores", given: scores.len(), needed })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::random::Random;

    #[test]
    fn the_factor_is_the_order_statistic_of_the_theorem() {
        let scores: Vec<f64> = (1..=19).rev().map(f64::from).collect();
        // ceil(20 * 0.95) = 19, ceil(20 * 0.9) = 18, ceil(20 * 0.5) = 10, ceil(20 * 0.01) = 1.
        for (alpha, factor) in [(0.05, 19.0), (0.1, 18.0), (0.5, 10.0), (0.99, 1.0)] {
            assert_eq!(conformal_factor(&scores, alpha), Ok(factor));
        }
        // ceil(20 * 0.96) = 20: there is no such score.
        assert!(matches!(conformal_factor(&scores, 0.04), Err(StatisticsError::TooFew { needed: 24, .. })));
        assert!(matches!(conformal_factor(&scores[1..], 0.05), Err(StatisticsError::TooFew { needed: 19, .. })));
        assert!(conformal_factor(&scores[..9], 0.1).is_ok() && conformal_factor(&[], 0.5).is_err());
    }

    /// Against integers: ceil((n + 1) (1000 - k) / 1000).
    #[test]
    fn ranks_do_not_suffer_from_rounding() {
        for per_mille in 1..1000usize {
            for n in [19usize, 99, 199, 999, 1234] {
                let rank = ((n + 1) * (1000 - per_mille)).div_ceil(1000);
                let scores: Vec<f64> = (1..=n).map(|score| score as f64).collect();
                let found = conformal_factor(&scores, per_mille as f64 / 1000.0).ok();
                assert_eq!(found, (rank <= n).then_some(rank as f64), "{n} {per_mille}");
            }
        }
    }

    /// Scores of intervals half as wide as they should be: uniform from 0 to 2. Of 40 scores the factor is the 39th, so
    /// that 39 / 41 are held: 3805 of 4000, with 4 standard deviations of 55. Unwidened, half are: 2000, with 127.
    #[test]
    fn widened_intervals_hold_what_they_promise() {
        let mut random = Random::new(9);
        let mut score = || 2.0 * random.uniform();
        let mut held = [0; 2];
        for _ in 0..4000 {
            let factor = conformal_factor(&std::array::from_fn::<f64, 40, _>(|_| score()), 0.05).unwrap();
            let new = score();
            held[0] += usize::from(new <= factor);
            held[1] += usize::from(new <= 1.0);
        }
        assert!((3750..=3860).contains(&held[0]) && (1873..=2127).contains(&held[1]), "{held:?}");
    }
}
