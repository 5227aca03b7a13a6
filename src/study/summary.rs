//! What trials say of an estimator.
//!
//! A phantom counts once, by its first exposure; further ones tell how well estimates repeat.

use super::StudyError;
use super::trial::{RANKED, Trial};
use crate::calibrate::Inclusion;
use crate::estimate::{Detected, Estimates, Value};
use crate::statistics::{
    BlandAltman, Bootstrap, DetectionRate, Errors, Pair, RankHistogram, Repeatability, StatisticsError,
    Trial as DetectionTrial, clopper_pearson, conformal_factor, intraclass_correlation,
};
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};

/// Level of intervals.
const LEVEL: f64 = 0.95;
/// Bins of ranks.
const BINS: usize = 10;
/// Bound, a share of the truth, below which a quantity can be told.
const TOLD: f64 = 0.2;

/// What trials say of an estimator.
#[derive(Debug, Clone, Serialize)]
pub struct Summary {
    /// Phantoms with an inclusion.
    pub phantoms: usize,
    /// Share of these in which it is found, of those of which that is told.
    pub found: Value,
    /// The smallest diameter, mm, of which 95 % are found.
    pub smallest_mm: Value,
    /// The same by thirds of the depth.
    pub smallest_by_depth: Vec<Smallest>,
    /// Phantoms without an inclusion.
    pub empty: usize,
    /// Share of these in which one is found all the same, of those of which that is told.
    pub false_alarms: Value,
    /// Phantoms of both kinds of which it is not told whether there is one.
    pub undecided: usize,
    /// Size (mm), depth (mm) and modulus (kPa).
    pub quantities: Vec<Quantity>,
    /// All unknowns of the calibration that the phantoms' sweep has variables of.
    pub unknowns: Vec<UnknownSummary>,
}

/// How well an unknown of the calibration is inferred.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct UnknownSummary {
    /// Its name.
    pub name: String,
    /// Phantoms of which it is known.
    pub known: usize,
    /// Of how many of these the interval holds the truth.
    pub held: usize,
    /// The share.
    pub share: Value,
    /// Median of |estimate / truth - 1|, of truths that are not 0.
    pub median_error: Option<f64>,
    /// Median of half an interval's width over the truth's size, of truths that are not 0.
    pub median_half_width: Option<f64>,
}

/// The smallest diameter that is found of some phantoms.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Smallest {
    /// Which.
    pub name: String,
    /// Of how many it is told whether there is an inclusion.
    pub told: usize,
    /// The diameter, mm, of which 95 % are found.
    pub smallest_mm: Value,
}

/// How well one quantity is estimated.
#[derive(Debug, Clone, Serialize)]
pub struct Quantity {
    /// `size_mm`, `depth_mm` or `youngs_kpa`.
    pub name: &'static str,
    /// Phantoms of which it is known.
    pub known: usize,
    /// Why it is not known of the others, the most frequent reason first.
    pub reasons: Vec<Reason>,
    /// Errors, where known.
    pub errors: Option<Errors>,
    /// Mean of estimate / truth - 1, with its interval.
    pub relative_bias: Value,
    /// Median of |estimate / truth - 1|, with its interval.
    pub median_error: Value,
    /// Median of half an interval's width over the truth.
    pub median_half_width: Option<f64>,
    /// Median of the bound of a phantom's frames, a share of the truth, where the quantity is known.
    pub median_bound: Option<f64>,
    /// Of how many of the known the bound is below 20 %.
    pub bounded: usize,
    /// Root mean square of these errors, each over its own bound, with its interval; 1 is the least that unbiased
    /// estimates reach.
    pub error_over_bound: Value,
    /// Share of intervals of 95 % that hold the truth, of all and of parts.
    pub coverage: Vec<Group>,
    /// Ranks of the truth among draws of the posterior, of all phantoms whose frames could be inverted.
    pub ranks: Told<RankHistogram>,
    /// Limits of agreement of estimate and truth.
    pub agreement: Told<BlandAltman>,
    /// Factor by which intervals would have to be widened about their best value to hold 95 % of these truths.
    pub conformal_factor: Told<f64>,
    /// Agreement of exposures of one phantom, ICC(A,1).
    pub repeats: Value,
    /// Spread of exposures of one phantom.
    pub repeatability: Told<Repeatability>,
}

