//! How well a calibration reads phantoms that it was not learnt from: each by a calibration that is learnt of others.
//!
//! Of an unknown whose intervals then hold too few, intervals are widened about their best value until they hold their
//! share of these phantoms (split conformal prediction: Lei et al., J. Am. Stat. Assoc. 113, 2018; here by folds, whose
//! calibrations are learnt of fewer phantoms and so a little worse).

use super::estimates::EDGE;
use super::{CalibrateError, FrameModel, Training};
use crate::estimate::Value;
use crate::infer::{FitError, Prior, Seen, Unknown};
use crate::progress::{Observer, Stage};
use crate::statistics::conformal_factor;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Parts of the phantoms, each of which is read by what is learnt of the others.
const FOLDS: usize = 4;
/// What intervals leave out.
const LEVEL: f64 = 0.05;

/// What came of phantoms that were left out, of those that lie apart from the ends of what is learnt.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LeftOut {
    /// Phantoms.
    pub phantoms: usize,
    /// Of how many the frames were refused.
    pub refused: usize,
    /// Each unknown.
    pub unknowns: Vec<Held>,
}

/// Intervals of one unknown.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Held {
    /// Its name.
    pub name: String,
    /// Of how many phantoms it is known.
    pub known: usize,
    /// Of how many of these the interval held the truth, before it was widened.
    pub held: usize,
    /// What intervals are widened by, in the unknown's coordinate; none where too few phantoms tell it.
    pub widened: Option<f64>,
}

/// What of a phantom an interval held: its distance from the truth to the best value, in its half width on that side.
type Scores = Vec<Option<f64>>;

impl LeftOut {
    /// Of phantoms, each fourth left out in turn; none where those that are left are too few to learn from, or where
    /// `observe` says no.
    ///
    /// # Errors
    /// As [`FrameModel::learn`].
    pub(super) fn of(
        design: &Training,
        leds: Option<&Training>,
        empty: Option<&Training>,
        observe: &mut Observer,
    ) -> Result<Option<Self>, CalibrateError> {
        let mut scores: Vec<Option<Scores>> = Vec::new();
        let mut names = Vec::new();
        for fold in 0..FOLDS {
            if !observe(Stage { done: (fold as f64 + 1.0) / (FOLDS as f64 + 1.0), what: "reading phantoms left out" }) {
                return Ok(None);
            }
            let model = match FrameModel::once(&design.only(|k| k % FOLDS != fold), leds, empty) {
                Ok(model) => model,
                Err(CalibrateError::Fit(FitError::Few { .. })) => return Ok(None),
                Err(error) => return Err(error),
            };
            let inner = |k: usize| design.points.get(k).is_some_and(|point| model.is_inner(point));
            let these = design.only(|k| k % FOLDS == fold && inner(k));
            let logs = model.vectors(&these);
            scores.par_extend(logs.par_iter().zip(&these.points).map(|(logs, point)| model.scores_of(logs, point)));
            names = model.unknowns().map(|(unknown, _)| unknown.name.clone()).collect();
        }
        let told: Vec<&Scores> = scores.iter().flatten().collect();
        let held = |(k, name): (usize, String)| {
            let known: Vec<f64> = told.iter().filter_map(|scores| scores.get(k).copied().flatten()).collect();
            Held {
                name,
                known: known.len(),
                held: known.iter().filter(|score| **score <= 1.0).count(),
                widened: conformal_factor(&known, LEVEL).ok().map(|factor| factor.max(1.0)),
            }
        };
        let unknowns = names.into_iter().enumerate().map(held).collect();
        Ok(Some(Self { phantoms: scores.len(), refused: scores.len() - told.len(), unknowns }))
    }

    /// Whether it is of so many unknowns, and makes no interval narrower.
    pub(super) fn is_whole(&self, unknowns: usize) -> bool {
        let widens = |one: &Held| one.widened.is_none_or(|widened| widened >= 1.0 && widened.is_finite());
        self.unknowns.len() == unknowns && self.unknowns.iter().all(widens)
    }

    /// What intervals of an unknown are widened by.
    pub(super) fn widened(&self, unknown: usize) -> f64 {
        self.unknowns.get(unknown).and_then(|one| one.widened).unwrap_or(1.0)
    }
}

impl FrameModel {
    /// Whether no unknown of a point lies so near an end that it would be undefined.
    fn is_inner(&self, point: &[f64]) -> bool {
        let inner = |(x, (unknown, _)): (&f64, (&Unknown, _))| {
            let [low, high] = unknown.prior.bounds();
            (EDGE..=1.0 - EDGE).contains(&((x - low) / (high - low)))
        };
        point.iter().zip(self.unknowns()).all(inner)
    }

    /// Scores of a phantom's unknowns, of frames without a camera's noise; none where the frames are refused.
    fn scores_of(&self, logs: &[f64], point: &[f64]) -> Option<Scores> {
        let seen = Seen { values: logs.iter().copied().map(Some).collect(), variances: vec![0.0; logs.len()] };
        let (_, posterior, _) = self.posterior_of(&seen, Ok).ok()?;
        let score = |(k, (truth, prior)): (usize, (&f64, Prior))| match self.value(&posterior, k) {
            Value::Known { value, low, high } => {
                let [value, low, high] = [value, low, high].map(|value| prior.coordinate(value));
                let side = if *truth > value { high - value } else { value - low };
                Some((truth - value).abs() / side.max(f64::MIN_POSITIVE))
            }
            Value::Undefined { .. } => None,
        };
        let priors = self.unknowns().map(|(unknown, _)| unknown.prior);
        Some(point.iter().zip(priors).enumerate().map(score).collect())
    }
}

/// What is said of it, after how many were learnt from.
pub fn left_out_text(left_out: Option<&LeftOut>) -> String {
    let Some(left_out) = left_out else {
        return "\ntoo few phantoms to leave some out: how often intervals hold is not known".into();
    };
    let held = |one: &Held| match one.widened {
        Some(widened) => format!("{}: {} of {}, widened by {widened:.2}", one.name, one.held, one.known),
        None => format!("{}: {} of {}, too few to tell how often it holds", one.name, one.held, one.known),
    };
    let unknowns: Vec<String> = left_out.unknowns.iter().map(held).collect();
    let head =
        format!("\nof {} phantoms left out {} were refused; intervals held", left_out.phantoms, left_out.refused);
    format!("{head} {}", unknowns.join("; "))
}
