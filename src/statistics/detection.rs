//! From which size on an inclusion is detected.

use super::distributions::{normal_quantile, root};
use super::penalised::{Outcomes, Place};
use super::{StatisticsError, check_count, check_finite};
use crate::estimate::Value;

/// Rate at which a size counts as detectable.
const DETECTABLE: f64 = 0.95;

/// Halvings to an end of an interval: to 1e-10 of its distance, where likelihoods round.
const HALVINGS: u32 = 33;

/// Whether something was detected.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Trial {
    /// What the rate depends on, such as a diameter in mm.
    pub covariate: f64,
    /// Whether it was detected.
    pub is_detected: bool,
}

/// Detection rate against a covariate: rate = 1 / (1 + exp(-intercept - slope covariate)).
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct DetectionRate {
    /// Logit of the rate at the covariate 0.
    pub intercept: f64,
    /// Change of the logit a unit of the covariate.
    pub slope: f64,
    /// The covariate at which 95 % are detected, in its unit, with its 95 % interval.
    pub smallest: Value,
}

impl DetectionRate {
    /// The rate by logistic regression with Firth's penalty, which is finite for all trials.
    ///
    /// The interval of `smallest` is that of the penalised profile likelihood (Heinze & Schemper 2002): all covariates
    /// that could have the rate without being told from the best by a likelihood ratio at 95 %. It may reach beyond
    /// what was tried. `smallest` is undefined where all or none were detected, where the rate does not rise with the
    /// covariate or is not told from one that stays the same, and where it lies beyond what was tried.
    ///
    /// The penalty flattens the rate and makes `smallest` too large, on the safe side: for a rate that rises from 5 %
    /// to 95 % over 4 mm, in trials from 0 to 10 mm, by 0.39 mm for 30 trials, 0.15 mm for 60 and 0.05 mm for 200
    /// (medians of 4000 fits).
    ///
    /// # Errors
    /// Fewer than two different covariates; one that is not finite; a span so small that the slope overflows; a fit
    /// that does not converge.
    pub fn of(trials: &[Trial]) -> Result<Self, StatisticsError> {
        check_finite(trials.iter().map(|trial| trial.covariate))?;
        let covariates = || trials.iter().map(|trial| trial.covariate);
        let [low, high] = [covariates().fold(f64::INFINITY, f64::min), covariates().fold(f64::NEG_INFINITY, f64::max)];
        let given = usize::from(low <= high) + usize::from(low < high);
        check_count("different covariates", given, 2)?;
        let (middle, half) = (0.5 * low + 0.5 * high, 0.5 * high - 0.5 * low);
        let outcomes = Outcomes(trials.iter().map(|t| ((t.covariate - middle) / half, t.is_detected)).collect());
        let best = outcomes.summit().ok_or(StatisticsError::NoFit)?;
        let slope = best.beta[1] / half;
        let intercept = best.beta[0] - slope * middle;
        check_finite([intercept, slope]).map_err(|_| StatisticsError::Overflow)?;
        let detected = trials.iter().filter(|trial| trial.is_detected).count();
        let smallest = match told(detected, trials.len()).and_then(|()| smallest(&outcomes, &best)) {
            Ok([value, low, high]) => {
                let [value, low, high] = [value, low, high].map(|z| middle + half * z);
                Value::known(value, low, high)
            }
            Err(reason) => Value::undefined(reason),
        };
        Ok(Self { intercept, slope, smallest })
    }

    /// The rate at a covariate, 0 to 1.
    #[must_use]
    pub fn rate(&self, covariate: f64) -> f64 {
        1.0 / (1.0 + (-self.intercept - self.slope * covariate).exp())
    }
}

/// Some were detected, and some not.
fn told(detected: usize, trials: usize) -> Result<(), String> {
    match detected {
        0 => Err(format!("none of {trials} were detected: try larger ones")),
        all if all == trials => Err(format!("all of {trials} were detected: try smaller ones")),
        _ => Ok(()),
    }
}

