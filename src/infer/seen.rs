//! What seen frames say of the scores: least squares over their elements.
//!
//! ```text
//! y - mean = Phi s + noise,   s = G (y - mean),   G = (Phi' Phi)^-1 Phi',   cov s = G C G'
//! C = camera + factor (Phi N Phi' + beyond) + nuisances
//! ```
//!
//! N is the covariance of the scores' noise in the training images, `beyond` that of what lies across the scores: with
//! all elements nothing of it is in them, as G Phi = 1.
//! The light's noise is that of the training images times a factor: what lies beyond Phi and the nuisances tells it,
//! and of that what mirror images have in common.
//! Generalised least squares would have smaller errors if C were known; it is learnt from as many images as it has
//! elements to the power of a half, and took its own word (docs/decisions/inference.md).

use super::learnt::{Learnt, in_common};
use faer::linalg::solvers::{DenseSolveCore as _, Llt};
use faer::{Mat, Side};

/// Elements for each direction, at least.
const LEAST_ELEMENTS: usize = 10;

/// Frames as they were seen.
#[derive(Debug, Clone, PartialEq)]
pub struct Seen {
    /// Logarithms of light; none where an element cannot be used.
    pub values: Vec<Option<f64>>,
    /// Their variances by the camera.
    pub variances: Vec<f64>,
}

/// What they say of the scores, and what else was measured.
#[derive(Debug, Clone, PartialEq)]
pub struct Told {
    /// Which of the numbers that follow the unknowns these are.
    pub places: Vec<usize>,
    /// The scores, and numbers beside them.
    pub scores: Vec<f64>,
    /// Their covariance.
    pub covariance: Mat<f64>,
    /// Whether there are numbers beside the scores.
    pub has_more: bool,
    /// Variance of the light's noise over that of the training images.
    pub noise_factor: f64,
}

impl Told {
    /// A number beside the scores, which nothing else that was measured shares an error with.
    #[must_use]
    pub fn and(mut self, place: usize, value: f64, variance: f64) -> Self {
        let k = self.scores.len();
        let own = |i: usize, j: usize| if i == j { variance } else { 0.0 };
        self.covariance =
            Mat::from_fn(k + 1, k + 1, |i, j| if i.max(j) < k { self.covariance[(i, j)] } else { own(i, j) });
        self.places.push(place);
        self.scores.push(value);
        self.has_more = true;
        self
    }
}

impl Learnt {
    /// Scores of seen frames; none where too few elements can be used.
    pub fn told(&self, seen: &Seen) -> Option<Told> {
        let used = self.used(seen);
        if used.len() < LEAST_ELEMENTS * (self.directions.len() + self.nuisances.len()) {
            return None;
        }
        let n = used.len();
        let columns = |of: &[Vec<f64>]| Mat::from_fn(n, of.len(), |k, j| of[j][used[k]]);
        let values = Mat::from_fn(n, 1, |k, _| self.value(seen, used[k]));
        let camera: Vec<f64> = used.iter().map(|&i| seen.variances[i] * self.weights[i].powi(2)).collect();
        let (directions, noise) = (columns(&self.directions), columns(&self.noise));
        let changes: Vec<Vec<f64>> = self.nuisances.iter().map(|nuisance| nuisance.change.clone()).collect();
        let nuisances = columns(&changes);
        // Beyond what follows the unknowns, and the nuisances.
        let both =
            Mat::from_fn(n, directions.ncols() + nuisances.ncols(), |k, j| match j.checked_sub(directions.ncols()) {
                None => directions[(k, j)],
                Some(j) => nuisances[(k, j)],
            });
        let fit = left_inverse(&both)?;
        let alike: Vec<usize> = used.iter().map(|&i| self.alike[i]).collect();
        let beyond = |of: &Mat<f64>| -> f64 {
            let left = of - &both * (&fit * of);
            let column = |j: usize| in_common(&(0..n).map(|k| left[(k, j)]).collect::<Vec<_>>(), &alike);
            (0..of.ncols()).flat_map(column).map(|v| v * v).sum()
        };
        let share = 1.0 - both.ncols() as f64 / n as f64;
        // The mean of so many variances, over as many again: the variance of a mean.
        let count = |kind: &usize| alike.iter().filter(|one| *one == kind).count() as f64;
        let of_camera = share * camera.iter().zip(&alike).map(|(variance, kind)| variance / count(kind)).sum::<f64>();
        let of_light = beyond(&noise) + share * self.rest_alike * n as f64;
        let noise_factor = ((beyond(&values) - of_camera) / of_light).max(0.0);
        let fit = left_inverse(&directions)?;
        let through = |of: &Mat<f64>| {
            let one = &fit * of;
            &one * one.transpose()
        };
        let of_camera = Mat::from_fn(directions.ncols(), n, |j, k| fit[(j, k)] * camera[k].sqrt());
        let places: Vec<usize> = (0..directions.ncols()).collect();
        // What is as strong in all directions across the scores.
        let rest = &fit * fit.transpose() - Mat::<f64>::identity(places.len(), places.len());
        let of_light = self.scored.noise(&places) + through(&noise) + rest * faer::Scale(self.rest);
        let covariance =
            &of_camera * of_camera.transpose() + of_light * faer::Scale(noise_factor) + through(&nuisances);
        let scores = &fit * &values;
        let scores: Vec<f64> = (0..scores.nrows()).map(|k| scores[(k, 0)]).collect();
        Some(Told { places, scores, covariance, has_more: false, noise_factor })
    }

    /// How far each nuisance is off, in its standard deviations, where the scores are these.
    pub fn off(&self, seen: &Seen, scores: &[f64]) -> Option<Vec<f64>> {
        let used = self.used(seen);
        let left = |i: usize| {
            let told: f64 = self.directions.iter().zip(scores).map(|(direction, score)| direction[i] * score).sum();
            self.value(seen, i) - told
        };
        let left = Mat::from_fn(used.len(), 1, |k, _| left(used[k]));
        let changes = Mat::from_fn(used.len(), self.nuisances.len(), |k, j| self.nuisances[j].change[used[k]]);
        let off = left_inverse(&changes)? * left;
        Some((0..off.nrows()).map(|j| off[(j, 0)]).collect())
    }

    /// Elements that can be used.
    fn used(&self, seen: &Seen) -> Vec<usize> {
        (0..self.mean.len()).filter(|&i| seen.values.get(i).is_some_and(Option::is_some)).collect()
    }

    /// An element, weighted, less its mean.
    fn value(&self, seen: &Seen, i: usize) -> f64 {
        seen.values.get(i).copied().flatten().unwrap_or_default() * self.weights[i] - self.mean[i]
    }
}

/// (A' A)^-1 A'.
fn left_inverse(of: &Mat<f64>) -> Option<Mat<f64>> {
    let normal = of.transpose() * of;
    let factor = Llt::new(normal.as_ref(), Side::Lower).ok()?;
    Some(factor.inverse() * of.transpose())
}
