//! Simulation-based calibration: whether posteriors are as wide as they should be.
//!
//! The truth is drawn from the prior, data from the truth, and L draws from the posterior of the data. The rank of the
//! truth is the number of draws below it, 0 to L. Ranks are uniform where the posterior is right (Talts et al., arXiv
//! 1804.06788). They pile up at both ends where it is too narrow, in the middle where it is too wide, at one end where
//! it is biased.

use super::distributions::chi_square_share;
use super::{StatisticsError, check_count};

/// Fewest ranks expected in a bin for which the chi-square distribution holds (Cochran 1952).
const FEWEST_A_BIN: usize = 5;

/// How many ranks lie in each bin, and whether that is uniform.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct RankHistogram {
    /// Number of ranks in each bin, from the lowest ranks up.
    pub counts: Vec<usize>,
    /// Sum of (count - expected)^2 / expected.
    pub chi_square: f64,
    /// Probability of as large a sum or larger by uniform ranks.
    pub p_value: f64,
}

impl RankHistogram {
    /// The histogram of ranks from 0 to `draws` in `bins` bins of as many ranks each.
    ///
    /// # Errors
    /// Fewer than two bins, or a number that does not divide `draws` + 1; fewer than five ranks a bin; a rank above
    /// `draws`.
    pub fn of(ranks: &[usize], draws: usize, bins: usize) -> Result<Self, StatisticsError> {
        let places = draws.checked_add(1).filter(|places| bins >= 2 && places.is_multiple_of(bins));
        let uneven = || format!("{bins} bins for ranks 0 to {draws}: give two or more of as many ranks each");
        let width = places.ok_or_else(|| StatisticsError::Impossible(uneven()))? / bins;
        check_count("ranks", ranks.len(), FEWEST_A_BIN.saturating_mul(bins))?;
        let mut counts = vec![0; bins];
        for &rank in ranks {
            let above = || format!("rank {rank} of {draws} draws: give the number of draws below the truth");
            let count = counts.get_mut(rank / width).ok_or_else(|| StatisticsError::Impossible(above()))?;
            *count += 1;
        }
        let expected = ranks.len() as f64 / bins as f64;
        let chi_square = counts.iter().map(|&count| (count as f64 - expected).powi(2) / expected).sum();
        let p_value = 1.0 - chi_square_share((bins - 1) as f64, chi_square);
        Ok(Self { counts, chi_square, p_value })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::random::Random;

    const DRAWS: usize = 99;

    /// Ranks of 200 truths: how many of 99 draws are lower, scaled by `width` about the middle and moved by `bias`.
    fn histogram(random: &mut Random, width: f64, bias: f64) -> RankHistogram {
        let mut rank = || {
            let truth = random.uniform();
            (0..DRAWS).filter(|_| 0.5 + width * (random.uniform() - 0.5) + bias < truth).count()
        };
        let ranks: Vec<usize> = (0..200).map(|_| rank()).collect();
        RankHistogram::of(&ranks, DRAWS, 10).unwrap()
    }

    /// SciPy 1.17.1: `stats.chisquare(counts)`.
    #[test]
    fn chi_square_and_p_are_those_of_scipy() {
        let counts = [12, 7, 9, 15, 8, 9];
        let ranks: Vec<usize> = counts.iter().enumerate().flat_map(|(bin, &n)| vec![3 * bin + 1; n]).collect();
        let found = RankHistogram::of(&ranks, 17, 6).unwrap();
        assert_eq!(found.counts, counts);
        let pinned = [4.4, 0.49337352355883735];
        assert!((found.chi_square - pinned[0]).abs() < 1e-13 && (found.p_value - pinned[1]).abs() < 1e-13, "{found:?}");
        let even: Vec<usize> = (0..90).map(|i| i % 18).collect();
        assert_eq!(RankHistogram::of(&even, 17, 6).unwrap().p_value, 1.0);
    }

    /// p-values of right posteriors in ten bins of 40 expected: the same test on them must not be significant at 1e-3,
    /// and of 400 no more than 20 + 4 standard deviations (17) may lie below 0.05.
    #[test]
    fn p_values_of_right_posteriors_are_uniform() {
        let mut random = Random::new(5);
        let p: Vec<f64> = (0..400).map(|_| histogram(&mut random, 1.0, 0.0).p_value).collect();
        let bins: Vec<usize> = p.iter().map(|p| ((p * 100.0) as usize).min(DRAWS)).collect();
        assert!(RankHistogram::of(&bins, DRAWS, 10).unwrap().p_value > 1e-3);
        assert!(p.iter().filter(|p| **p < 0.05).count() <= 37);
    }

    #[test]
    fn narrow_wide_and_biased_posteriors_are_found_by_their_shape() {
        let mut random = Random::new(6);
        let mut shape = |width, bias| {
            let found = histogram(&mut random, width, bias);
            assert!(found.p_value < 1e-3, "{found:?}");
            let of = |bins: &[usize]| bins.iter().map(|&bin| found.counts[bin]).sum::<usize>();
            [of(&[0, 1]), of(&[4, 5]), of(&[8, 9])]
        };
        let ([low, middle, high], [low_w, middle_w, high_w]) = (shape(0.6, 0.0), shape(1.6, 0.0));
        assert!(low > middle && high > middle && low_w < middle_w && high_w < middle_w);
        let [low, _, high] = shape(1.0, 0.2);
        assert!(low > high);
    }

    #[test]
    fn bad_bins_and_ranks_are_refused() {
        let refused = |rank, n, draws, bins| RankHistogram::of(&vec![rank; n], draws, bins).unwrap_err();
        assert!(refused(0, 50, 99, 7).to_string().starts_with("7 bins for ranks 0 to 99"));
        assert!(refused(100, 50, 99, 10).to_string().starts_with("rank 100 of 99 draws"));
        assert!(matches!(refused(0, 49, 99, 10), StatisticsError::TooFew { needed: 50, .. }));
        assert!(matches!(refused(0, 50, usize::MAX, 10), StatisticsError::Impossible(_)));
    }
}