/// The scaled covariate, -1 to 1, at which 95 % are detected, and its interval, or why there is none.
fn smallest(outcomes: &Outcomes, best: &Place) -> Result<[f64; 3], String> {
    let logit = (DETECTABLE / (1.0 - DETECTABLE)).ln();
    let [intercept, slope] = best.beta;
    // A likelihood ratio at 95 %: half of the chi-square quantile of one degree.
    let drop = 0.5 * normal_quantile(0.975).powi(2);
    let level = outcomes.climb([intercept, 0.0], Some([1.0, 0.0]));
    if !(slope > 0.0 && level.is_some_and(|level| level.height < best.height - drop)) {
        return Err("the rate is not seen to rise with the covariate: more trials are needed".into());
    }
    let value = (logit - intercept) / slope;
    if value.abs() > 1.0 {
        let (end, other) = if value > 0.0 { ("largest", "larger") } else { ("smallest", "smaller") };
        return Err(format!("95 % are detected beyond the {end} that was tried: try {other} ones"));
    }
    let drops = |z: f64| outcomes.summit_through(z, logit).map_or(f64::NAN, |at| best.height - at.height - drop);
    let end = |side: f64| {
        let outside = |far: f64| drops(value + side * far);
        let far = (0..40).map(|k| 0.01 * f64::from(k).exp2()).find(|far| outside(*far) > 0.0)?;
        let away = root([0.0, far], HALVINGS, outside);
        (outside(away).abs() < 1e-6).then_some(value + side * away)
    };
    let ends = end(-1.0).zip(end(1.0));
    ends.map(|(low, high)| [value, low, high]).ok_or("no ends of the interval are found: more trials are needed".into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::{numbers, random::Random};

    const RISING: [usize; 8] = [0, 0, 1, 2, 4, 5, 6, 6];
    const SEPARATED: [usize; 8] = [0, 0, 0, 0, 4, 4, 4, 4];

    /// `repeats` trials at each of 1 to 8 units, of which the given numbers are detected.
    fn rate(hits: [usize; 8], repeats: usize, unit: f64) -> DetectionRate {
        let trial = |i: usize, k: usize| Trial { covariate: unit * (i + 1) as f64, is_detected: k < hits[i] };
        let trials: Vec<Trial> = (0..8).flat_map(|i| (0..repeats).map(move |k| trial(i, k))).collect();
        DetectionRate::of(&trials).unwrap()
    }

    /// Trials at the given covariates, of which those of `from` and more are detected.
    fn separated(covariates: &[u32], from: u32) -> DetectionRate {
        let trial = |x: &u32| Trial { covariate: f64::from(*x), is_detected: *x >= from };
        DetectionRate::of(&covariates.iter().map(trial).collect::<Vec<_>>()).unwrap()
    }

    /// mpmath 1.4.1 at 40 digits: `findroot` of the derivatives of the penalised likelihood, and of its profile less
    /// the drop. firthmodels 0.8.2, `FirthLogisticRegression().fit(x, y)`, gives the same first two lines to 2e-8. Its
    /// profile interval of the intercept of x less either end, `conf_int(method='pl')`, ends at the logit of 95 % to
    /// 1e-11. The profile of the third has two hills.
    #[test]
    fn fits_and_intervals_are_those_of_mpmath() {
        let two_hills = separated(&[0, 2, 2, 3, 8, 10, 30, 40, 60], 10);
        let pinned = [
            [-5.587_946_441_021, 1.241_765_875_782, 6.871_170_795_228, 5.695_996_371_047, 8.930_949_917_541],
            [-18.181_924_748_325, 4.040_427_721_850, 5.228_744_376_058, 4.540_350_949_447, 7.100_218_993_071],
            [-1.835_996_198_619, 0.107_063_366_035, 44.650_521_974_300, 10.042_790_603_442, 318.367_462_609_016],
        ];
        for (found, pinned) in [rate(RISING, 6, 1.0), rate(SEPARATED, 4, 1.0), two_hills].iter().zip(pinned) {
            let found = [found.intercept, found.slope].into_iter().chain(numbers(&found.smallest));
            for (found, pinned) in found.zip(pinned) {
                assert!((found / pinned - 1.0).abs() < 1e-9, "{found} {pinned}");
            }
        }
    }

    /// Also by mpmath. From a rate of one half everywhere a climb ends at a slope of 0.034, 0.41 lower; and it does not
    /// end on three trials where steps are not those of augmented data.
    #[test]
    fn the_highest_hill_is_found() {
        let found = separated(&[0, 0, 0, 0, 0, 0, 1, 2, 9, 28, 65, 126], 1);
        assert!((found.intercept + 2.315_317_298).abs() < 1e-8 && (found.slope - 2.829_488_423).abs() < 1e-8);
        let three = [(835.0, false), (164.0, true), (141.0, true)];
        let falling =
            DetectionRate::of(&three.map(|(covariate, is_detected)| Trial { covariate, is_detected })).unwrap();
        assert!((falling.slope + 0.003_966_183).abs() < 1e-8, "{falling:?}");
    }

    #[test]
    fn a_worse_detector_needs_larger_ones_and_units_do_not_matter() {
        let [better, metres] = [1.0, 1e-3].map(|unit| rate(RISING, 6, unit));
        let [value, low, high] = numbers(&better.smallest);
        let worse = numbers(&rate([0, 0, 0, 1, 3, 4, 5, 6], 6, 1.0).smallest);
        assert!(worse.iter().zip([value, low, high]).all(|(worse, better)| *worse > better));
        let rescaled = numbers(&metres.smallest).map(|m| 1e3 * m);
        assert!(rescaled.iter().zip([value, low, high]).all(|(a, b)| (a / b - 1.0).abs() < 1e-9));
        assert!((better.rate(value) - 0.95).abs() < 1e-12 && (metres.rate(1e-3 * value) - 0.95).abs() < 1e-9);
    }

    /// 40 trials from 0 to 10, a rate of one half at 4, of 95 % ln(19) / 1.5 above. Of 60 intervals 57 hold that,
    /// with 4 standard deviations of 7; the place of one half they must not hold.
    #[test]
    fn nineteen_of_twenty_intervals_hold_the_smallest_detectable() {
        let mut random = Random::new(17);
        let mut held = [0; 2];
        for _ in 0..60 {
            let mut trial = |covariate: f64| Trial {
                covariate,
                is_detected: random.uniform() < 1.0 / (1.0 + (1.5 * (4.0 - covariate)).exp()),
            };
            let trials: Vec<Trial> = (0..40).map(|i| trial(f64::from(i) / 4.0)).collect();
            let [_, low, high] = numbers(&DetectionRate::of(&trials).unwrap().smallest);
            for (held, x) in held.iter_mut().zip([4.0 + 19f64.ln() / 1.5, 4.0]) {
                *held += usize::from(low <= x && x <= high);
            }
        }
        assert!(held[0] >= 50 && held[1] < 20, "{held:?}");
    }

    #[test]
    fn what_trials_cannot_tell_has_a_reason() {
        let told = [
            ([2; 8], 2, "all of 16"),
            ([0; 8], 2, "none of 16"),
            ([4, 3, 3, 2, 2, 1, 1, 0], 4, "not seen to rise"),
            ([1, 0, 1, 1, 1, 0, 1, 1], 2, "not seen to rise"),
            ([0, 1, 1, 2, 2, 3, 3, 4], 4, "beyond the largest"),
            ([58, 60, 60, 60, 60, 60, 60, 60], 60, "beyond the smallest"),
        ];
        for (hits, repeats, why) in told {
            let Value::Undefined { reason } = rate(hits, repeats, 1.0).smallest else { panic!("{why}") };
            assert!(reason.contains(why), "{reason}");
        }
        let one = DetectionRate::of(&[Trial { covariate: 1.0, is_detected: true }; 5]);
        assert!(matches!(one, Err(StatisticsError::TooFew { given: 1, needed: 2, .. })));
        assert!(DetectionRate::of(&[]).is_err());
    }
}
