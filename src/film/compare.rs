//! Do two films show the same light? A test over pixels, blocks of 4, 16 and 64 pixels, and the whole image.
//!
//! A fault of 1 % is invisible in one noisy pixel and plain in a block, so each level is tested. At each level every
//! cell's difference is divided by its standard error and judged by Student's t (Welch's degrees of freedom from
//! the replicates behind both films); the largest deviate and the sum of squares are the level's two tests.
//! Sidak's correction keeps the chance of any false alarm at the stated level.
//!
//! - A cell with fewer than [`MIN_CONTRIBUTIONS`] contributions in either film is not tested by itself; its light
//!   counts in the larger blocks, at last in the whole image, which is always tested. N equal contributions leave a
//!   relative standard error of 1/sqrt(N), so the variance per radiance is the weight of one; it is taken from the
//!   cell's neighbourhood, for a choice by the cell's own variance would keep the cells that underestimate it (with
//!   120 contributions a pixel that raised the mean square of the deviates to 1.15).
//! - A cell that is dark in both films agrees and is not counted. One that is dark in one film gets the variance its
//!   expected light would have had there, by the same weight.
//! - The standard error has a floor, [`ROUNDING`] of the radiance: two f32 tracers differ by that much without noise.
//! - Neighbours may be correlated: the largest deviate stays conservative then, and the sum of squares is scaled to a
//!   chi-square of the effective number of cells (Satterthwaite 1946), from the inflation of larger blocks.

mod cells;

use super::blocks::{BlockLevel, EDGES};
use super::{Film, tails};
use cells::{Cells, ratio, test_cell};
use serde::Serialize;
use std::borrow::Cow;
use thiserror::Error;

/// Contributions of light a cell needs in each film to be tested by itself.
pub const MIN_CONTRIBUTIONS: f64 = 100.0;

/// Relative rounding of a radiance computed in f32: a path multiplies some tens of factors, each off by up to an ulp
/// of 2^-23.
pub const ROUNDING: f64 = 1.0 / 262_144.0;

/// How far the mean square of the deviates may exceed 1 before it counts. Welch's approximation, skewed light and the
/// choice of cells shift it by up to 0.01 (115,200 pixels of 16 replicates, normal and Poisson of 100 to 320
/// contributions: 0.985 to 1.005), and so many pixels would see 0.02.
const SQUARES_SLACK: f64 = 1.03;

/// Why two films cannot be compared.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum CompareError {
    /// Their sizes differ.
    #[error("the first is {}x{} pixels, the second {}x{}", .first[0], .first[1], .second[0], .second[1])]
    Size {
        /// Columns and rows of the first film.
        first: [u32; 2],
        /// Columns and rows of the second film.
        second: [u32; 2],
    },
    /// Without two replicates a film has no variance.
    #[error("the {film} film has one replicate and so no variance; render at least two")]
    OneReplicate {
        /// Which: `first` or `second`.
        film: &'static str,
    },
    /// A value that no film can have.
    #[error("the {film} film has the {what} {value} at cell {index}; it must be {right}")]
    Value {
        /// Which: `first` or `second`.
        film: &'static str,
        /// `mean` or `variance`.
        what: &'static str,
        /// The value.
        value: f32,
        /// Its place, row-major.
        index: usize,
        /// What would be right.
        right: &'static str,
    },
    /// Its arrays do not fit its size.
    #[error("the {film} film's arrays do not fit its size")]
    Shape {
        /// Which: `first` or `second`.
        film: &'static str,
    },
    /// The level is no probability.
    #[error("the level {0} must lie between 0 and 1")]
    Level(f64),
}

/// What the comparison found.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Comparison {
    /// Whether every level agrees.
    pub passed: bool,
    /// Chance of a false alarm, all tests together.
    pub level: f64,
    /// One entry per level, from pixels to the whole image.
    pub tests: Vec<LevelTest>,
    /// Mean radiance of the first film, W/(m^2 sr).
    pub mean_a: f64,
    /// Mean radiance of the second film, W/(m^2 sr).
    pub mean_b: f64,
    /// Second mean over first; none where the first is dark.
    pub ratio: Option<Ratio>,
}

/// A ratio of two means and its 95 % interval.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Ratio {
    /// The ratio.
    pub value: f64,
    /// Lower end of the interval.
    pub low: f64,
    /// Upper end of the interval.
    pub high: f64,
}

/// The test of one level.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LevelTest {
    /// Edge of a cell, pixels; 1: pixels, 0: the whole image.
    pub edge: u32,
    /// Cells with light enough to be tested.
    pub cells: usize,
    /// Largest deviate, as the normal one of the same probability.
    pub max_z: f64,
    /// Sum of squared deviates over the effective number of cells' share.
    pub chi2: f64,
    /// Degrees of freedom of `chi2`: the effective number of cells.
    pub dof: f64,
    /// Chance of a worse level by noise alone.
    pub p_value: f64,
    /// Whether that chance is above the level's share of the family-wise level.
    pub passed: bool,
}

