//! Agreement and coverage: how far estimates lie from the truth, and what their intervals are worth.
//!
//! | Question | Answered by |
//! |---|---|
//! | How far off are the estimates? | [`Errors`], [`BlandAltman`] |
//! | What do repeated readings say together? | [`Mean`] |
//! | How often do the intervals hold the truth? | [`clopper_pearson`] |
//! | Is a posterior as wide as it should be? | [`RankHistogram`] |
//! | By what factor must intervals be widened? | [`conformal_factor`] |
//! | Do repeats and readers agree? | [`intraclass_correlation`], [`Repeatability`] |
//! | From which size on is an inclusion seen? | [`DetectionRate`] |
//! | What is the interval of any other statistic? | [`Bootstrap`] |
//!
//! An answer with an interval is a [`Value`](crate::estimate::Value), undefined with the reason where the data cannot
//! tell. What is wrong with the data is a [`StatisticsError`].

mod agreement;
mod bland_altman;
mod bootstrap;
mod conformal;
mod coverage;
mod detection;
mod distributions;
mod errors;
mod mean;
mod penalised;
mod random;
mod ranks;

pub use agreement::{Repeatability, intraclass_correlation};
pub use bland_altman::BlandAltman;
pub use bootstrap::Bootstrap;
pub use conformal::conformal_factor;
pub use coverage::clopper_pearson;
pub use detection::{DetectionRate, Trial};
pub use errors::Errors;
pub use mean::Mean;
pub use ranks::RankHistogram;

/// A true value and its estimate, in one unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pair {
    /// What is.
    pub truth: f64,
    /// What was found.
    pub estimate: f64,
}

/// Data that no statistic can be made of.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum StatisticsError {
    /// Too little of something.
    #[error("{given} {what} given: give {needed} or more")]
    TooFew {
        /// What there is too little of.
        what: &'static str,
        /// How many there are.
        given: usize,
        /// How many there must be.
        needed: usize,
    },
    /// A number that is infinite or none; its place in the order of the data.
    #[error("number {0} (from 0) is not finite: leave it out")]
    NotFinite(usize),
    /// Numbers too large or too small to be reckoned with.
    #[error("the arithmetic overflows: give the numbers in another unit")]
    Overflow,
    /// A level, or a share, that is none.
    #[error("{0} is not between 0 and 1: give 0.95 for 95 %")]
    Level(f64),
    /// Counts or a table that cannot be: what is wrong and what would be right.
    #[error("{0}")]
    Impossible(String),
    /// A fit that does not converge.
    #[error("the fit does not converge: leave out covariates that lie far from all others")]
    NoFit,
}

/// All numbers are finite.
fn check_finite(numbers: impl IntoIterator<Item = f64>) -> Result<(), StatisticsError> {
    let at = numbers.into_iter().position(|number| !number.is_finite());
    at.map_or(Ok(()), |index| Err(StatisticsError::NotFinite(index)))
}

/// There are as many as are needed.
fn check_count(what: &'static str, given: usize, needed: usize) -> Result<(), StatisticsError> {
    if given < needed { Err(StatisticsError::TooFew { what, given, needed }) } else { Ok(()) }
}

/// A level is between 0 and 1, exclusive.
fn check_level(level: f64) -> Result<(), StatisticsError> {
    if level > 0.0 && level < 1.0 { Ok(()) } else { Err(StatisticsError::Level(level)) }
}

/// A known value and the ends of its interval.
#[cfg(test)]
fn numbers(value: &crate::estimate::Value) -> [f64; 3] {
    let crate::estimate::Value::Known { value, low, high } = value else { panic!("{value:?}") };
    [*value, *low, *high]
}
