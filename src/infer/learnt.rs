//! What is learnt from simulated frames: how they follow the unknowns, and how they vary for other reasons.
//!
//! Frames are one long vector y of logarithms of light. Weighted by its noise, y = mean + sum_k s_k(x) phi_k + noise:
//! few principal components hold what follows the unknowns x, each score a Gaussian process of x. What training images
//! have beside that is the noise of their light; its covariance is kept, that of the scores by points that are left out
//! and what lies beyond them by its own components, so that a seen frame's light may be as noisy, less or more, by one
//! factor. Images may be their own mirror images, noise and all, where others are not; scores follow what mirror images
//! have in common, and so the factor is told by that alone.

use super::unknown::{Unknown, followed};
use crate::emulate::{Components, FitError, GaussianProcess, Predicted};
use faer::Mat;
use rayon::prelude::*;
use serde::{Deserialize, Serialize, Serializer};
use std::collections::HashMap;

/// Components that are tried, at most, and points for each.
const MOST_TRIED: usize = 16;
const POINTS_A_COMPONENT: usize = 6;
/// A component counts where its score, left out, is predicted but for this share of its variance: weaker ones make
/// estimates no better, and intervals too short (docs/decisions/inference.md).
const LEAST_TOLD: f64 = 0.2;
/// Components of the noise.
const NOISE_COMPONENTS: usize = 30;

/// How numbers follow unknowns: the scores of frames, and what is measured beside them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Scored {
    /// The unknowns.
    pub unknowns: Vec<Unknown>,
    /// Each number, scores first.
    pub processes: Vec<GaussianProcess>,
    /// Mean variance of each when it is predicted.
    pub variances: Vec<f64>,
    /// Means of products of two numbers' residuals where a point is left out, each in units of the standard deviation
    /// that its process says, noise included: 1 for each by itself, if processes know how well they know.
    pub left_out: Vec<Vec<f64>>,
}

/// How frames follow unknowns.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Learnt {
    /// How their scores do.
    pub scored: Scored,
    /// One over the standard deviation of the noise of each element, roughly.
    #[serde(serialize_with = "short")]
    pub weights: Vec<f64>,
    /// Mean of the weighted vectors.
    #[serde(serialize_with = "short")]
    pub mean: Vec<f64>,
    /// Directions of the weighted vectors that follow the unknowns.
    #[serde(serialize_with = "short_each")]
    pub directions: Vec<Vec<f64>>,
    /// Shares of the scores of what they were learnt from that are each one's own noise: directions lean to it, and
    /// other frames have nothing of it.
    pub own: Vec<f64>,
    /// Directions of the noise of light beyond those, times its standard deviation along each.
    #[serde(serialize_with = "short_each")]
    pub noise: Vec<Vec<f64>>,
    /// Variance of an element's noise beyond both.
    pub rest: f64,
    /// Which elements are one another's mirror images: those of one number.
    pub alike: Vec<usize>,
    /// As `rest`, of what these have in common.
    pub rest_alike: f64,
    /// What else may vary, to first order: changes of the weighted vector by one standard deviation.
    pub nuisances: Vec<Nuisance>,
}

/// A change of the frames that is not followed but allowed for.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Nuisance {
    /// Its name.
    pub name: String,
    /// The change of the weighted vector by one standard deviation.
    #[serde(serialize_with = "short")]
    pub change: Vec<f64>,
}

/// A direction that may follow the unknowns.
struct Tried {
    direction: Vec<f64>,
    own: f64,
    /// Scores along it, own noise and all.
    scores: Vec<f64>,
    process: GaussianProcess,
    left_out: Vec<Predicted>,
}

impl Tried {
    /// Whether its scores are predicted where they are left out.
    fn follows(&self) -> bool {
        let mean = self.scores.iter().sum::<f64>() / self.scores.len() as f64;
        let spread: f64 = self.scores.iter().map(|score| ((1.0 - self.own) * (score - mean)).powi(2)).sum();
        let missed: f64 = self.left_out.iter().map(|left| left.value.powi(2)).sum();
        missed <= LEAST_TOLD * spread
    }
}

