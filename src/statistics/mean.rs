//! Means of repeated readings.

use super::distributions::student_quantile;
use super::{StatisticsError, check_count, check_finite};
use crate::estimate::Value;

/// Mean of readings that scatter normally, in their unit.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Mean {
    /// The mean, with the 95 % interval of Student's t.
    pub mean: Value,
    /// Standard deviation of one reading, by n - 1.
    pub standard_deviation: f64,
}

impl Mean {
    /// Of two readings or more.
    ///
    /// # Errors
    /// Fewer than two; a number that is not finite or too large to be squared.
    pub fn of(readings: &[f64]) -> Result<Self, StatisticsError> {
        check_count("readings", readings.len(), 2)?;
        check_finite(readings.iter().copied())?;
        let n = readings.len() as f64;
        let mean = readings.iter().sum::<f64>() / n;
        let squares: f64 = readings.iter().map(|reading| (reading - mean).powi(2)).sum();
        let standard_deviation = (squares / (n - 1.0)).sqrt();
        check_finite([mean, standard_deviation]).map_err(|_| StatisticsError::Overflow)?;
        let half = student_quantile(n - 1.0, 0.975) * standard_deviation / n.sqrt();
        Ok(Self { mean: Value::known(mean, mean - half, mean + half), standard_deviation })
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::camera::noise::PixelRandom;
    use crate::statistics::numbers;

    /// SciPy 1.17.1: `stats.ttest_1samp(x, 0).confidence_interval()`, `numpy.std(x, ddof=1)`.
    #[test]
    fn mean_and_interval_are_those_of_scipy() {
        let found = Mean::of(&[2.3, 3.6, 6.6, 7.5, 3.1]).unwrap();
        let pinned = [4.62, 1.778_514_946_4, 7.461_485_053_6];
        assert!(numbers(&found.mean).iter().zip(pinned).all(|(a, b)| (a - b).abs() < 1e-9), "{found:?}");
        assert!((found.standard_deviation - 2.288_449_256_6).abs() < 1e-9, "{found:?}");
        assert!(
            Mean::of(&[1.0]).is_err() && Mean::of(&[1.0, f64::NAN]).is_err() && Mean::of(&[1e308, -1e308]).is_err()
        );
    }

    /// Of five readings each, 95 % of intervals hold the mean; without Student's widening 88 % would.
    #[test]
    fn intervals_hold_the_mean() {
        let mut random = PixelRandom::new(3, 1);
        let mut normal = || (0..12).map(|_| random.uniform()).sum::<f64>() - 6.0;
        let held = (0..4000).filter(|_| {
            let [_, low, high] =
                numbers(&Mean::of(&std::array::from_fn::<f64, 5, _>(|_| 7.0 + normal())).unwrap().mean);
            (low..=high).contains(&7.0)
        });
        let held = held.count();
        assert!((3745..=3855).contains(&held), "{held}");
    }
}
