//! Height fields that are round about an axis.

use super::Relief;

/// Displacement of one interface: a cubic spline over the distance to an axis.
///
/// The spline interpolates samples at equal distances, is level on the axis, and ends with zero second derivative.
#[derive(Debug, Clone, PartialEq)]
pub struct Profile {
    /// Where the axis is, mm.
    pub center_mm: [f64; 2],
    /// Cells per mm.
    pub per_mm: f64,
    /// Coefficients of each cell's cubic, lowest power first, over 0 to 1 from the cell's inner end to its outer one;
    /// mm.
    pub cells: Vec<[f64; 4]>,
}

impl Profile {
    /// Samples `height(r)` (mm) out to the farthest corner of the footprint; `points` samples would span its longer
    /// side.
    ///
    /// At least 2 points; otherwise `None`.
    pub fn sample(
        points: usize,
        footprint_mm: [f64; 2],
        center_mm: [f64; 2],
        height: impl Fn(f64) -> f64,
    ) -> Option<Self> {
        if points < 2 {
            return None;
        }
        let reach_mm = (0.5 * footprint_mm[0] + center_mm[0].abs()).hypot(0.5 * footprint_mm[1] + center_mm[1].abs());
        let spacing_mm = footprint_mm[0].max(footprint_mm[1]) / (points - 1) as f64;
        let count = ((reach_mm / spacing_mm).ceil() as usize).max(2);
        let per_mm = count as f64 / reach_mm;
        let samples: Vec<f64> = (0..=count).map(|k| height(k as f64 / per_mm)).collect();
        let bends = second_differences(&samples);
        let cell = |k: usize| {
            let rise = samples[k + 1] - samples[k];
            [
                samples[k],
                // Rounding would leave a cusp on the axis.
                if k == 0 { 0.0 } else { rise - (2.0 * bends[k] + bends[k + 1]) / 6.0 },
                0.5 * bends[k],
                (bends[k + 1] - bends[k]) / 6.0,
            ]
        };
        Some(Self { center_mm, per_mm, cells: (0..count).map(cell).collect() })
    }

    /// The same profile with every height multiplied.
    pub fn scaled(&self, factor: f64) -> Self {
        let mut out = self.clone();
        out.cells.iter_mut().flatten().for_each(|c| *c *= factor);
        out
    }
}

impl Relief for Profile {
    fn range_mm(&self) -> [f64; 2] {
        // A cubic stays within its Bernstein coefficients.
        let points = self.cells.iter().flat_map(|[a, b, c, d]| {
            let bernstein = [*a, a + b / 3.0, a + (2.0 * b + c) / 3.0, a + b + c + d];
            bernstein.into_iter()
        });
        points.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| [low.min(v), high.max(v)])
    }

    fn steepest(&self) -> f64 {
        self.cells.iter().map(steepest).fold(0.0, f64::max) * self.per_mm
    }

    /// Along the radius an interface bends as its profile; across it as the slope over the distance, which is a mean of
    /// that, as the profile is level on the axis.
    fn bend(&self) -> f64 {
        let ends = self.cells.iter().flat_map(|[_, _, c, d]| [2.0 * c, 2.0 * c + 6.0 * d]);
        ends.map(f64::abs).fold(0.0, f64::max) * self.per_mm * self.per_mm
    }

    fn at(&self, x: f64, y: f64) -> [f64; 3] {
        let (x, y) = (x - self.center_mm[0], y - self.center_mm[1]);
        let r = x.hypot(y);
        let k = ((r * self.per_mm) as usize).min(self.cells.len() - 1);
        let u = (r * self.per_mm - k as f64).min(1.0);
        let [a, b, c, d] = self.cells[k];
        let slope = (b + u * (2.0 * c + u * 3.0 * d)) * self.per_mm / r.max(f64::MIN_POSITIVE);
        [a + u * (b + u * (c + u * d)), slope * x, slope * y]
    }
}

/// Bound on the slope of a cell, by the Bernstein coefficients of its derivative.
fn steepest([_, b, c, d]: &[f64; 4]) -> f64 {
    b.abs().max((b + c).abs()).max((b + 2.0 * c + 3.0 * d).abs())
}

