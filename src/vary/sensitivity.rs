//! Which variables matter: Morris' elementary effects and Sobol's indices, from the figures of a complete design.
//!
//! Morris, Technometrics 33(2), 1991, with the mean of absolute effects of Campolongo et al., Environmental Modelling &
//! Software 22(10), 2007. First indices by Saltelli et al., Computer Physics Communications 181(2), 2010, total ones by
//! Jansen, Computer Physics Communications 117, 1999. Intervals of effects are those of a mean of independent
//! trajectories, of indices by resampling of base points: too narrow by far where these are few, so that few have none.
//!
//! Figures have noise. With e an effect and s the standard deviation of its noise, E |e + noise| lies between |e| and
//! |e| + s sqrt(2 / pi), and above the absolute mean. In the mean of squares behind a total index noise of variance v
//! adds up to 2 v, in the product behind a first one up to v either way, and v in the variance itself. What the figures
//! of a trajectory or of a base point have of it in common cancels, how much is not known: intervals allow for none and
//! for all. Indices themselves are less the noise, all of it common where a base point's random numbers are.

use crate::camera::noise::PixelRandom;
use crate::film::MeanError;
use serde::Serialize;
use std::f64::consts::FRAC_2_PI;

/// Resamples behind an interval.
const RESAMPLES: u32 = 1000;

/// A figure with its 95 % interval.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Interval {
    /// The figure.
    pub value: f64,
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

/// Effects of one variable over half of its range, in the unit of the figure.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Effects {
    /// Mean of the absolute effects: how much it matters.
    pub mean_absolute: Interval,
    /// Mean of the effects.
    pub mean: Interval,
    /// Standard deviation of the effects: how much it bends, or depends on other variables.
    pub spread: f64,
}

/// Shares of the variance of a figure.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Indices {
    /// What this variable explains alone.
    pub first: Interval,
    /// What is not explained without it.
    pub total: Interval,
}

/// Why there are none.
const CONSTANT: &str = "the figure is the same at all points";
/// Fewest trajectories and base points whose intervals hold.
pub(super) const TRAJECTORIES: u32 = 6;
pub(super) const BASE_POINTS: u32 = 64;
const NOISY: &str = "the figures' own errors are as large as all that varies: trace them to a smaller one";
const FEW: &str = "so few trajectories or base points do not say how far off they are: at least 6, or 64";

/// The 95 % interval of a statistic of `count` items, by resampling them.
fn interval(count: usize, seed: u32, statistic: impl Fn(&[usize]) -> f64) -> Interval {
    let all: Vec<usize> = (0..count).collect();
    let value = statistic(&all);
    let mut found: Vec<f64> = (0..RESAMPLES)
        .map(|k| {
            let mut random = PixelRandom::new(seed, k);
            let drawn = |_| ((random.uniform() * count as f64) as usize).min(count.saturating_sub(1));
            statistic(&(0..count).map(drawn).collect::<Vec<_>>())
        })
        .collect();
    found.sort_by(f64::total_cmp);
    let at = |share: f64| found.get((share * f64::from(RESAMPLES)) as usize).copied().unwrap_or(value);
    // No minus before a 0.
    let [value, low, high] = [value, at(0.025), at(0.975)].map(|figure| figure + 0.0);
    Interval { value, low, high }
}

fn mean(values: impl Iterator<Item = f64> + Clone) -> f64 {
    values.clone().sum::<f64>() / values.count().max(1) as f64
}

