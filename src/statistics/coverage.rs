//! How often intervals hold the truth.

use super::distributions::beta_quantile;
use super::{StatisticsError, check_level};
use crate::estimate::Value;

/// Most trials: to here the incomplete beta function is exact to 1e-9, beyond its continued fraction is cut short.
const MOST_TRIALS: usize = 100_000;

/// The share of `hits` in `trials` with its Clopper-Pearson interval of `level`, such as 0.95.
///
/// Whatever the true share is, the interval holds it with the probability `level` or more (Clopper & Pearson 1934). Its
/// low end is 0 where nothing is hit and its high end 1 where all is. Undefined without trials.
///
/// # Errors
/// More hits than trials; more than 100 000 trials; a level that is not between 0 and 1.
pub fn clopper_pearson(hits: usize, trials: usize, level: f64) -> Result<Value, StatisticsError> {
    check_level(level)?;
    if hits > trials {
        return Err(StatisticsError::Impossible(format!("{hits} hits of {trials} trials: count each trial once")));
    }
    if trials > MOST_TRIALS {
        return Err(StatisticsError::Impossible(format!("{trials} trials given: give {MOST_TRIALS} or fewer")));
    }
    if trials == 0 {
        return Ok(Value::undefined("there are no trials"));
    }
    let tail = 0.5 * (1.0 - level);
    let [hit, missed] = [hits, trials - hits].map(|count| count as f64);
    let low = if hits == 0 { 0.0 } else { beta_quantile(hit, missed + 1.0, tail) };
    // The quantile of the misses, for 1 - tail would lose the digits of a small tail.
    let high = if hits == trials { 1.0 } else { 1.0 - beta_quantile(missed, hit + 1.0, tail) };
    Ok(Value::known(hit / trials as f64, low, high))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::{numbers, random::Random};

    fn ends(hits: usize, trials: usize, level: f64) -> [f64; 2] {
        let [_, low, high] = numbers(&clopper_pearson(hits, trials, level).unwrap());
        [low, high]
    }

    /// SciPy 1.17.1: `stats.binomtest(k, n).proportion_ci(level, 'exact')`; statsmodels 0.15.0,
    /// `stats.proportion.proportion_confint(k, n, 1 - level, 'beta')`, gives the same to 1e-13.
    #[test]
    fn intervals_are_those_of_scipy() {
        let pinned = [
            ((0, 10, 0.95), [0.0, 0.30849710781876294]),
            ((1, 10, 0.95), [0.0025285785444625728, 0.44501611702819543]),
            ((5, 10, 0.95), [0.1870860284474045, 0.8129139715525955]),
            ((10, 10, 0.95), [0.6915028921812371, 1.0]),
            ((81, 263, 0.99), [0.236837358165538, 0.38625832566994095]),
            ((950, 1000, 0.95), [0.9346095120845064, 0.9626646023953394]),
            ((3, 1000, 0.9), [0.0008181753982217664, 0.00773524471848195]),
            ((37000, 100000, 0.95), [0.3670064087178072, 0.37300113304303356]),
        ];
        for ((hits, trials, level), pinned) in pinned {
            for (found, pinned) in ends(hits, trials, level).iter().zip(pinned) {
                assert!((found - pinned).abs() < 1e-10, "{hits} {trials} {level}: {found} {pinned}");
            }
        }
    }

    /// P(no hit) = (1 - p)^n is half of 1 - level at the upper end.
    #[test]
    fn none_and_all_have_the_closed_form() {
        for trials in [1, 7, 100, 100_000] {
            let end = 1.0 - 0.025f64.powf(1.0 / trials as f64);
            let ([none_low, none], [all, all_high]) = (ends(0, trials, 0.95), ends(trials, trials, 0.95));
            assert_eq!([none_low, all_high], [0.0, 1.0]);
            assert!((none - end).abs() < 1e-12 && (1.0 - all - end).abs() < 1e-12, "{trials}: {none} {all}");
        }
    }

    /// Of 4000 samples 200 may miss the share; 4 standard deviations are 55. Drawing at one share and asking for
    /// another must fail.
    #[test]
    fn nineteen_of_twenty_intervals_hold_the_share_and_not_another() {
        let mut random = Random::new(1);
        let intervals: Vec<[f64; 2]> = (0..=30).map(|hits| ends(hits, 30, 0.95)).collect();
        for share in [0.02, 0.1, 0.5, 0.8, 0.97] {
            let mut held = |asked: f64| {
                let mut sample = || (0..30).filter(|_| random.uniform() < share).count();
                (0..4000).map(|_| intervals[sample()]).filter(|[low, high]| *low <= asked && asked <= *high).count()
            };
            let (own, other) = (held(share), held(share + if share < 0.5 { 0.3 } else { -0.3 }));
            assert!(own >= 3745 && other < 3000, "{share}: {own} {other}");
        }
    }

    #[test]
    fn impossible_counts_are_refused() {
        assert!(clopper_pearson(2, 1, 0.95).is_err() && clopper_pearson(0, MOST_TRIALS + 1, 0.95).is_err());
        assert_eq!(clopper_pearson(1, 2, 95.0), Err(StatisticsError::Level(95.0)));
        assert_eq!(clopper_pearson(0, 0, 0.95).unwrap().best(), None);
    }
}