/// Second derivatives of the spline through samples one apart, level at the first and straight at the last, by the
/// Thomas algorithm.
fn second_differences(samples: &[f64]) -> Vec<f64> {
    let last = samples.len() - 1;
    let mut out = vec![0.0; samples.len()];
    let mut ratio = vec![0.5; samples.len()];
    // 2 m_0 + m_1 = 6 (f_1 - f_0); m_(k-1) + 4 m_k + m_(k+1) = 6 (f_(k-1) - 2 f_k + f_(k+1)); m_last = 0.
    out[0] = 3.0 * (samples[1] - samples[0]);
    for k in 1..last {
        let pivot = 4.0 - ratio[k - 1];
        ratio[k] = 1.0 / pivot;
        out[k] = (6.0 * (samples[k - 1] - 2.0 * samples[k] + samples[k + 1]) - out[k - 1]) / pivot;
    }
    for k in (0..last).rev() {
        out[k] -= ratio[k] * out[k + 1];
    }
    out
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    fn bump(r: f64) -> f64 {
        -(-r * r / 8.0).exp()
    }

    fn profile(points: usize) -> Profile {
        Profile::sample(points, [30.0, 20.0], [1.0, -2.0], bump).unwrap()
    }

    #[test]
    fn spline_passes_through_its_samples_and_is_level_on_the_axis() {
        let profile = profile(65);
        for k in 0..=profile.cells.len() {
            let r = k as f64 / profile.per_mm;
            assert!((profile.at(1.0 + 0.6 * r, -2.0 + 0.8 * r)[0] - bump(r)).abs() < 1e-13);
        }
        assert_eq!(profile.at(1.0, -2.0), [bump(0.0), 0.0, 0.0]);
        // Close by it bends as the surface does, to the square of the spacing over 2 mm, 5 %.
        let [_, along, across] = profile.at(1.0 + 3e-9, -2.0 - 4e-9);
        assert!((along.hypot(across) / (5e-9 / 4.0) - 1.0).abs() < 0.05, "{along} {across}");
        assert!(Profile::sample(1, [30.0, 20.0], [0.0; 2], bump).is_none());
    }

    #[test]
    fn error_falls_with_the_fourth_power_of_the_spacing_and_that_of_the_slope_with_the_third() {
        let errors = |points| {
            let profile = profile(points);
            let spots = (1..4000).map(|k| (f64::from(k) * 0.754_877_67 % 1.0, f64::from(k) * 0.569_840_29 % 1.0));
            let mut sums = [0.0; 2];
            for (u, v) in spots {
                let (x, y) = (30.0 * u - 15.0, 20.0 * v - 10.0);
                let r = (x - 1.0).hypot(y + 2.0);
                let [height, along, across] = profile.at(x, y);
                let slope = -0.25 * bump(r);
                sums[0] += (height - bump(r)).powi(2);
                sums[1] += (along - slope * (x - 1.0)).powi(2) + (across - slope * (y + 2.0)).powi(2);
            }
            sums.map(f64::sqrt)
        };
        let (coarse, fine) = (errors(257), errors(513));
        for (order, (coarse, fine)) in [4.0, 3.0].into_iter().zip(coarse.into_iter().zip(fine)) {
            let rate = (coarse / fine).log2();
            assert!((rate - order).abs() < 0.1, "{rate} for {order}");
        }
    }

    #[test]
    fn slope_second_derivative_and_range_never_exceed_their_bounds() {
        let profile = profile(65);
        let (bound, [low, high]) = (profile.bend(), profile.range_mm());
        let (mut tightest, mut steepest) = (0.0f64, 0.0f64);
        for k in 0..20_000 {
            let (x, y) = (0.0173 * k as f64 % 28.0 - 14.0, 0.0531 * k as f64 % 18.0 - 9.0);
            let (c, s) = ((k as f64).cos(), (k as f64).sin());
            let e = 1e-4;
            let h = |t: f64| profile.at(x + t * c, y + t * s)[0];
            assert!(low <= h(0.0) && h(0.0) <= high);
            let [_, along, across] = profile.at(x, y);
            steepest = steepest.max(along.hypot(across));
            let found = ((h(e) - 2.0 * h(0.0) + h(-e)) / (e * e)).abs();
            // 1e-6 covers the rounding of the difference quotient.
            assert!(found <= bound + 1e-6, "{found} against {bound}");
            tightest = tightest.max(found / bound);
        }
        assert!(tightest > 0.9, "{tightest}");
        assert!(steepest <= profile.steepest() && steepest > 0.95 * profile.steepest(), "{steepest}");
        assert!(low > -1.001 && high < 1e-3);
    }
}