/// Effects of each variable from the figures of a Morris design, row after row, and the standard deviations of their
/// noise. Effects of variables that are `ordered` are over half of their range, or of their values; those of words are
/// changes as they come. Trajectories have no noise in common.
///
/// # Errors
/// Figures that are not those of a complete design.
pub fn effects(ordered: &[bool], units: &[Vec<f64>], figures: &[f64], noise: &[f64]) -> Result<Vec<Effects>, String> {
    let (variables, length) = (ordered.len(), ordered.len() + 1);
    if [units.len(), noise.len()] != [figures.len(); 2] || figures.is_empty() || !figures.len().is_multiple_of(length) {
        return Err(format!("{} figures are not those of a complete design of {}", figures.len(), units.len()));
    }
    if figures.len() < TRAJECTORIES as usize * length {
        return Err(FEW.into());
    }
    // Of each trajectory one effect a variable, with its noise: the change of the figure as the variable goes up.
    let of_trajectory = |first: usize| {
        let mut effects = vec![[0.0; 2]; variables];
        for row in first + 1..first + length {
            for (variable, effect) in effects.iter_mut().enumerate() {
                let step = units[row][variable] - units[row - 1][variable];
                if step != 0.0 {
                    // Lists of an odd number of values step by a little less than half, or more.
                    let scale = if ordered[variable] { 0.5 / step } else { step.signum() };
                    let change = figures[row] - figures[row - 1];
                    *effect = [change * scale, noise[row].hypot(noise[row - 1]) * scale.abs()];
                }
            }
        }
        effects
    };
    let effects: Vec<Vec<[f64; 2]>> = (0..figures.len()).step_by(length).map(of_trajectory).collect();
    let of = |variable: usize| {
        let mean_of = |of: fn(f64) -> f64| {
            let values = || effects.iter().map(|one| of(one[variable][0]));
            let (value, share) = (mean(values()), 1.0 / effects.len() as f64);
            let [low, high] = MeanError::of_groups(values().map(|effect| (share, effect - value))).interval();
            // No minus before a 0.
            let [value, low, high] = [value, value + low, value + high].map(|figure| figure + 0.0);
            Interval { value, low, high }
        };
        let (signed, absolute) = (mean_of(|effect| effect), mean_of(f64::abs));
        let squares: f64 = effects.iter().map(|one| (one[variable][0] - signed.value).powi(2)).sum();
        let noise = mean(effects.iter().map(|one| one[variable][1]));
        let least = (absolute.low - FRAC_2_PI.sqrt() * noise).max(signed.low).max(-signed.high).max(0.0);
        Effects {
            mean_absolute: Interval { low: least.min(absolute.low.max(0.0)), ..absolute },
            mean: signed,
            spread: (squares / (effects.len().max(2) - 1) as f64).sqrt(),
        }
    };
    Ok((0..variables).map(of).collect())
}

