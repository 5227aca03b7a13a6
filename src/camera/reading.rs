//! What a pixel reads of an expected signal: mean, spread and slope of grey values, in closed form.
//!
//! Before rounding a pixel's grey level is taken as normal: photons are many where they matter, read noise is normal,
//! and so is the error of a mean of many paths. Rounding and the two ends of the scale are then exact or, where the
//! noise dithers the rounding, add a variance of 1/12 (Sheppard).

use statrs::function::erf::erfc;

/// Below this standard deviation in grey levels, rounding is summed level by level: what Sheppard's 1/12 neglects is of
/// the order exp(-2 pi^2 sd^2), 4e-9 here.
const DITHERED_FROM: f64 = 1.0;
/// Standard deviations beyond which a normal variable is not followed: a probability of 1e-9.
const REACH: f64 = 6.0;

/// Grey level of a pixel before rounding and clipping, normal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Signal {
    /// Mean, grey levels.
    pub mean: f64,
    /// Standard deviation, grey levels.
    pub sd: f64,
}

/// What is made of a signal: a mean, a variance, and how fast the mean follows that of the signal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Response {
    /// Mean.
    pub mean: f64,
    /// Variance.
    pub variance: f64,
    /// Derivative of the mean by the signal's.
    pub slope: f64,
}

/// Density of the standard normal distribution.
pub fn normal_density(z: f64) -> f64 {
    (-0.5 * z * z).exp() / std::f64::consts::TAU.sqrt()
}

/// Probability that a standard normal variable is below `z`.
pub fn normal_below(z: f64) -> f64 {
    0.5 * erfc(-z / std::f64::consts::SQRT_2)
}

impl Signal {
    /// Whether it exceeds a level: 0 or 1 on each draw.
    pub fn exceeds(&self, level: f64) -> Response {
        if self.sd <= 0.0 {
            return Response { mean: f64::from(self.mean > level), variance: 0.0, slope: 0.0 };
        }
        let z = (self.mean - level) / self.sd;
        let mean = normal_below(z);
        Response { mean, variance: mean * normal_below(-z), slope: normal_density(z) / self.sd }
    }

    /// The grey value read, rounded and kept between 0 and the top level.
    pub fn read(&self, top: f64) -> Response {
        let Self { mean, sd } = *self;
        if sd < DITHERED_FROM {
            return self.read_by_levels(top);
        }
        if mean > REACH * sd && mean < top - REACH * sd {
            return Response { mean, variance: sd * sd + 1.0 / 12.0, slope: 1.0 };
        }
        // Moments of a normal variable about its mean, all below `low` put there and all above `high` there.
        let (low, high) = (-mean, top - mean);
        let (a, b) = (low / sd, high / sd);
        let (below, above) = (normal_below(a), normal_below(-b));
        let inside = (1.0 - below - above).max(0.0);
        let [at_a, at_b] = [a, b].map(normal_density);
        let shift = low * below + high * above + sd * (at_a - at_b);
        let square = low * low * below + high * high * above + sd * sd * inside + sd * (low * at_a - high * at_b);
        Response { mean: mean + shift, variance: (square - shift * shift).max(0.0) + inside / 12.0, slope: inside }
    }

    /// The same as a sum over the levels within reach.
    fn read_by_levels(&self, top: f64) -> Response {
        let first = (self.mean - REACH * self.sd).round().clamp(0.0, top);
        let last = (self.mean + REACH * self.sd).round().clamp(0.0, top);
        let (mut shift, mut square, mut slope) = (0.0, 0.0, 0.0);
        // Above the level halfway to the next one the pixel reads one more.
        for step in 0..(last - first) as u32 {
            let step = f64::from(step);
            let passed = self.exceeds(first + step + 0.5);
            shift += passed.mean;
            square += (2.0 * step + 1.0) * passed.mean;
            slope += passed.slope;
        }
        Response { mean: first + shift, variance: (square - shift * shift).max(0.0), slope }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::noise::PixelRandom;

    fn drawn(signal: Signal, top: f64) -> [f64; 2] {
        let draws = 40_000;
        let read = |pixel| (signal.mean + signal.sd * PixelRandom::new(3, pixel).normal()).round().clamp(0.0, top);
        let mean = (0..draws).map(read).sum::<f64>() / f64::from(draws);
        let variance = (0..draws).map(|pixel| (read(pixel) - mean).powi(2)).sum::<f64>() / f64::from(draws);
        [mean, variance]
    }

    #[test]
    fn mean_and_variance_are_those_of_drawn_pixels() {
        for (mean, sd) in [(0.0, 0.15), (0.3, 0.3), (5.4, 0.3), (79.0, 1.16), (1.0, 2.0), (254.0, 2.5), (258.0, 2.0)] {
            let signal = Signal { mean, sd };
            let Response { mean, variance, .. } = signal.read(255.0);
            let [drawn_mean, drawn_variance] = drawn(signal, 255.0);
            // Standard errors of 40,000 draws: sd/200, and at most a tenth of a variance of kurtosis 400 (rare steps).
            assert!(
                (mean - drawn_mean).abs() < 4.0 * variance.sqrt() / 200.0 + 1e-9,
                "{signal:?}: {mean} {drawn_mean}"
            );
            let tolerance = if variance < 0.01 { 0.4 } else { 4.0 * (2.0f64 / 40_000.0).sqrt() * 2.0 };
            assert!((variance / drawn_variance - 1.0).abs() < tolerance, "{signal:?}: {variance} {drawn_variance}");
        }
    }

    #[test]
    fn slopes_are_derivatives_and_both_ways_agree_where_they_meet() {
        for mean in [-0.4, 0.2, 3.3, 100.5, 254.9, 255.5] {
            for sd in [0.2, 0.9, 1.1, 3.0] {
                let at = |mean: f64| Signal { mean, sd }.read(255.0);
                let slope = (at(mean + 1e-4).mean - at(mean - 1e-4).mean) / 2e-4;
                // Derivative by central differences: third derivatives are below 100/sd^3 ... times 1e-8.
                assert!((at(mean).slope - slope).abs() < 1e-4, "{mean} {sd}");
            }
        }
        for mean in [3.0, 50.3, 100.5] {
            let signal = Signal { mean, sd: DITHERED_FROM };
            let (a, b) = (signal.read(255.0), signal.read_by_levels(255.0));
            // Beyond 6 sd nothing is summed: 6^2 1e-9; the lower end of the scale is 3 sd away from the first.
            let tolerance = if mean < 6.0 { 2e-3 } else { 1e-6 };
            assert!((a.mean - b.mean).abs() < tolerance && (a.variance - b.variance).abs() < tolerance, "{a:?} {b:?}");
        }
    }
}
