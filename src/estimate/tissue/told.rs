//! What a fit leaves open: the covariance of the unknowns, draws of them, and what is said of each.

use super::Value;
use super::unknowns::WORDS;
use crate::camera::noise::PixelRandom;
use faer::linalg::solvers::{DenseSolveCore as _, Llt};
use faer::{Mat, Side};

/// Draws of the unknowns.
const DRAWS: usize = 8000;
/// An estimate is undefined where more than `MOST_AT_END` of the draws lie in the outer `END` of its range, or beyond.
const END: f64 = 0.05;
const MOST_AT_END: f64 = 0.2;
/// Or where its variance is more than this share of that before anything was seen.
const TOLD: f64 = 0.25;

/// Covariance and draws of the unknowns.
pub(super) struct Told {
    covariance: Mat<f64>,
    draws: Vec<Vec<f64>>,
    /// Share of all draws of each unknown that lie near an end of its range, or beyond.
    at_end: Vec<f64>,
}

impl Told {
    /// About a point, with the inverse of its covariance; none where that has no factor.
    pub fn of(point: &[f64], normal: &Mat<f64>, ranges: &[[f64; 2]], seed: u32) -> Option<Self> {
        let covariance = Llt::new(normal.as_ref(), Side::Lower).ok()?.inverse();
        let spread = Llt::new(covariance.as_ref(), Side::Lower).ok()?;
        let n = point.len();
        let mut random = PixelRandom::new(seed, u32::MAX);
        let all: Vec<Vec<f64>> = (0..DRAWS)
            .map(|_| {
                let z = Mat::from_fn(n, 1, |_, _| random.normal());
                let off = spread.L() * z;
                (0..n).map(|k| point[k] + off[(k, 0)]).collect()
            })
            .collect();
        let near_end = |k: usize, x: f64| {
            let [low, high] = ranges[k];
            let margin = END * (high - low);
            x < low + margin || x > high - margin
        };
        let share = |k: usize| all.iter().filter(|draw| near_end(k, draw[k])).count() as f64 / DRAWS as f64;
        let at_end = (0..n).map(share).collect();
        let holds = |draw: &Vec<f64>| draw.iter().zip(ranges).all(|(x, [low, high])| (*low..=*high).contains(x));
        Some(Self { covariance, draws: all.into_iter().filter(holds).collect(), at_end })
    }

    pub fn correlation(&self) -> Vec<Vec<f64>> {
        let of =
            |i: usize, j: usize| self.covariance[(i, j)] / (self.covariance[(i, i)] * self.covariance[(j, j)]).sqrt();
        let n = self.covariance.nrows();
        (0..n).map(|i| (0..n).map(|j| of(i, j)).collect()).collect()
    }

    /// A function of these unknowns, with the middle 95 % of its draws.
    pub fn value(&self, best: &[f64], of: &dyn Fn(&[f64]) -> f64, unknowns: &[usize], ranges: &[[f64; 2]]) -> Value {
        let sought = || unknowns.iter().copied().filter(|&k| k < best.len());
        if let Some(k) = sought().find(|&k| self.covariance[(k, k)] > TOLD * variance(&ranges[k])) {
            return Value::undefined(format!("the frames hardly tell the {}", WORDS[k]));
        }
        if let Some(k) = sought().find(|&k| self.at_end[k] > MOST_AT_END) {
            let side = if best[k] > middle(&ranges[k]) { "upper" } else { "lower" };
            return Value::undefined(format!(
                "the {} is not told apart from the {side} end of the range in which it is sought",
                WORDS[k]
            ));
        }
        let mut drawn: Vec<f64> = self.draws.iter().map(|draw| of(draw)).collect();
        drawn.sort_by(f64::total_cmp);
        let quantile = |share: f64| drawn.get((share * drawn.len().saturating_sub(1) as f64).round() as usize).copied();
        match (quantile(0.025), quantile(0.975)) {
            (Some(low), Some(high)) => {
                let value = of(best).clamp(low, high);
                Value::known(value, low, high)
            }
            _ => Value::undefined("no draw lies within the ranges"),
        }
    }
}

/// Middle of a range, and the variance of what is anywhere in it.
pub(super) fn middle([low, high]: &[f64; 2]) -> f64 {
    0.5 * (low + high)
}

pub(super) fn variance([low, high]: &[f64; 2]) -> f64 {
    (high - low).powi(2) / 12.0
}
