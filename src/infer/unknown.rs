//! Unknowns: what is inferred, or integrated away, with what is known of it beforehand.

use faer::Mat;
use serde::{Deserialize, Serialize};

/// An unknown.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Unknown {
    /// Its name.
    pub name: String,
    /// What is known of it beforehand.
    pub prior: Prior,
    /// By what frames are learnt to follow it.
    pub followed: Followed,
}

/// By what numbers are learnt to follow an unknown: by that of which they are as even a function as can be.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Followed {
    /// Its coordinate, in which it is sought.
    Coordinate,
    /// Itself.
    Value,
    /// Its logarithm.
    Logarithm,
    /// The modulus E of a sphere by (E - M) / (E + 3 M / 2), M that of the matrix around it: how much more than the
    /// matrix it resists, both incompressible (Eshelby, Proc. R. Soc. A 241, 1957).
    Contrast {
        /// The unknown that is the matrix's modulus.
        matrix: usize,
    },
}

/// The value of an unknown at a place; not a number where there is none.
fn value(unknowns: &[Unknown], place: &[f64], k: usize) -> f64 {
    unknowns.get(k).zip(place.get(k)).map_or(f64::NAN, |(one, x)| one.prior.value(*x))
}

/// What numbers follow at a place.
pub(super) fn followed(unknowns: &[Unknown], place: &[f64]) -> Vec<f64> {
    let value = |k: usize| value(unknowns, place, k);
    let one = |(k, (unknown, x)): (usize, (&Unknown, &f64))| match unknown.followed {
        Followed::Coordinate => *x,
        Followed::Value => value(k),
        Followed::Logarithm => value(k).ln(),
        Followed::Contrast { matrix } => {
            let (own, matrix) = (value(k), value(matrix));
            (own - matrix) / (own + 1.5 * matrix)
        }
    };
    unknowns.iter().zip(place).enumerate().map(one).collect()
}

/// Slopes of these along the coordinates: a row for each of them.
pub(super) fn slopes(unknowns: &[Unknown], place: &[f64]) -> Mat<f64> {
    let value = |k: usize| value(unknowns, place, k);
    // Of a value along its coordinate.
    let along = |k: usize| match unknowns.get(k).map(|one| one.prior) {
        Some(Prior::LogUniform { .. }) => value(k),
        _ => 1.0,
    };
    Mat::from_fn(unknowns.len(), unknowns.len(), |i, j| match unknowns[i].followed {
        Followed::Contrast { matrix } if j == i || j == matrix => {
            let (own, other) = (value(i), value(matrix));
            let slope = 2.5 / (own + 1.5 * other).powi(2);
            if j == i { slope * other * along(i) } else { -slope * own * along(matrix) }
        }
        _ if i != j => 0.0,
        Followed::Value => along(i),
        Followed::Logarithm => along(i) / value(i),
        Followed::Coordinate | Followed::Contrast { .. } => 1.0,
    })
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

impl Unknown {
    /// Whether it makes sense among so many.
    pub fn is_whole(&self, unknowns: usize) -> bool {
        let known = |matrix: usize| matrix < unknowns;
        self.prior.is_whole() && !matches!(self.followed, Followed::Contrast { matrix } if !known(matrix))
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slopes_are_those_of_what_is_followed() {
        let one = |prior, followed| Unknown { name: String::new(), prior, followed };
        let log = Prior::LogUniform { low: 2.0, high: 200.0 };
        let even = Prior::Uniform { low: 2.0, high: 12.0 };
        let unknowns = [
            one(log, Followed::Contrast { matrix: 4 }),
            one(log, Followed::Value),
            one(even, Followed::Logarithm),
            one(even, Followed::Coordinate),
            one(log, Followed::Logarithm),
            one(even, Followed::Contrast { matrix: 0 }),
        ];
        let place = [3.0, 2.0, 5.0, 7.0, 1.5, 6.0];
        let at = |j: usize, step: f64| {
            let place: Vec<f64> = place.iter().enumerate().map(|(k, x)| if k == j { x + step } else { *x }).collect();
            followed(&unknowns, &place)
        };
        let found = slopes(&unknowns, &place);
        for j in 0..place.len() {
            let (low, high) = (at(j, -1e-5), at(j, 1e-5));
            for i in 0..place.len() {
                let slope = (high[i] - low[i]) / 2e-5;
                assert!((found[(i, j)] - slope).abs() < 1e-8 * (1.0 + slope.abs()), "{i} {j}: {slope}");
            }
        }
        // A sphere like its matrix is none; one that is rigid resists as much as can be.
        let contrast = |own: f64, matrix: f64| followed(&unknowns, &[own.ln(), 2.0, 5.0, 7.0, matrix.ln(), 6.0])[0];
        assert!(contrast(5.0, 5.0).abs() < 1e-12 && (contrast(1e9, 5.0) - 1.0).abs() < 1e-7);
    }
}