/// A reason, and how often it was given.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Reason {
    /// The reason, without its numbers.
    pub why: String,
    /// Phantoms.
    pub phantoms: usize,
}

/// Intervals of some phantoms.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Group {
    /// Which.
    pub name: String,
    /// Of how many the quantity is known.
    pub known: usize,
    /// Of how many the interval holds the truth.
    pub held: usize,
    /// The share.
    pub share: Value,
}

/// A statistic, or why there is none.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Told<T> {
    /// The statistic.
    Known(T),
    /// None.
    Undefined {
        /// Why.
        undefined: String,
    },
}

impl<T> From<Result<T, StatisticsError>> for Told<T> {
    fn from(result: Result<T, StatisticsError>) -> Self {
        match result {
            Ok(known) => Self::Known(known),
            Err(error) => Self::Undefined { undefined: error.to_string() },
        }
    }
}

/// A quantity's name, truth and estimate.
type Picked = (&'static str, fn(&Inclusion) -> f64, fn(&Estimates) -> &Value);

const PICKED: [Picked; 3] = [
    ("size_mm", |truth| truth.size_mm, |told| &told.size_mm),
    ("depth_mm", |truth| truth.depth_mm, |told| &told.depth_mm),
    ("youngs_kpa", |truth| truth.youngs_kpa, |told| &told.youngs_kpa),
];

/// A phantom of which a quantity is known.
#[derive(Clone, Copy)]
struct Known<'a> {
    trial: &'a Trial,
    inclusion: &'a Inclusion,
    truth: f64,
    value: f64,
    low: f64,
    high: f64,
}

impl Known<'_> {
    fn holds(&self) -> bool {
        (self.low..=self.high).contains(&self.truth)
    }

    fn off(&self) -> f64 {
        self.value / self.truth - 1.0
    }
}

impl Summary {
    /// Of trials of phantoms with an inclusion, and without.
    ///
    /// # Errors
    /// Numbers that no statistic can be made of.
    pub fn of(phantoms: &[Trial], empty: &[Trial]) -> Result<Self, StudyError> {
        let first =
            |trials: &[Trial]| -> Vec<Trial> { trials.iter().filter(|trial| trial.exposure == 0).cloned().collect() };
        let found = |trial: &Trial| match trial.estimates.detected {
            Detected::Known(found) => Some(found),
            Detected::Undefined { .. } => None,
        };
        let (with, without) = (first(phantoms), first(empty));
        let share = |trials: &[Trial]| {
            let told: Vec<bool> = trials.iter().filter_map(found).collect();
            clopper_pearson(told.iter().filter(|found| **found).count(), told.len(), LEVEL)
        };
        let undecided = with.iter().chain(&without).filter(|trial| found(trial).is_none()).count();
        let tried: Vec<(f64, DetectionTrial)> = with
            .iter()
            .filter_map(|trial| {
                let (truth, is_detected) = (trial.truth?, found(trial)?);
                Some((truth.depth_mm, DetectionTrial { covariate: truth.size_mm, is_detected }))
            })
            .collect();
        let smallest = |tried: &[(f64, DetectionTrial)]| {
            let rate = DetectionRate::of(&tried.iter().map(|(_, trial)| *trial).collect::<Vec<_>>());
            rate.map_or_else(|error| Value::undefined(error.to_string()), |rate| rate.smallest)
        };
        let smallest_mm = smallest(&tried);
        let by_depth = thirds(tried, |(depth_mm, _)| Some(*depth_mm)).into_iter().map(|([low, high], third)| {
            let name = format!("depth {low:.1} to {high:.1} mm");
            Smallest { name, told: third.len(), smallest_mm: smallest(&third) }
        });
        Ok(Self {
            phantoms: with.len(),
            found: share(&with)?,
            smallest_mm,
            smallest_by_depth: by_depth.collect(),
            empty: without.len(),
            false_alarms: share(&without)?,
            undecided,
            quantities: (0..3).map(|k| quantity(k, &with, phantoms)).collect::<Result<_, _>>()?,
            unknowns: unknowns(&with)?,
        })
    }
}

