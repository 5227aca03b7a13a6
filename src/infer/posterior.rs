//! What is known of the unknowns after frames were seen.
//!
//! Scores s of frames and their prediction s(x) differ by the frames' noise and the error of the prediction, with the
//! covariance C of both, the latter by cross validation. Predictions err more in some places than in others, so the
//! likelihood has the heavy tails of Student's t: docs/decisions/inference.md has what intervals hold with and without.
//!
//! ```text
//! log L = -(nu + K)/2 log(1 + q / nu),   q = (s - s(x))' C^-1 (s - s(x))
//! ```

use super::ensemble::Ensemble;
use super::importance::Weighted;
use super::learnt::Scored;
use super::seen::Told;
use super::unknown;
use crate::camera::noise::PixelRandom;
use crate::emulate::{Evaluator, FitError, GaussianProcess};
use faer::Side;
use faer::linalg::solvers::{DenseSolveCore as _, Llt};

/// Draws among which the walkers start, walkers, and their steps until they are about where the density is.
const DRAWS: usize = 4000;
const WALKERS: usize = 64;
const SETTLING: usize = 150;
/// Their steps after that, as the variance of the prediction is that at the best place.
const FOLLOWING: usize = 50;
/// Draws that are kept.
const KEPT: usize = 4000;
/// Every how many steps walkers are kept.
const EACH: usize = 5;
/// Degrees of freedom of the scores' tails.
pub const TAILS: f64 = 6.0;

/// What is known of the unknowns after frames were seen.
#[derive(Debug, Clone, PartialEq)]
pub struct Posterior {
    /// Draws: a value for each unknown.
    pub draws: Vec<Vec<f64>>,
    /// Sum of squares of the scores at the best place, in units of their errors.
    pub misfit: f64,
    /// The scores there, and the numbers beside them.
    pub scores: Vec<f64>,
    /// How many independent draws the draws are worth (Kish).
    pub worth: f64,
}

impl Scored {
    /// Draws of the unknowns, given what frames tell.
    ///
    /// # Errors
    /// A covariance that cannot be factorised.
    pub fn posterior(&self, told: &Told, seed: u32) -> Result<Posterior, FitError> {
        let mut random = PixelRandom::new(seed, 1);
        let drawn = |random: &mut PixelRandom| -> Vec<f64> {
            let along = |[low, high]: [f64; 2], u: f64| low + (high - low) * u;
            self.unknowns.iter().map(|unknown| along(unknown.prior.bounds(), random.uniform())).collect()
        };
        let follows = |k: &usize| Some((self.processes.get(*k)?, *self.variances.get(*k)?));
        let (followed, variances): (Vec<_>, Vec<_>) = told.places.iter().filter_map(follows).unzip();
        let rough = self.density(told, &followed, &variances)?;
        let mut places: Vec<(f64, Vec<f64>)> =
            (0..DRAWS).map(|_| drawn(&mut random)).map(|place| (rough(&place), place)).collect();
        places.sort_by(|a, b| b.0.total_cmp(&a.0));
        let places = places.into_iter().take(WALKERS).map(|(_, place)| place).collect();
        let mut ensemble = Ensemble::new(places, seed ^ 0x5a5a, &rough);
        (0..SETTLING).for_each(|_| ensemble.step(&rough));
        let best = |ensemble: &Ensemble| {
            ensemble
                .walkers
                .iter()
                .max_by(|a, b| a.1.total_cmp(&b.1))
                .map(|(place, _)| place.clone())
                .unwrap_or_default()
        };
        // The variance of the prediction is that at the best place.
        let at = best(&ensemble);
        let place = unknown::followed(&self.unknowns, &at);
        let variances = followed.iter().map(|process| Ok(process.variances()?.at(&place)));
        let variances = variances.collect::<Result<Vec<f64>, FitError>>()?;
        let density = self.density(told, &followed, &variances)?;
        let places = ensemble.walkers.into_iter().map(|(place, _)| place).collect();
        let mut ensemble = Ensemble::new(places, seed ^ 0xa5a5, &density);
        let mut cloud = Vec::new();
        for step in 0..FOLLOWING {
            ensemble.step(&density);
            if step % EACH == 0 && 2 * step >= FOLLOWING {
                cloud.extend(ensemble.walkers.iter().map(|(place, _)| place.clone()));
            }
        }
        let weighted = Weighted::of(cloud, seed ^ 0x3c3c, &density).ok_or(FitError::Degenerate)?;
        let top = weighted.top.clone().ok_or(FitError::Degenerate)?;
        let draws = weighted.drawn(KEPT, &mut random).iter().map(|place| self.values(place)).collect();
        // The sum of squares whose tail has this likelihood.
        let tails = TAILS + told.scores.len() as f64;
        let misfit = TAILS * (-2.0 * top.0 / tails).exp_m1();
        Ok(Posterior { draws, misfit, scores: self.at(&top.1), worth: weighted.worth })
    }

