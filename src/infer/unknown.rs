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
    /// Normal between two numbers.
    Normal {
        /// Mean, before it is cut.
        mean: f64,
        /// Standard deviation, before it is cut.
        sd: f64,
        /// The lower bound.
        low: f64,
        /// The higher bound.
        high: f64,
    },
}

impl Prior {
    /// The bounds, in the coordinate.
    pub fn bounds(&self) -> [f64; 2] {
        match *self {
            Self::Uniform { low, high } | Self::Normal { low, high, .. } => [low, high],
            Self::LogUniform { low, high } => [low.ln(), high.ln()],
        }
    }

    /// The coordinate in which the unknown is sought: itself, or its logarithm.
    pub fn coordinate(&self, value: f64) -> f64 {
        match self {
            Self::LogUniform { .. } => value.ln(),
            Self::Uniform { .. } | Self::Normal { .. } => value,
        }
    }

    /// The unknown of a coordinate.
    pub fn value(&self, coordinate: f64) -> f64 {
        match self {
            Self::LogUniform { .. } => coordinate.exp(),
            Self::Uniform { .. } | Self::Normal { .. } => coordinate,
        }
    }

    /// Logarithm of the density in the coordinate, but for a constant; minus infinity beyond the bounds.
    pub fn log_density(&self, coordinate: f64) -> f64 {
        let [low, high] = self.bounds();
        if !(low..=high).contains(&coordinate) {
            return f64::NEG_INFINITY;
        }
        match *self {
            Self::Normal { mean, sd, .. } => -0.5 * ((coordinate - mean) / sd).powi(2),
            Self::Uniform { .. } | Self::LogUniform { .. } => 0.0,
        }
    }
}
