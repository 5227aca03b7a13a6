//! How well unknowns can be known at best: the Cramér-Rao bound.
//!
//! Of scores s(x) with the covariance C no unbiased estimate of x has a smaller covariance than the inverse of Fisher's
//! information (Kay, Fundamentals of Statistical Signal Processing I, 1993, chapter 3):
//!
//! ```text
//! F = J' C^-1 J + P,   J = ds/dx
//! ```
//!
//! P is what is known beforehand of unknowns that are integrated away: as much as a normal number of their prior's
//! variance would tell. J is learnt, with an error, and an unknown that changes the scores much as the others do is
//! told by little more than that error. So J is drawn many times from what is known of it, and the bound has an
//! interval.

use super::learnt::Scored;
use super::unknown;
use crate::camera::noise::PixelRandom;
use crate::emulate::{FitError, GaussianProcess, Slopes, Variances};
use crate::estimate::Value;
use faer::linalg::solvers::{DenseSolveCore as _, Llt};
use faer::{Mat, Side};

/// Draws of the slopes, and their seed.
const DRAWS: usize = 400;
const SEED: u32 = 77;
/// Information that keeps a matrix positive where a score does not tell an unknown: of a deviation of so many widths of
/// its prior.
const UNTOLD: f64 = 1e3;

impl Scored {
    /// What tells variances and slopes of each score.
    ///
    /// # Errors
    /// A covariance that cannot be factorised.
    pub fn variances_of_scores(&self) -> Result<Vec<Variances<'_>>, FitError> {
        self.processes.iter().map(GaussianProcess::variances).collect()
    }

    /// Variance of a score where it is predicted at a place.
    pub fn variance(&self, of: &Variances, place: &[f64]) -> f64 {
        of.at(&unknown::followed(&self.unknowns, place))
    }

    /// Slopes of a score along the coordinates at a place.
    pub fn slopes(&self, of: &Variances, place: &[f64]) -> Slopes {
        let slopes = of.slopes(&unknown::followed(&self.unknowns, place));
        let along = unknown::slopes(&self.unknowns, place);
        let d = self.unknowns.len();
        let value = |j: usize| (0..d).map(|i| along[(i, j)] * slopes.values[i]).sum();
        let covariance = along.transpose() * &slopes.covariance * &along;
        Slopes { values: (0..d).map(value).collect(), covariance }
    }

    /// Least standard deviation of each unknown's coordinate where scores of these slopes have this covariance, with
    /// the interval of 95 % that the slopes leave. `integrated` says which unknowns are integrated away.
    ///
    /// # Errors
    /// A covariance that cannot be factorised.
    pub fn bound(&self, slopes: &[Slopes], covariance: &Mat<f64>, integrated: &[bool]) -> Result<Vec<Value>, FitError> {
        let inverse = |of: &Mat<f64>| Some(Llt::new(of.as_ref(), Side::Lower).ok()?.inverse());
        let weight = inverse(covariance).ok_or(FitError::Degenerate)?;
        let d = self.unknowns.len();
        let known: Vec<f64> = (self.unknowns.iter().zip(integrated))
            .map(|(unknown, integrated)| {
                let [low, high] = unknown.prior.bounds();
                let width = high - low;
                if *integrated { 12.0 / (width * width) } else { (UNTOLD * width).powi(-2) }
            })
            .collect();
        let deviations = |slopes: &Mat<f64>| -> Option<Vec<f64>> {
            let told = slopes.transpose() * (&weight * slopes);
            let whole = Mat::from_fn(d, d, |i, j| told[(i, j)] + if i == j { known[i] } else { 0.0 });
            let least = inverse(&whole)?;
            Some((0..d).map(|i| least[(i, i)].sqrt()).collect())
        };
        let drawn: Vec<Mat<f64>> = slopes.iter().map(root).collect::<Option<_>>().ok_or(FitError::Degenerate)?;
        let mut random = PixelRandom::new(SEED, 0);
        let mut draw = || {
            let rows: Vec<Vec<f64>> = (slopes.iter().zip(&drawn))
                .map(|(slopes, root)| {
                    let normal: Vec<f64> = (0..d).map(|_| random.normal()).collect();
                    let off = |i: usize| (0..=i).map(|j| root[(i, j)] * normal[j]).sum::<f64>();
                    (0..d).map(|i| slopes.values[i] + off(i)).collect()
                })
                .collect();
            deviations(&Mat::from_fn(rows.len(), d, |k, i| rows[k][i]))
        };
        let draws: Vec<Vec<f64>> = (0..DRAWS).filter_map(|_| draw()).collect();
        let of = |i: usize| {
            let mut all: Vec<f64> = draws.iter().map(|draw| draw[i]).collect();
            all.sort_by(f64::total_cmp);
            let at = |share: f64| all.get((share * (all.len() as f64 - 1.0)).round() as usize).copied();
            match (at(0.025), at(0.5), at(0.975)) {
                (Some(low), Some(value), Some(high)) => Value::known(value, low, high),
                _ => Value::undefined("the scores do not tell it"),
            }
        };
        Ok((0..d).map(of).collect())
    }
}

/// The lower root of the slopes' covariance, what rounding makes negative being none.
fn root(slopes: &Slopes) -> Option<Mat<f64>> {
    let of = &slopes.covariance;
    let d = of.nrows();
    let largest = (0..d).map(|i| of[(i, i)]).fold(0.0, f64::max);
    if largest <= 0.0 {
        return Some(Mat::zeros(d, d));
    }
    let whole = Mat::from_fn(d, d, |i, j| {
        0.5 * (of[(i, j)] + of[(j, i)]) + if i == j { 1e-9 * of[(i, i)].abs() + 1e-12 * largest } else { 0.0 }
    });
    let factor = Llt::new(whole.as_ref(), Side::Lower).ok()?;
    Some(Mat::from_fn(d, d, |i, j| if j <= i { factor.L()[(i, j)] } else { 0.0 }))
}
