//! How far the mean over groups of replicates may be off, and where the truth is then in 95 % of cases.

use super::tails::quantile_95;

/// Variance and skewness of an estimate: of the mean over groups of replicates, or of a sum of independent estimates.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct MeanError {
    /// Variance of the estimate.
    pub variance: f64,
    /// Its third central moment.
    third_moment: f64,
    /// What is not known of the variance: the sum over its parts of their square over their degrees of freedom.
    unsure: f64,
}

impl MeanError {
    /// Of a variance that is known, of something normal.
    pub fn known(variance: f64) -> Self {
        Self { variance, ..Self::default() }
    }

    /// Of the mean over groups, by each one's share of the replicates and its deviation from that mean. Nothing is
    /// known from one group alone: its variance counts as 0.
    pub fn of_groups(groups: impl Iterator<Item = (f64, f64)> + Clone) -> Self {
        let count = groups.clone().count() as f64;
        let freedom = count - 1.0;
        if freedom < 1.0 {
            return Self::default();
        }
        let variance = groups.clone().map(|(share, off)| share * off * off).sum::<f64>() / freedom;
        // Fisher's k-statistic of groups of one size (Proc. Lond. Math. Soc. 30, 199, 1929); of two nothing is known.
        let cubes: f64 = groups.map(|(share, off)| share * share * off.powi(3)).sum();
        let third_moment = if freedom > 1.0 { cubes * count / (freedom * (freedom - 1.0)) } else { 0.0 };
        Self { variance, third_moment, unsure: variance * variance / freedom }
    }

    /// That of the sum of two independent estimates.
    pub fn plus(self, other: Self) -> Self {
        Self {
            variance: self.variance + other.variance,
            third_moment: self.third_moment + other.third_moment,
            unsure: self.unsure + other.unsure,
        }
    }

    /// Student's t that holds 95 %: degrees of freedom are joined by Satterthwaite's rule (Biometrics Bulletin 2, 110,
    /// 1946).
    fn quantile(&self) -> f64 {
        quantile_95(if self.unsure > 0.0 { self.variance.powi(2) / self.unsure } else { f64::INFINITY })
    }

    /// Half of the 95 % interval of an estimate that is as often too high as too low.
    pub fn half_width(&self) -> f64 {
        self.quantile() * self.variance.sqrt()
    }