/// Indices of each of `variables` variables from the figures of a Saltelli design, row after row, and the standard
/// deviations of their noise. `common` tells that the points of a block share random numbers; no two blocks do.
///
/// # Errors
/// Figures that are not those of a complete design, all the same, or noise alone.
pub fn indices(variables: usize, figures: &[f64], noise: &[f64], common: bool) -> Result<Vec<Indices>, String> {
    let length = variables + 2;
    if noise.len() != figures.len() || figures.is_empty() || !figures.len().is_multiple_of(length) {
        return Err(format!("{} figures are not those of a complete design", figures.len()));
    }
    if figures.len() < BASE_POINTS as usize * length {
        return Err(FEW.into());
    }
    let blocks: Vec<&[f64]> = figures.chunks(length).collect();
    let variance = |drawn: &[usize]| {
        let both = || drawn.iter().flat_map(|&k| [blocks[k][0], blocks[k][length - 1]]);
        let average = mean(both());
        mean(both().map(|figure| (figure - average).powi(2)))
    };
    let all: Vec<usize> = (0..blocks.len()).collect();
    let largest = figures.iter().fold(0.0, |largest: f64, figure| largest.max(figure.abs()));
    let whole = variance(&all);
    if whole.sqrt() <= 1e-12 * largest {
        return Err(CONSTANT.into());
    }
    let noise = mean(noise.chunks(length).flat_map(|block| [block[0].powi(2), block[length - 1].powi(2)])) / whole;
    if noise >= 1.0 {
        return Err(NOISY.into());
    }
    let behind_noise = |one: Interval, less: f64, up: f64| Interval {
        value: (one.value - less) / (1.0 - noise),
        low: one.low.min((one.low - noise) / (1.0 - noise)),
        high: one.high.max((one.high + up) / (1.0 - noise)),
    };
    let of = |variable: usize| {
        let seed = variable as u32;
        // Against the mean, so that a large constant does not drown what varies.
        let center = mean(blocks.iter().map(|block| block[0]));
        let first = |drawn: &[usize]| {
            let product = |&k: &usize| {
                let block = blocks[k];
                (block[length - 1] - center) * (block[variable + 1] - block[0])
            };
            mean(drawn.iter().map(product)) / variance(drawn)
        };
        let total = |drawn: &[usize]| {
            let square = |&k: &usize| (blocks[k][0] - blocks[k][variable + 1]).powi(2);
            mean(drawn.iter().map(square)) / (2.0 * variance(drawn))
        };
        let (first, total) = (interval(blocks.len(), seed, first), interval(blocks.len(), seed, total));
        let total = behind_noise(total, if common { 0.0 } else { noise }, 0.0);
        Indices {
            first: behind_noise(first, 0.0, noise),
            total: Interval { value: total.value.max(0.0), low: total.low.max(0.0), ..total },
        }
    };
    Ok((0..variables).map(of).collect())
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::vary::{Design, Keys, Plan, Scalar, Vary};
    use std::f64::consts::PI;

    fn plan(design: &Design, variables: usize, range: [f64; 2]) -> Plan {
        let key = |k: usize| Some(Keys::One(format!("x.v{k}")));
        let vary: Vec<_> =
            (0..variables).map(|k| Vary { key: key(k), uniform: Some(range), ..Vary::default() }).collect();
        Plan::new(&vary, &[], design, None).unwrap()
    }

    fn values(plan: &Plan) -> Vec<Vec<f64>> {
        let point = |row| plan.point(row).unwrap().values.iter().map(|v| v.number().unwrap()).collect();
        (0..plan.count()).map(point).collect()
    }

    fn points(design: &Design, variables: usize, range: [f64; 2]) -> Vec<Vec<f64>> {
        values(&plan(design, variables, range))
    }

    /// Points of a Morris design of variables from 1 to 5, and where they are in the unit cube.
    fn trajectories(trajectories: u32, seed: u32, variables: usize) -> (Vec<Vec<f64>>, Vec<Vec<f64>>) {
        let plan = plan(&Design::Morris { trajectories, seed }, variables, [1.0, 5.0]);
        (values(&plan), (0..plan.count()).map(|row| plan.unit(row)).collect())
    }

    /// Ishigami and Homma's function with a = 7, b = 0.1.
    fn ishigami(x: &[f64]) -> f64 {
        x[0].sin() + 7.0 * x[1].sin().powi(2) + 0.1 * x[2].powi(4) * x[0].sin()
    }

    /// Its indices: V = a^2/8 + b pi^4/5 + b^2 pi^8/18 + 1/2, V1 = (1 + b pi^4/5)^2 / 2, V2 = a^2/8,
    /// V13 = b^2 pi^8 (1/18 - 1/50).
    fn exact() -> [[f64; 2]; 3] {
        let (a, b) = (7.0f64, 0.1f64);
        let v = a * a / 8.0 + b * PI.powi(4) / 5.0 + b * b * PI.powi(8) / 18.0 + 0.5;
        let v1 = 0.5 * (1.0 + b * PI.powi(4) / 5.0).powi(2);
        let (v2, v13) = (a * a / 8.0, b * b * PI.powi(8) * (1.0 / 18.0 - 1.0 / 50.0));
        [[v1 / v, (v1 + v13) / v], [v2 / v, v2 / v], [0.0, v13 / v]]
    }

    fn found(seed: u32, points_: u32, constant: f64) -> Vec<Indices> {
        let points = points(&Design::Saltelli { points: points_, seed }, 3, [-PI, PI]);
        let figures: Vec<f64> = points.iter().map(|x| constant + ishigami(x)).collect();
        indices(3, &figures, &vec![0.0; figures.len()], true).unwrap()
    }

    #[test]
    fn few_trajectories_or_base_points_have_no_interval() {
        let figures: Vec<f64> = (0..192).map(f64::from).collect();
        assert_eq!(indices(1, &figures[..189], &[0.0; 189], true).unwrap_err(), FEW);
        assert!(indices(1, &figures, &[0.0; 192], true).is_ok());
        let units: Vec<_> = (0..12).map(|k| vec![0.5 * f64::from(k % 2)]).collect();
        assert_eq!(effects(&[true], &units[..10], &figures[..10], &[0.0; 10]).unwrap_err(), FEW);
        assert!(effects(&[true], &units, &figures[..12], &[0.0; 12]).is_ok());
    }

    /// Of x0 x1 the effect of x0 over half of its range, 2, is 2 x1: 6 on average, by levels from 1 to 5.
    #[test]
    fn intervals_of_effects_hold_them() {
        for count in [6, 12] {
            let held = (0..400).filter(|&seed| {
                let (points, units) = trajectories(count, seed, 2);
                let figures: Vec<f64> = points.iter().map(|x| x[0] * x[1]).collect();
                let found = effects(&[true; 2], &units, &figures, &vec![0.0; points.len()]).unwrap()[0];
                [found.mean, found.mean_absolute].iter().all(|interval| (interval.low..=interval.high).contains(&6.0))
            });
            // 380 and three standard deviations; resampling holds means of 4 and of 8 such values in 80 and 90 of 100.
            let held = held.count();
            assert!(held >= 367, "{count}: {held} of 400");
        }
    }

    /// Values with normal noise of a standard deviation; points of a block of so many have a share of it in common.
    fn noisy(values: impl Iterator<Item = f64>, deviation: f64, seed: u32, block: usize, common: f64) -> Vec<f64> {
        let mut own = PixelRandom::new(seed, 1);
        let noise_of = |(row, value): (usize, f64)| {
            let shared = PixelRandom::new(seed, 2 + (row / block) as u32).normal();
            value + deviation * (common.sqrt() * shared + (1.0 - common).sqrt() * own.normal())
        };
        values.enumerate().map(noise_of).collect()
    }

    /// The function x0 + 0 x1 + 0.3 x2 (x0 - 3): of x1 there is nothing to find, of x2 effects of either sign.
    #[test]
    fn effects_hold_what_there_is_behind_noise() {
        const DEVIATION: f64 = 0.5;
        let of = |x: &Vec<f64>| x[0] + 0.3 * x[2] * (x[0] - 3.0);
        // Over half of a range of 4: of x2 at the levels 1.5, 2.5, 3.5 and 4.5 of x0.
        let truth = [0.0, 2.0 * 0.3 * (1.5 + 0.5) / 2.0];
        for common in [0.0, 0.8] {
            let (mut held, mut without) = ([0; 2], 0);
            for seed in 0..400 {
                let (points, units) = trajectories(8, seed, 3);
                let figures = noisy(points.iter().map(of), DEVIATION, seed, 4, common);
                let found = |noise| effects(&[true; 3], &units, &figures, &vec![noise; points.len()]).unwrap();
                let holds = |one: &Effects, truth| (one.mean_absolute.low..=one.mean_absolute.high).contains(&truth);
                let told = found(DEVIATION);
                held[0] += u32::from(holds(&told[1], truth[0]));
                held[1] += u32::from(holds(&told[2], truth[1]));
                without += u32::from(holds(&found(0.0)[1], truth[0]));
            }
            assert!(held.iter().all(|&held| held >= 367), "{common}: {held:?} of 400");
            assert!(without < 300, "noise that is not told: {without} of 400 hold");
        }
    }

    #[test]
    fn indices_hold_what_there_is_behind_noise() {
        const DEVIATION: f64 = 0.3;
        const TRUTH: [f64; 4] = [1.0, 1.0, 0.0, 0.0];
        for common in [0.0, 0.8] {
            let (mut held, mut means, mut without) = ([0; 4], [0.0; 4], 0);
            for seed in 0..100 {
                let points = points(&Design::Saltelli { points: 64, seed }, 2, [-3.0f64.sqrt(), 3.0f64.sqrt()]);
                let figures = noisy(points.iter().map(|x| x[0]), DEVIATION, seed, 4, common);
                let found = |noise| indices(2, &figures, &vec![noise; points.len()], common > 0.0).unwrap();
                let told = found(DEVIATION);
                let of = |one: &Indices| [one.first, one.total];
                for (k, (one, truth)) in told.iter().flat_map(of).zip(TRUTH).enumerate() {
                    held[k] += u32::from((one.low..=one.high).contains(&truth));
                    means[k] += one.value / 100.0;
                }
                without += u32::from(found(0.0)[1].total.low <= 0.0);
            }
            assert!(held.iter().all(|&held| held >= 88), "{common}: {held:?} of 100");
            // Noise is a twelfth of the variance.
            assert!(means.iter().zip(TRUTH).all(|(mean, truth)| (mean - truth).abs() < 0.04), "{common}: {means:?}");
            assert_eq!(without, 0, "noise that is not told");
        }
        let noise = noisy((0..256).map(|_| 0.0), 1.0, 1, 4, 0.0);
        assert_eq!(indices(2, &noise, &[1.3; 256], true).unwrap_err(), NOISY);
    }

    #[test]
    fn ishigamis_indices_are_found() {
        for constant in [0.0, 1e6] {
            for (found, [first, total]) in found(1, 4096, constant).iter().zip(exact()) {
                assert!((found.first.value - first).abs() < 0.02, "{found:?} {first}");
                assert!((found.total.value - total).abs() < 0.02, "{found:?} {total}");
            }
        }
    }

    #[test]
    fn intervals_of_indices_hold_them() {
        // 6 indices of 100 scramblings each, of the least that is allowed; 95 and three standard deviations.
        let mut held = [0; 6];
        for seed in 0..100 {
            for (k, (found, exact)) in found(seed, BASE_POINTS, 0.0).iter().zip(exact()).enumerate() {
                for (j, (interval, exact)) in [found.first, found.total].into_iter().zip(exact).enumerate() {
                    held[2 * k + j] += u32::from((interval.low..=interval.high).contains(&exact));
                }
            }
        }
        assert!(held.iter().all(|&held| held >= 88), "{held:?} of 100");
    }

    #[test]
    fn a_column_that_is_not_swapped_shows() {
        let points = points(&Design::Saltelli { points: 1024, seed: 1 }, 3, [-PI, PI]);
        let mut figures: Vec<f64> = points.iter().map(|x| ishigami(x)).collect();
        // The block that swaps the second variable computed with the first one's.
        figures.chunks_mut(5).for_each(|block| block[2] = block[1]);
        let [_, [first, _], _] = exact();
        let found = indices(3, &figures, &vec![0.0; figures.len()], true).unwrap()[1];
        assert!(found.first.high < first - 0.05 || found.first.low > first + 0.05, "{found:?}");
    }

    #[test]
    fn effects_of_a_linear_function_are_its_slopes() {
        let slopes = [3.0, -2.0, 0.0, 0.5];
        let (points, units) = trajectories(12, 2, 4);
        let figures: Vec<f64> =
            points.iter().map(|x| 7.0 + x.iter().zip(slopes).map(|(x, a)| a * x).sum::<f64>()).collect();
        // Over half of the range: 2.
        for (found, slope) in effects(&[true; 4], &units, &figures, &[0.0; 60]).unwrap().iter().zip(slopes) {
            assert!((found.mean.value - 2.0 * slope).abs() < 1e-12 && found.spread < 1e-12, "{found:?}");
            assert!((found.mean_absolute.value - 2.0 * slope.abs()).abs() < 1e-12);
            assert!((found.mean.high - found.mean.low).abs() < 1e-12);
        }
        // One that bends has a spread.
        let bent: Vec<f64> = points.iter().map(|x| x[0] * x[1]).collect();
        assert!(effects(&[true; 4], &units, &bent, &[0.0; 60]).unwrap()[0].spread > 0.5);
    }

    /// Values of a list step by half of them, or by nearly half: effects are those over half of the range all the same.
    #[test]
    fn effects_of_lists_are_over_half_of_their_range() {
        for count in [2, 3, 4, 5, 7] {
            let list = (0..count).map(|k| Scalar::Number(f64::from(k))).collect();
            let vary = Vary { key: Some(Keys::One("x.v".into())), values: Some(list), ..Vary::default() };
            let plan = Plan::new(&[vary], &[], &Design::Morris { trajectories: 12, seed: 5 }, None).unwrap();
            let units: Vec<_> = (0..plan.count()).map(|row| plan.unit(row)).collect();
            let figures: Vec<f64> = values(&plan).iter().map(|x| 3.0 * x[0]).collect();
            let found = |is_ordered| effects(&[is_ordered], &units, &figures, &vec![0.1; units.len()]).unwrap()[0];
            let (half, as_it_comes) = (found(plan.is_ordered(0)), found(false));
            let slope = 3.0 * 0.5 * f64::from(count);
            assert!((half.mean.value - slope).abs() < 1e-12 && half.spread < 1e-12, "{count}: {half:?}");
            // An odd number steps by less or more.
            assert_eq!(as_it_comes.spread > 0.1, count % 2 == 1, "{count}: {as_it_comes:?}");
        }
    }

    #[test]
    fn what_is_not_whole_or_does_not_vary_has_no_indices() {
        assert!(indices(3, &[1.0; 9], &[0.0; 9], true).unwrap_err().contains("complete design"));
        assert!(indices(3, &[], &[], true).is_err());
        assert_eq!(indices(3, &[2.0; 320], &[0.0; 320], true).unwrap_err(), CONSTANT);
        assert!(
            effects(&[true; 2], &[vec![0.0; 2], vec![0.0; 2]], &[1.0, 2.0], &[0.0; 2])
                .unwrap_err()
                .contains("complete design")
        );
    }
}
