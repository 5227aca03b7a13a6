//! Unknowns: what is inferred, or integrated away, with what is known of it beforehand.

use serde::{Deserialize, Serialize};

/// An unknown.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Unknown {
    /// Its name.
    pub name: String,
    /// What is known of it beforehand.
    pub prior: Prior,
}

/// What is known of an unknown beforehand; nothing lies outside its bounds.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Prior {
    /// Even between two numbers.
    Uniform {
        /// The lower.
        low: f64,
        /// The higher.
        high: f64,
    },
    /// Even in the logarithm.
    LogUniform {
        /// The lower, above 0.
        low: f64,
        /// The higher.
        high: f64,
    },
}

impl Prior {
    /// The bounds, in the coordinate.
    pub fn bounds(&self) -> [f64; 2] {
        match *self {
            Self::Uniform { low, high } => [low, high],
            Self::LogUniform { low, high } => [low.ln(), high.ln()],
        }
    }

    /// The coordinate in which the unknown is sought: itself, or its logarithm.
    pub fn coordinate(&self, value: f64) -> f64 {
        match self {
            Self::LogUniform { .. } => value.ln(),
            Self::Uniform { .. } => value,
        }
    }

    /// The unknown of a coordinate.
    pub fn value(&self, coordinate: f64) -> f64 {
        match self {
            Self::LogUniform { .. } => coordinate.exp(),
            Self::Uniform { .. } => coordinate,
        }
    }

    /// What a small change of the coordinate is of the unknown, as a share.
    pub fn relative(&self, value: f64) -> f64 {
        match self {
            Self::LogUniform { .. } => 1.0,
            Self::Uniform { .. } => 1.0 / value.abs(),
        }
    }

    /// Whether a coordinate lies within the bounds, where all are as likely.
    pub fn holds(&self, coordinate: f64) -> bool {
        let [low, high] = self.bounds();
        (low..=high).contains(&coordinate)
    }

    /// Whether its bounds are numbers, and have a width.
    pub fn is_whole(&self) -> bool {
        let [low, high] = self.bounds();
        low.is_finite() && high.is_finite() && low < high
    }
}