impl Learnt {
    /// Learns from vectors at points, each point a coordinate for every unknown; `alike` as [`Self::alike`].
    ///
    /// # Errors
    /// Too few points, points that do not tell the unknowns apart.
    pub fn from(
        unknowns: Vec<Unknown>,
        points: &[Vec<f64>],
        vectors: &[Vec<f64>],
        weights: Vec<f64>,
        alike: Vec<usize>,
    ) -> Result<Self, FitError> {
        let n = points.len();
        let points: Vec<Vec<f64>> = points.iter().map(|point| followed(&unknowns, point)).collect();
        let weighted: Vec<Vec<f64>> =
            vectors.iter().map(|vector| vector.iter().zip(&weights).map(|(v, w)| v * w).collect()).collect();
        let Components { mean, directions, variances } =
            Components::of(&weighted, MOST_TRIED.min(n / POINTS_A_COMPONENT));
        // What lies beyond the components, of a point: the power of its noise.
        let square = |vector: &Vec<f64>| vector.iter().zip(&mean).map(|(v, mean)| (v - mean).powi(2)).sum::<f64>();
        let power = weighted.iter().map(square).sum::<f64>() / (n as f64 - 1.0) - variances.iter().sum::<f64>();
        let tried = directions.into_par_iter().zip(variances).map(|(direction, variance)| {
            let score = |vector: &Vec<f64>| -> f64 {
                vector.iter().zip(&mean).zip(&direction).map(|((v, mean), d)| (v - mean) * d).sum()
            };
            let scores: Vec<f64> = weighted.iter().map(score).collect();
            let own = (power / ((n as f64 - 1.0) * variance)).min(1.0);
            let others: Vec<f64> = scores.iter().map(|score| (1.0 - own) * score).collect();
            let process = GaussianProcess::fit(&points, &others)?;
            let left_out = process.left_out(&others)?;
            Ok(Tried { direction, own, scores, process, left_out })
        });
        let tried = tried.collect::<Result<Vec<_>, FitError>>()?;
        let mut learnt = Self {
            scored: Scored { unknowns, processes: Vec::new(), variances: Vec::new(), left_out: Vec::new() },
            weights,
            mean,
            directions: Vec::new(),
            own: Vec::new(),
            noise: Vec::new(),
            rest: 0.0,
            alike,
            rest_alike: 0.0,
            nuisances: Vec::new(),
        };
        let mut residuals: Vec<Vec<f64>> =
            weighted.iter().map(|vector| vector.iter().zip(&learnt.mean).map(|(v, mean)| v - mean).collect()).collect();
        let mut left_out = Vec::new();
        for tried in tried.into_iter().filter(Tried::follows) {
            for (residual, score) in residuals.iter_mut().zip(&tried.scores) {
                residual.iter_mut().zip(&tried.direction).for_each(|(r, d)| *r -= score * d);
            }
            learnt.directions.push(tried.direction);
            learnt.own.push(tried.own);
            learnt.scored.processes.push(tried.process);
            left_out.push(tried.left_out);
        }
        learnt.scored.add(&left_out);
        let noise = Components::of(&residuals, NOISE_COMPONENTS.min(n / 2));
        let length = learnt.mean.len();
        learnt.noise = noise
            .directions
            .iter()
            .zip(&noise.variances)
            .map(|(direction, variance)| direction.iter().map(|d| d * variance.sqrt()).collect())
            .collect();
        for residual in &mut residuals {
            residual.iter_mut().zip(&noise.mean).for_each(|(r, mean)| *r -= mean);
        }
        let beyond = length.saturating_sub(learnt.directions.len() + noise.variances.len()).max(1) as f64;
        let of = |vectors: &[Vec<f64>]| vectors.iter().flatten().map(|v| v * v).sum::<f64>();
        let rest = |all: &[Vec<f64>], held: &[Vec<f64>]| ((of(all) / (n as f64 - 1.0) - of(held)) / beyond).max(0.0);
        learnt.rest = rest(&residuals, &learnt.noise);
        let in_common = |vectors: &[Vec<f64>]| -> Vec<Vec<f64>> {
            vectors.iter().map(|vector| in_common(vector, &learnt.alike)).collect()
        };
        learnt.rest_alike = rest(&in_common(&residuals), &in_common(&learnt.noise));
        Ok(learnt)
    }

    /// What is learnt of other unknowns in the same directions: scores of vectors at other points.
    ///
    /// # Errors
    /// As [`Self::from`].
    pub fn beside(
        &self,
        unknowns: Vec<Unknown>,
        points: &[Vec<f64>],
        vectors: &[Vec<f64>],
    ) -> Result<Scored, FitError> {
        let points: Vec<Vec<f64>> = points.iter().map(|point| followed(&unknowns, point)).collect();
        let processes = self.directions.par_iter().map(|direction| {
            let scores: Vec<f64> = vectors.iter().map(|vector| self.score(vector, direction)).collect();
            let process = GaussianProcess::fit(&points, &scores)?;
            let left_out = process.left_out(&scores)?;
            Ok((process, left_out))
        });
        let (processes, left_out): (_, Vec<_>) = processes.collect::<Result<Vec<_>, FitError>>()?.into_iter().unzip();
        let mut scored = Scored { unknowns, processes, variances: Vec::new(), left_out: Vec::new() };
        scored.add(&left_out);
        Ok(scored)
    }