/// All unknowns of the calibration, of phantoms that have an inclusion.
fn unknowns(first: &[Trial]) -> Result<Vec<UnknownSummary>, StatisticsError> {
    let names: BTreeSet<&str> = first.iter().flat_map(|trial| &trial.others).map(|other| other.name.as_str()).collect();
    let of = |name: &str| {
        let others = first.iter().flat_map(|trial| &trial.others).filter(|other| other.name == name);
        let told: Vec<[f64; 4]> = others
            .filter_map(|other| match other.value {
                Value::Known { value, low, high } => Some([other.truth, value, low, high]),
                Value::Undefined { .. } => None,
            })
            .collect();
        let held = told.iter().filter(|[truth, _, low, high]| (low..=high).contains(&truth)).count();
        let share = |of: &dyn Fn(&[f64; 4]) -> f64| median(told.iter().filter(|one| one[0] != 0.0).map(of).collect());
        Ok(UnknownSummary {
            name: name.to_owned(),
            known: told.len(),
            held,
            share: clopper_pearson(held, told.len(), LEVEL)?,
            median_error: share(&|[truth, value, ..]| (value - truth).abs() / truth.abs()),
            median_half_width: share(&|[truth, _, low, high]| 0.5 * (high - low) / truth.abs()),
        })
    };
    names.into_iter().map(of).collect()
}

/// One quantity, by the first exposures and by all.
fn quantity(k: usize, first: &[Trial], all: &[Trial]) -> Result<Quantity, StatisticsError> {
    let (name, truth_of, told_of) = PICKED[k];
    let known_of = |trial| known_of(trial, truth_of, told_of);
    let known: Vec<Known> = first.iter().filter_map(known_of).collect();
    let mut why: BTreeMap<String, usize> = BTreeMap::new();
    for trial in first {
        if let Value::Undefined { reason } = told_of(&trial.estimates) {
            *why.entry(without_numbers(reason)).or_default() += 1;
        }
    }
    let mut reasons: Vec<Reason> = why.into_iter().map(|(why, phantoms)| Reason { why, phantoms }).collect();
    reasons.sort_by_key(|reason| std::cmp::Reverse(reason.phantoms));
    let pairs: Vec<Pair> = known.iter().map(|one| Pair { truth: one.truth, estimate: one.value }).collect();
    let interval = |count: usize, statistic: &dyn Fn(&[usize]) -> f64| {
        let value = Bootstrap::default().interval(count, statistic);
        value.unwrap_or_else(|error| Value::undefined(error.to_string()))
    };
    let bias = |members: &[usize]| members.iter().map(|&i| known[i].off()).sum::<f64>() / members.len() as f64;
    let error = |members: &[usize]| median(members.iter().map(|&i| known[i].off().abs()).collect()).unwrap_or(f64::NAN);
    let bound = |one: &Known| one.trial.bounds[k];
    // Errors over their bounds.
    let over: Vec<f64> = known
        .iter()
        .filter_map(|one| bound(one).filter(|least| *least < TOLD).map(|least| one.off() / least))
        .collect();
    let root_mean_square =
        |members: &[usize]| (members.iter().map(|&i| over[i].powi(2)).sum::<f64>() / members.len() as f64).sqrt();
    let half_widths = known.iter().map(|one| 0.5 * (one.high - one.low) / one.truth).collect();
    let ranks: Vec<usize> = first.iter().filter_map(|trial| trial.ranks[k]).collect();
    let scores: Vec<f64> = known
        .iter()
        .map(|one| {
            let side = if one.truth > one.value { one.high - one.value } else { one.value - one.low };
            (one.truth - one.value).abs() / side.max(f64::MIN_POSITIVE)
        })
        .collect();
    // Phantoms of which every exposure tells it.
    let mut rows: BTreeMap<usize, Vec<Option<f64>>> = BTreeMap::new();
    for trial in all {
        rows.entry(trial.row).or_default().push(known_of(trial).map(|known| known.value));
    }
    let table: Vec<Vec<f64>> = rows.into_values().filter_map(|row| row.into_iter().collect()).collect();
    Ok(Quantity {
        name,
        known: known.len(),
        reasons,
        errors: Errors::of(&pairs).ok(),
        relative_bias: interval(known.len(), &bias),
        median_error: interval(known.len(), &error),
        median_half_width: median(half_widths),
        median_bound: median(known.iter().filter_map(bound).collect()),
        bounded: over.len(),
        error_over_bound: interval(over.len(), &root_mean_square),
        coverage: coverage(&known)?,
        ranks: RankHistogram::of(&ranks, RANKED, BINS).into(),
        agreement: BlandAltman::of(&pairs).into(),
        conformal_factor: conformal_factor(&scores, 1.0 - LEVEL).into(),
        repeats: intraclass_correlation(&table).unwrap_or_else(|error| Value::undefined(error.to_string())),
        repeatability: Repeatability::of(&table).into(),
    })
}