    /// Lower and upper end of the 95 % interval, from the estimate, of what may be skewed, as the light of few paths
    /// is: its mean departs further, and more often, to one side, which Student's t does not know. With T the departure
    /// in standard errors and y the skewness, T + y T^2 / 3 + y^2 T^3 / 27 + y / 6 is nearly of Student's t (Hall, J.
    /// R. Stat. Soc. B 54, 221, 1992); it is a cube, and solved as one. No end is nearer than Student's: of tails that
    /// are heavy on both sides the skewness of 16 values is chance.
    pub fn interval(&self) -> [f64; 2] {
        /// Below this the terms with y are lost in rounding.
        const SYMMETRIC: f64 = 1e-6;
        let (error, quantile) = (self.variance.sqrt(), self.quantile());
        let skewness = if error > 0.0 { self.third_moment / error.powi(3) } else { 0.0 };
        let end = |t: f64| match skewness.abs() > SYMMETRIC {
            true => -error * 3.0 / skewness * ((1.0 + skewness * (t - skewness / 6.0)).cbrt() - 1.0),
            false => -error * t,
        };
        [end(quantile).min(-quantile * error), end(-quantile).max(quantile * error)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::noise::PixelRandom;

    const GROUPS: usize = 16;

    fn of(values: [f64; GROUPS]) -> (f64, MeanError) {
        let share = 1.0 / GROUPS as f64;
        let mean = share * values.iter().sum::<f64>();
        (mean, MeanError::of_groups(values.iter().map(|value| (share, value - mean))))
    }

    /// Means of values at random: what their interval misses, in percent, without and with their skewness.
    fn missed(draw: impl Fn(&mut PixelRandom) -> f64, truth: f64) -> [f64; 2] {
        const MEANS: u32 = 20_000;
        let mut random = PixelRandom::new(17, 0);
        let mut missed = [0.0; 2];
        for _ in 0..MEANS {
            let (mean, error) = of(std::array::from_fn(|_| draw(&mut random)));
            let half = error.half_width();
            for (missed, [low, high]) in missed.iter_mut().zip([[-half, half], error.interval()]) {
                *missed += f64::from(!(mean + low..=mean + high).contains(&truth)) * 100.0 / f64::from(MEANS);
            }
        }
        missed
    }

    #[test]
    fn means_of_skewed_and_of_heavy_tailed_values_are_held_in_95_percent() {
        // Of 200,000 means each in NumPy; three standard deviations of a count are 0.7 %.
        let as_elsewhere = |missed: [f64; 2], expected: [f64; 2]| {
            assert!(missed.iter().zip(expected).all(|(a, b)| (a - b).abs() < 0.7), "{missed:?} {expected:?}");
        };
        as_elsewhere(missed(PixelRandom::normal, 0.0), [5.07, 4.28]);
        as_elsewhere(missed(|random| -random.uniform().ln(), 1.0), [8.71, 4.51]);
        as_elsewhere(missed(|random| random.normal().powi(2), 1.0), [11.62, 4.49]);
        // Student's t of three degrees; by Hall's ends alone it is 7.58.
        let squares = |random: &mut PixelRandom| (0..3).map(|_| random.normal().powi(2)).sum::<f64>();
        as_elsewhere(missed(|random| random.normal() / (squares(random) / 3.0).sqrt(), 0.0), [4.30, 4.00]);
    }

    #[test]
    fn ends_lie_where_rare_bright_paths_would_have_moved_the_mean() {
        let one_bright: [f64; GROUPS] = std::array::from_fn(|k| if k == 3 { 9.0 } else { 1.0 });
        let (_, error) = of(one_bright);
        let [low, high] = error.interval();
        assert!(low == -error.half_width() && high > -1.5 * low, "{low} {high}");
        let (_, mirrored) = of(one_bright.map(|value| -value));
        assert_eq!(mirrored.interval(), [-high, -low]);
        assert_eq!(MeanError::default().interval(), [0.0; 2]);
    }

    #[test]
    fn third_moments_are_those_of_the_mean() {
        // Values of an exponential have a third moment of 2, the mean of 16 one of 2 / 256.
        let mut random = PixelRandom::new(5, 0);
        let third = |random: &mut PixelRandom| of(std::array::from_fn(|_| -random.uniform().ln())).1.third_moment;
        let mean = (0..20_000).map(|_| third(&mut random)).sum::<f64>() / 20_000.0;
        // Its standard error is 1.5 % of it.
        assert!((mean * 128.0 - 1.0).abs() < 0.05, "{}", mean * 128.0);
    }

    #[test]
    fn parts_of_few_degrees_of_freedom_widen_an_interval() {
        let part =
            |variance: f64, freedom: f64| MeanError { variance, third_moment: 0.0, unsure: variance.powi(2) / freedom };
        // Student's t of 15 degrees: 2.1314 (tables).
        assert!((part(4.0, 15.0).half_width() - 2.0 * 2.131_449_5).abs() < 1e-5);
        assert!((MeanError::known(4.0).half_width() - 2.0 * 1.959_964).abs() < 1e-5);
        // Two equal parts: 30 degrees, t = 2.0423.
        let both = part(2.0, 15.0).plus(part(2.0, 15.0));
        assert!((both.half_width() - 2.0 * 2.042_272).abs() < 1e-5);
        assert_eq!(both.interval()[1], both.half_width());
        assert_eq!(MeanError::default().half_width(), 0.0);
    }
}