    /// Values of the unknowns of a place.
    fn values(&self, place: &[f64]) -> Vec<f64> {
        self.unknowns.iter().zip(place).map(|(unknown, x)| unknown.prior.value(*x)).collect()
    }

    /// Logarithm of the density of a place, where what was told is predicted with these variances.
    fn density<'a>(
        &'a self,
        told: &'a Told,
        followed: &'a [&GaussianProcess],
        variances: &[f64],
    ) -> Result<impl Fn(&[f64]) -> f64 + Sync + 'a, FitError> {
        let k = told.scores.len();
        if followed.len() != k {
            return Err(FitError::Degenerate);
        }
        let whole = &told.covariance + self.errors(&told.places, variances);
        let inverse = Llt::new(whole.as_ref(), Side::Lower).map_err(|_| FitError::Degenerate)?.inverse();
        let followed: Vec<Evaluator> = followed.iter().map(|process| process.evaluator()).collect();
        Ok(move |place: &[f64]| {
            if self.unknowns.iter().zip(place).any(|(one, x)| !one.prior.holds(*x)) {
                return f64::NEG_INFINITY;
            }
            let place = unknown::followed(&self.unknowns, place);
            let off = told.scores.iter().zip(&followed).map(|(told, process)| told - process.value(&place));
            let off: Vec<f64> = off.collect();
            let mut square = 0.0;
            for i in 0..k {
                for j in 0..k {
                    square += off[i] * inverse[(i, j)] * off[j];
                }
            }
            -0.5 * (TAILS + k as f64) * (square / TAILS).ln_1p()
        })
    }
}

impl Posterior {
    /// Share of the draws in which an unknown is below a value, of those that lie within `ranges`, one for each unknown
    /// that has one: truths that are drawn from less than the prior have even ranks among these alone. None without
    /// draws.
    pub fn below(&self, unknown: usize, value: f64, ranges: &[Option<[f64; 2]>]) -> Option<f64> {
        let inside = |draw: &&Vec<f64>| {
            let holds = |(drawn, range): (&f64, &Option<[f64; 2]>)| {
                range.is_none_or(|[low, high]| (low..=high).contains(drawn))
            };
            draw.iter().zip(ranges).all(holds)
        };
        let draws = || self.draws.iter().filter(inside);
        let below = draws().filter(|draw| draw.get(unknown).is_some_and(|drawn| *drawn < value)).count();
        Some(draws().count()).filter(|all| *all > 0).map(|all| below as f64 / all as f64)
    }

    /// Quantile of an unknown.
    pub fn quantile(&self, unknown: usize, share: f64) -> f64 {
        let mut values: Vec<f64> = self.draws.iter().filter_map(|draw| draw.get(unknown).copied()).collect();
        values.sort_by(f64::total_cmp);
        let place = (share * values.len().saturating_sub(1) as f64).round() as usize;
        values.get(place).copied().unwrap_or(f64::NAN)
    }
}