    /// By how many standard deviations each point's worst score is off where it is left out; vectors at the points that
    /// all was learnt from.
    ///
    /// # Errors
    /// As [`Self::from`].
    pub fn left_out(&self, vectors: &[Vec<f64>]) -> Result<Vec<f64>, FitError> {
        let each = self.directions.par_iter().zip(&self.own).zip(&self.scored.processes);
        let off = each.map(|((direction, own), process)| {
            let scores: Vec<f64> = vectors.iter().map(|vector| (1.0 - own) * self.score(vector, direction)).collect();
            Ok(in_units(&process.left_out(&scores)?).into_iter().map(f64::abs).collect())
        });
        let off = off.collect::<Result<Vec<Vec<f64>>, FitError>>()?;
        let worst = |point: usize| off.iter().filter_map(|score| score.get(point).copied()).fold(0.0, f64::max);
        Ok((0..vectors.len()).map(worst).collect())
    }

    /// A score of a vector of logarithms of light.
    fn score(&self, vector: &[f64], direction: &[f64]) -> f64 {
        let weighted = vector.iter().zip(&self.weights).zip(&self.mean).map(|((v, w), mean)| v * w - mean);
        weighted.zip(direction).map(|(v, d)| v * d).sum()
    }

    /// The vector of logarithms of light that has these scores.
    pub fn vector(&self, scores: &[f64]) -> Vec<f64> {
        let mut vector = self.mean.clone();
        for (direction, score) in self.directions.iter().zip(scores) {
            vector.iter_mut().zip(direction).for_each(|(v, d)| *v += score * d);
        }
        vector.iter().zip(&self.weights).map(|(v, weight)| v / weight).collect()
    }

    /// Whether all parts are of vectors of one length, and scores of these directions.
    pub fn is_whole(&self, length: usize) -> bool {
        let nuisances = self.nuisances.iter().map(|nuisance| &nuisance.change);
        let ends = [&self.weights, &self.mean].into_iter();
        let mut vectors = ends.chain(&self.directions).chain(&self.noise).chain(nuisances);
        let finite = |vector: &&Vec<f64>| vector.len() == length && vector.iter().all(|v| v.is_finite());
        vectors.all(|vector| finite(&vector))
            && self.weights.iter().all(|weight| *weight > 0.0)
            && self.rest >= 0.0
            && self.rest_alike >= 0.0
            && self.alike.len() == length
            && !self.directions.is_empty()
            && self.own.len() == self.directions.len()
            && self.own.iter().all(|share| (0.0..=1.0).contains(share))
    }
}

impl Scored {
    /// Numbers beside the scores follow the unknowns too: of each point as many.
    ///
    /// # Errors
    /// As [`Learnt::from`].
    pub fn and(mut self, points: &[Vec<f64>], numbers: &[Vec<f64>]) -> Result<Self, FitError> {
        let points: Vec<Vec<f64>> = points.iter().map(|point| followed(&self.unknowns, point)).collect();
        let mut left_out = Vec::new();
        for k in 0..numbers.first().map_or(0, Vec::len) {
            let values: Vec<f64> = numbers.iter().filter_map(|of_point| of_point.get(k).copied()).collect();
            let process = GaussianProcess::fit(&points, &values)?;
            left_out.push(process.left_out(&values)?);
            self.processes.push(process);
        }
        self.add(&left_out);
        Ok(self)
    }

    /// What the points that are left out tell of the last processes: errors that these share, and none of the others.
    fn add(&mut self, left_out: &[Vec<Predicted>]) {
        let (before, all) = (self.left_out.len(), self.left_out.len() + left_out.len());
        let processes = self.processes.iter().skip(before);
        self.variances.extend(processes.zip(left_out).map(|(process, left)| of_prediction(process, left)));
        let units: Vec<Vec<f64>> = left_out.iter().map(|left| in_units(left)).collect();
        self.left_out.iter_mut().for_each(|row| row.resize(all, 0.0));
        for one in &units {
            let row = (0..before).map(|_| 0.0).chain(units.iter().map(|other| mean_product(one, other)));
            self.left_out.push(row.collect());
        }
    }