/// Compares two films at a family-wise `level` (chance of a false alarm, over all tests together).
///
/// # Errors
/// When sizes differ, a film has no variance or holds impossible values, or `level` is no probability.
pub fn compare(a: &Film, b: &Film, level: f64) -> Result<Comparison, CompareError> {
    if !(level > 0.0 && level < 1.0) {
        return Err(CompareError::Level(level));
    }
    if (a.width, a.height) != (b.width, b.height) {
        let [first, second] = [a, b].map(|film| [film.width, film.height]);
        return Err(CompareError::Size { first, second });
    }
    let (a, b) = (Side::new(a, "first")?, Side::new(b, "second")?);
    let mut tests = Vec::new();
    for edge in std::iter::once(1).chain(EDGES) {
        tests.push(test_level(a.cells(edge)?, b.cells(edge)?, edge, correlation(&a, &b, edge)));
    }
    let tested = tests.iter().filter(|test| test.cells > 0).count().max(1);
    let share = tails::sidak(level, 1.0 / tested as f64);
    for test in &mut tests {
        test.passed = test.p_value >= share;
    }
    let (whole_a, whole_b) = (a.cells(0)?.first(), b.cells(0)?.first());
    Ok(Comparison {
        passed: tests.iter().all(|test| test.passed),
        level,
        tests,
        mean_a: whole_a.mean,
        mean_b: whole_b.mean,
        ratio: ratio(whole_a, whole_b),
    })
}

/// A checked film that has blocks.
struct Side<'a> {
    film: Cow<'a, Film>,
    name: &'static str,
    inflation: Vec<super::Inflation>,
}

impl<'a> Side<'a> {
    fn new(film: &'a Film, name: &'static str) -> Result<Self, CompareError> {
        if film.replicates == 1 {
            return Err(CompareError::OneReplicate { film: name });
        }
        let pixels = film.width as usize * film.height as usize;
        if film.mean.len() != pixels || film.variance.len() != pixels {
            return Err(CompareError::Shape { film: name });
        }
        check(&film.mean, &film.variance, name)?;
        let film = match film.blocks.is_empty() {
            true => Cow::Owned(film.clone().with_blocks(&[])),
            false => Cow::Borrowed(film),
        };
        for block in &film.blocks {
            check(&block.mean, &block.variance, name)?;
        }
        let inflation = film.inflation();
        Ok(Self { film, name, inflation })
    }

    fn cells(&self, edge: u32) -> Result<Cells<'_>, CompareError> {
        let freedom = match self.film.replicates {
            0 => f64::INFINITY,
            replicates => f64::from(replicates) - 1.0,
        };
        let (mean, variance) = match edge {
            1 => (&self.film.mean, &self.film.variance),
            edge => {
                let fits = |block: &&BlockLevel| {
                    block.edge == edge
                        && block.mean.len() == super::blocks::cells(self.film.width, self.film.height, edge)
                };
                let block = self.film.blocks.iter().find(fits);
                let block = block.ok_or(CompareError::Shape { film: self.name })?;
                (&block.mean, &block.variance)
            }
        };
        let columns = match edge {
            0 => 1,
            edge => self.film.width.div_ceil(edge),
        };
        Ok(Cells { columns, mean, variance, freedom })
    }

    fn factor(&self, edge: u32) -> f64 {
        let given = self.inflation.iter().find(|entry| entry.edge == edge);
        given.map_or(1.0, |entry| entry.factor)
    }
}

fn check(means: &[f32], variances: &[f32], film: &'static str) -> Result<(), CompareError> {
    let fault = |what, right, found: Option<(usize, &f32)>| match found {
        Some((index, &value)) => Err(CompareError::Value { film, what, value, index, right }),
        None => Ok(()),
    };
    if means.len() != variances.len() {
        return Err(CompareError::Shape { film });
    }
    let wrong_mean = means.iter().enumerate().find(|(_, mean)| !mean.is_finite());
    fault("mean", "finite", wrong_mean)?;
    let wrong = |variance: &f32| !(variance.is_finite() && *variance >= 0.0);
    fault("variance", "finite and not negative", variances.iter().enumerate().find(|(_, v)| wrong(v)))
}

/// How many cells of this level vary together, the larger of both films.
fn correlation(a: &Side, b: &Side, edge: u32) -> f64 {
    let larger = EDGES.iter().filter(|&&other| edge != 0 && (other == 0 || other > edge));
    let ratio = |side: &Side, other: u32| side.factor(other) / side.factor(edge);
    larger.map(|&other| ratio(a, other).max(ratio(b, other))).fold(1.0, f64::max)
}

fn test_level(a: Cells, b: Cells, edge: u32, correlation: f64) -> LevelTest {
    let weights = a.weights().into_iter().zip(b.weights());
    let (mut cells, mut squares, mut smallest) = (0_usize, 0.0, 1.0_f64);
    for ((a, b), (weight_a, weight_b)) in a.iter().zip(b.iter()).zip(weights) {
        let weights = [weight_a.or(weight_b), weight_b.or(weight_a)].map(|weight| weight.unwrap_or(0.0));
        if let Some(p) = test_cell(a, b, weights, edge == 0) {
            cells += 1;
            squares += tails::normal_deviate(p).powi(2);
            smallest = smallest.min(p);
        }
    }
    let (chi2, dof) = (squares / correlation, cells as f64 / correlation);
    let p_value = match cells {
        0 => 1.0,
        1 => smallest,
        _ => {
            let by_largest = tails::sidak(smallest, cells as f64);
            let by_squares = tails::chi_square(chi2 / SQUARES_SLACK, dof);
            tails::sidak(by_largest.min(by_squares), 2.0)
        }
    };
    let max_z = if cells == 0 { 0.0 } else { tails::normal_deviate(smallest) };
    LevelTest { edge, cells, max_z, chi2, dof, p_value, passed: true }
}

#[cfg(test)]
mod tests;