fn known_of<'a>(
    trial: &'a Trial,
    truth_of: fn(&Inclusion) -> f64,
    told_of: fn(&Estimates) -> &Value,
) -> Option<Known<'a>> {
    let inclusion = trial.truth.as_ref()?;
    match *told_of(&trial.estimates) {
        Value::Known { value, low, high } => {
            Some(Known { trial, inclusion, truth: truth_of(inclusion), value, low, high })
        }
        Value::Undefined { .. } => None,
    }
}

/// A number of a phantom, if it has it.
type OfKnown = fn(&Known) -> Option<f64>;

/// Coverage of all, and by thirds of size, depth and contrast.
fn coverage(known: &[Known]) -> Result<Vec<Group>, StatisticsError> {
    let group = |name: String, members: &[&Known]| -> Result<Group, StatisticsError> {
        let held = members.iter().filter(|one| one.holds()).count();
        Ok(Group { name, known: members.len(), held, share: clopper_pearson(held, members.len(), LEVEL)? })
    };
    let all: Vec<&Known> = known.iter().collect();
    let mut groups = vec![group("all".into(), &all)?];
    let by: [(&str, &str, OfKnown); 3] = [
        ("size", " mm", |one| Some(one.inclusion.size_mm)),
        ("depth", " mm", |one| Some(one.inclusion.depth_mm)),
        ("contrast", "", |one| one.trial.phantom_youngs_kpa.map(|own| one.inclusion.youngs_kpa / own)),
    ];
    for (name, unit, of) in by {
        for ([low, high], third) in thirds(all.clone(), |one| of(one)) {
            groups.push(group(format!("{name} {low:.1} to {high:.1}{unit}"), &third)?);
        }
    }
    Ok(groups)
}

/// Those that have a number in thirds of it, each with its ends; none where all have the same one: thirds would then be
/// told apart by the order in which they come.
fn thirds<T>(all: Vec<T>, of: impl Fn(&T) -> Option<f64>) -> Vec<([f64; 2], Vec<T>)> {
    let mut sorted: Vec<(f64, T)> = all.into_iter().filter_map(|one| Some((of(&one)?, one))).collect();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
    if sorted.first().map(|one| one.0) == sorted.last().map(|one| one.0) {
        return Vec::new();
    }
    let (n, mut rest) = (sorted.len(), sorted.into_iter());
    let third = |k: usize| -> Option<([f64; 2], Vec<T>)> {
        let (numbers, members): (Vec<f64>, Vec<T>) = rest.by_ref().take((k + 1) * n / 3 - k * n / 3).unzip();
        Some(([*numbers.first()?, *numbers.last()?], members))
    };
    (0..3).filter_map(third).collect()
}

/// A reason up to its first number, so that alike ones count together; whole where that leaves nothing.
fn without_numbers(reason: &str) -> String {
    let Some(at) = reason.find(|c: char| c.is_ascii_digit()) else { return reason.to_owned() };
    let text = &reason[..at];
    let text = text.rsplit_once([':', '(']).map_or(text, |(before, _)| before).trim().trim_end_matches(',');
    if text.is_empty() { reason.to_owned() } else { text.to_owned() }
}

fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let n = values.len();
    (n > 0).then(|| 0.5 * (values[(n - 1) / 2] + values[n / 2]))
}

#[cfg(test)]
#[path = "summary_tests.rs"]
mod tests;