    /// Covariance of the errors of numbers that are predicted with these variances, the noise of their light apart:
    /// as large as points that are left out show, and never less than the processes say. It goes from number to number
    /// as the residuals do.
    pub fn errors(&self, places: &[usize], variances: &[f64]) -> Mat<f64> {
        let own = |k: usize| self.left_out.get(k).and_then(|row| row.get(k)).copied().unwrap_or(0.0);
        let deviation = |(&k, variance): (&usize, &f64)| {
            let noise = self.processes.get(k).map_or(0.0, |process| process.noise().powi(2));
            (own(k).max(1.0) * (variance + noise) - noise).sqrt()
        };
        let deviations: Vec<f64> = places.iter().zip(variances).map(deviation).collect();
        self.covariance(places, &deviations)
    }

    /// Covariance of the noise of numbers that is that of what they were learnt from. What components tell of the noise
    /// is not the same: they hold little of it, and take the rest for as strong in one direction as in another, where
    /// light is noisier in those that are smooth.
    pub fn noise(&self, places: &[usize]) -> Mat<f64> {
        let deviation = |k: &usize| self.processes.get(*k).map_or(0.0, GaussianProcess::noise);
        self.covariance(places, &places.iter().map(deviation).collect::<Vec<f64>>())
    }

    /// Covariance of numbers of these standard deviations that go together as residuals do where points are left out.
    fn covariance(&self, places: &[usize], deviations: &[f64]) -> Mat<f64> {
        let product = |k: usize, l: usize| self.left_out.get(k).and_then(|row| row.get(l)).copied().unwrap_or(0.0);
        let together =
            |k: usize, l: usize| product(k, l) / (product(k, k) * product(l, l)).sqrt().max(f64::MIN_POSITIVE);
        Mat::from_fn(places.len(), places.len(), |i, j| {
            let shared = if i == j { 1.0 } else { together(places[i], places[j]) };
            deviations[i] * deviations[j] * shared
        })
    }

    /// Scores at a place, and the numbers beside them.
    pub fn at(&self, place: &[f64]) -> Vec<f64> {
        let place = followed(&self.unknowns, place);
        self.processes.iter().map(|process| process.value(&place)).collect()
    }

    /// Whether it has so many numbers, all of its unknowns.
    pub fn is_whole(&self, numbers: usize) -> bool {
        let is_whole = |process: &GaussianProcess| process.is_whole(self.unknowns.len());
        [self.processes.len(), self.variances.len(), self.left_out.len()] == [numbers; 3]
            && self.left_out.iter().all(|row| row.len() == numbers && row.iter().all(|v| v.is_finite()))
            && self.processes.iter().all(is_whole)
            && self.variances.iter().all(|variance| *variance >= 0.0)
            && self.unknowns.iter().all(|unknown| unknown.is_whole(self.unknowns.len()))
    }
}

/// Residuals in units of the standard deviations that were said.
fn in_units(left_out: &[Predicted]) -> Vec<f64> {
    left_out.iter().map(|left| left.value / left.variance.sqrt()).collect()
}

fn mean_product(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>() / a.len().max(1) as f64
}

/// Mean variance of a predicted score: what is left of that of a value left out, less its noise.
fn of_prediction(process: &GaussianProcess, left_out: &[Predicted]) -> f64 {
    let mean = left_out.iter().map(|left| left.variance).sum::<f64>() / left_out.len().max(1) as f64;
    (mean - process.noise().powi(2)).max(0.0)
}

/// Each number of a vector with the mean over those of its kind.
pub(super) fn in_common(vector: &[f64], kinds: &[usize]) -> Vec<f64> {
    let mut sums: HashMap<usize, (f64, f64)> = HashMap::new();
    for (v, kind) in vector.iter().zip(kinds) {
        let (sum, count) = sums.entry(*kind).or_default();
        (*sum, *count) = (*sum + v, *count + 1.0);
    }
    kinds.iter().map(|kind| sums.get(kind).map_or(0.0, |(sum, count)| sum / count)).collect()
}

/// Numbers of five digits: a file of all would be three times as long, and say no more.
fn short<S: Serializer>(numbers: &[f64], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(numbers.iter().map(|number| shortened(*number)))
}

fn short_each<S: Serializer>(vectors: &[Vec<f64>], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(vectors.iter().map(|vector| vector.iter().map(|v| shortened(*v)).collect::<Vec<_>>()))
}

fn shortened(number: f64) -> f64 {
    format!("{number:.4e}").parse().unwrap_or(number)
}
