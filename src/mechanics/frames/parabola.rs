//! The least-squares parabola of a frame.

use serde::Serialize;

/// p(x) = c0 + c1 x + c2 x², fitted over a window.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Parabola {
    /// c0 in kPa, c1 in kPa/mm, c2 in kPa/mm^2.
    pub coefficients: [f64; 3],
    /// First and last place of the fit, mm.
    pub window_mm: [f64; 2],
    /// Root of the mean square of what the fit leaves, kPa.
    pub rms_kpa: f64,
}

impl Parabola {
    /// The fit to places `x` (ascending, mm) and pressures `p` (kPa), three at least; `None` with fewer.
    ///
    /// Each sample counts by the length it stands for, half of the gap on either side, and a gap whole at the ends. An
    /// array with equal gaps is so fitted by plain least squares, and a graded mesh like an array.
    pub fn fit(x: &[f64], p: &[f64]) -> Option<Self> {
        let (&first, &last) = (x.first()?, x.last()?);
        if x.len() < 3 || x.len() != p.len() {
            return None;
        }
        // In u from -1 to 1 and with polynomials orthogonal over the samples (Forsythe 1957), nothing is
        // ill-conditioned.
        let (middle, half) = (0.5 * (first + last), 0.5 * (last - first));
        let u: Vec<f64> = x.iter().map(|x| (x - middle) / half).collect();
        let weights = lengths(&u);
        let mean = |f: &dyn Fn(usize) -> f64| (0..u.len()).map(|i| weights[i] * f(i)).sum::<f64>();
        let center = mean(&|i| u[i]);
        let q1 = |i: usize| u[i] - center;
        let square = mean(&|i| q1(i) * q1(i));
        let skew = mean(&|i| q1(i) * q1(i) * q1(i)) / square;
        let q2 = |i: usize| q1(i) * (q1(i) - skew) - square;
        let a0 = mean(&|i| p[i]);
        let a1 = mean(&|i| q1(i) * p[i]) / square;
        let a2 = mean(&|i| q2(i) * p[i]) / mean(&|i| q2(i) * q2(i));
        let rest = |i: usize| p[i] - a0 - a1 * q1(i) - a2 * q2(i);
        let rms_kpa = mean(&|i| rest(i) * rest(i)).sqrt();
        // q1 = (x - shift) / half, collected by powers of x.
        let shift = middle + half * center;
        let (b0, b1, b2) = (a0 - a2 * square, (a1 - a2 * skew) / half, a2 / (half * half));
        let coefficients = [b0 - b1 * shift + b2 * shift * shift, b1 - 2.0 * b2 * shift, b2];
        Some(Self { coefficients, window_mm: [first, last], rms_kpa })
    }

    /// Pressure at a place, kPa.
    pub fn at(&self, x_mm: f64) -> f64 {
        let [c0, c1, c2] = self.coefficients;
        c0 + x_mm * (c1 + x_mm * c2)
    }

    /// Place of the vertex, mm.
    pub fn center_mm(&self) -> f64 {
        -self.coefficients[1] / (2.0 * self.coefficients[2])
    }

    /// Whether it opens downward by more than rounding.
    pub fn has_peak(&self) -> bool {
        let [from, to] = self.window_mm;
        let half = 0.5 * (to - from);
        let rise = -self.coefficients[2] * half * half;
        let size = self.at(from).abs().max(self.at(to).abs()).max(self.at(0.5 * (from + to)).abs());
        // Some hundred samples of rounding error.
        rise > 1e-13 * size
    }
}

/// The share of the window that each sample stands for; they add up to 1.
fn lengths(u: &[f64]) -> Vec<f64> {
    let gap = |i: usize| u[i + 1] - u[i];
    let last = u.len() - 1;
    let length = |i: usize| 0.5 * (gap(if i > 0 { i - 1 } else { 0 }) + gap(if i < last { i } else { last - 1 }));
    let total: f64 = (0..u.len()).map(length).sum();
    (0..u.len()).map(|i| length(i) / total).collect()
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn a_parabola_is_recovered_from_uneven_samples() {
        let x: Vec<f64> = (0..23).map(|i| -7.0 + 0.5 * f64::from(i) + 0.2 * f64::from(i % 3)).collect();
        let p: Vec<f64> = x.iter().map(|x| 8.0 - 0.25 * (x - 1.5) * (x - 1.5)).collect();
        let fit = Parabola::fit(&x, &p).unwrap();
        // 8 - 0.25 * 2.25, 0.75, -0.25; rounding of 23 sums.
        for (got, expected) in fit.coefficients.iter().zip([7.4375, 0.75, -0.25]) {
            assert!((got - expected).abs() < 1e-13, "{got} {expected}");
        }
        assert!((fit.center_mm() - 1.5).abs() < 1e-12 && fit.rms_kpa < 1e-13 && fit.has_peak());
    }

    #[test]
    fn equal_gaps_give_plain_least_squares() {
        // numpy.polyfit([-2..2], [0, 3, 1, 2, 0.5], 2): the normal equations with sums 5, 0, 10, 0, 34.
        let (x, p) = ([-2.0, -1.0, 0.0, 1.0, 2.0], [0.0, 3.0, 1.0, 2.0, 0.5]);
        let (s0, s1, s2) = (6.5, 0.0 - 3.0 + 2.0 + 1.0, 3.0 + 2.0 + 2.0);
        let c2 = (5.0 * s2 - 10.0 * s0) / (5.0 * 34.0 - 100.0);
        let expected = [(s0 - 10.0 * c2) / 5.0, s1 / 10.0, c2];
        let fit = Parabola::fit(&x, &p).unwrap();
        for (got, expected) in fit.coefficients.iter().zip(expected) {
            assert!((got - expected).abs() < 1e-13, "{got} {expected}");
        }
    }

    #[test]
    fn a_straight_line_has_no_peak() {
        let x: Vec<f64> = (0..50).map(|i| f64::from(i) * 0.1).collect();
        for slope in [0.0, 0.3, -2.0] {
            let p: Vec<f64> = x.iter().map(|x| 4.7 + slope * x).collect();
            assert!(!Parabola::fit(&x, &p).unwrap().has_peak(), "{slope}");
        }
        assert_eq!(Parabola::fit(&[0.0, 1.0], &[0.0, 1.0]), None);
    }
}
