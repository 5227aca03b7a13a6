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
//! - A pixel that a border of light crosses may have all its few samples on one side: its variance is at least what
//!   that leaves open (`cells.rs`).
//! - Neighbours may be correlated: the largest deviate stays conservative then, and the sum of squares is judged by the
//!   chi-square that has its mean, variance and skewness (Hall 1983; Buckley and Eagleson 1988). These follow from how
//!   much the cells of both films move together ([`super::Correlation`]), dim cells counted as bright ones.
//! - Each level says the smallest change it could have seen, and films of the same random numbers are compared
//!   replicate by replicate as well (`paired.rs`).

pub(super) mod cells;
mod error;
mod exact;
mod paired;
mod ratio;

use super::blocks::{BlockLevel, EDGES};
use super::{Correlation, Film, tails};
use crate::figure::Figure;
use cells::{Cells, Tested, ratio, test_cell};
pub use error::CompareError;
pub use exact::{Deviation, Deviations, Tolerance, deviations};
pub use paired::Paired;
use ratio::or_undefined;
pub use ratio::{MIN_CONTRIBUTIONS, ROUNDING, Ratio};
use serde::{Serialize, Serializer};
use std::borrow::Cow;

/// How far the mean square of the deviates may exceed 1 before it counts. Welch's approximation, skewed light and the
/// choice of cells shift it by up to 0.01 (115,200 pixels of 16 replicates, normal and Poisson of 100 to 320
/// contributions: 0.985 to 1.005), and so many pixels would see 0.02.
const SQUARES_SLACK: f64 = 1.03;

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
    #[serde(serialize_with = "or_dark")]
    pub ratio: Option<Ratio>,
    /// The comparison replicate by replicate, where it was asked for and both films know theirs.
    #[serde(serialize_with = "or_not_shared")]
    pub paired: Option<Paired>,
}

fn or_dark<S: Serializer>(ratio: &Option<Ratio>, serializer: S) -> Result<S::Ok, S::Error> {
    Figure::of(*ratio, "the first image is dark").serialize(serializer)
}

fn or_not_shared<S: Serializer>(paired: &Option<Paired>, serializer: S) -> Result<S::Ok, S::Error> {
    Figure::of(*paired, "the images do not share their random numbers, or do not say").serialize(serializer)
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
    /// Mean of the squared deviates: 1 but for noise where the light is the same.
    pub mean_square: f64,
    /// The chi-square of as many standard deviations above its mean as the sum of squared deviates is.
    pub chi2: f64,
    /// Its degrees of freedom, of the skewness of that sum: at most the number of cells.
    pub dof: f64,
    /// Chance of a worse level by noise alone.
    pub p_value: f64,
    /// Whether that chance is above the level's share of the family-wise level.
    pub passed: bool,
    /// The relative brightening of a single cell, of median noise, that would have been called different in 90 of 100
    /// cases; its noise grows with it. None where no cell was tested, or no brightening would be seen.
    #[serde(serialize_with = "or_undefined")]
    pub smallest_change: Option<f64>,
    /// That cell's place, row-major from 0.
    #[serde(serialize_with = "or_undefined")]
    pub median_cell: Option<usize>,
}

/// Compares two films at a family-wise `level` (chance of a false alarm, over all tests together).
///
/// # Errors
/// When sizes differ, a film has no variance or holds impossible values, or `level` is no probability.
pub fn compare(a: &Film, b: &Film, level: f64) -> Result<Comparison, CompareError> {
    judge(a, b, level, None)
}

/// Compares two films of the same random numbers, also replicate by replicate where both know theirs.
///
/// # Errors
/// As of [`compare()`].
pub fn compare_paired(a: &Film, b: &Film, level: f64) -> Result<Comparison, CompareError> {
    judge(a, b, level, Paired::of(&a.parts, &b.parts))
}

fn judge(a: &Film, b: &Film, level: f64, paired: Option<Paired>) -> Result<Comparison, CompareError> {
    if !(level > 0.0 && level < 1.0) {
        return Err(CompareError::Level(level));
    }
    if (a.width, a.height) != (b.width, b.height) {
        let [first, second] = [a, b].map(|film| [film.width, film.height]);
        return Err(CompareError::Size { first, second });
    }
    let (a, b) = (Side::new(a, "first")?, Side::new(b, "second")?);
    let mut levels = Vec::new();
    for edge in std::iter::once(1).chain(EDGES) {
        levels.push(Level::new(&a, &b, edge)?);
    }
    let tested = levels.iter().filter(|level| !level.cells.is_empty()).count() + usize::from(paired.is_some());
    let share = tails::sidak(level, 1.0 / tested.max(1) as f64);
    let tests: Vec<LevelTest> = levels.iter().map(|level| level.test(share)).collect();
    let paired = paired.map(|paired| paired.judged(share));
    let (whole_a, whole_b) = (a.cells(0)?.first(), b.cells(0)?.first());
    Ok(Comparison {
        passed: tests.iter().all(|test| test.passed) && paired.is_none_or(|paired| paired.passed),
        level,
        tests,
        mean_a: whole_a.mean,
        mean_b: whole_b.mean,
        ratio: ratio(whole_a, whole_b),
        paired,
    })
}

/// A checked film that has blocks.
struct Side<'a> {
    film: Cow<'a, Film>,
    name: &'static str,
    /// Samples a pixel, and the least variances that borders of light leave to pixels; none where nothing is known of
    /// them.
    samples: f64,
    borders: Vec<f32>,
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
            true => Cow::Owned(film.clone().with_independent_blocks()),
            false => Cow::Borrowed(film),
        };
        for block in &film.blocks {
            check(&block.mean, &block.variance, name)?;
        }
        let samples = f64::from(film.samples.max(film.replicates));
        let pixels = Cells {
            columns: film.width,
            mean: &film.mean,
            variance: &film.variance,
            freedom: f64::INFINITY,
            least: &[],
        };
        let borders = if samples > 0.0 { pixels.across_borders(samples) } else { Vec::new() };
        Ok(Self { film, name, samples, borders })
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
        Ok(Cells { columns, mean, variance, freedom, least: &[] })
    }

    /// Pixels with the least variance that borders of light leave.
    fn with_borders<'b>(&'b self, cells: Cells<'b>, edge: u32) -> Cells<'b> {
        if edge == 1 { Cells { least: &self.borders, ..cells } } else { cells }
    }

    fn correlation(&self, edge: u32, cells: f64) -> Correlation {
        let given = self.film.correlation.iter().find(|entry| entry.edge == edge).copied();
        given.unwrap_or_else(|| Correlation::independent(edge, cells))
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

/// The tested cells of one level, and how much they move together.
struct Level {
    edge: u32,
    /// Variance that a change of a single cell brings by itself, over its square: it looks like a border.
    border: f64,
    cells: Vec<Tested>,
    correlation: Correlation,
}

impl Level {
    fn new(a: &Side, b: &Side, edge: u32) -> Result<Self, CompareError> {
        let (of_a, of_b) = (a.cells(edge)?, b.cells(edge)?);
        let weights = of_a.weights().into_iter().zip(of_b.weights());
        let (of_a, of_b) = (a.with_borders(of_a, edge), b.with_borders(of_b, edge));
        let border = if edge == 1 && b.samples > 0.0 { cells::border(b.samples) } else { 0.0 };
        let test = |(index, ((a, b), (weight_a, weight_b))): (_, (_, (Option<f64>, Option<f64>)))| {
            let weights = [weight_a.or(weight_b), weight_b.or(weight_a)].map(|weight| weight.unwrap_or(0.0));
            test_cell(index, [a, b], weights, edge == 0)
        };
        let stepped = |cell: Tested| {
            let step = of_b.least.get(cell.index).map_or(0.0, |&least| (f64::from(least) / border).sqrt());
            Tested { step: step / cell.light, ..cell }
        };
        let tested = of_a.iter().zip(of_b.iter()).zip(weights).enumerate().filter_map(test);
        let cells: Vec<Tested> = tested.map(stepped).collect();
        let count = cells.len() as f64;
        let share = cells.iter().map(|cell| cell.share).sum::<f64>() / count.max(1.0);
        let correlation = a.correlation(edge, count).of_difference(b.correlation(edge, count), share).of_cells(count);
        Ok(Self { edge, border, cells, correlation })
    }

    fn test(&self, share: f64) -> LevelTest {
        let count = self.cells.len() as f64;
        let smallest = self.cells.iter().map(|cell| cell.p).fold(1.0, f64::min);
        let squares = self.cells.iter().map(|cell| tails::normal_deviate(cell.p).powi(2)).sum::<f64>();
        let mean_square = if count > 0.0 { squares / count } else { 0.0 };
        let dof = if count > 0.0 { self.degrees_of_freedom() } else { 0.0 };
        let p_value = match self.cells.len() {
            0 => 1.0,
            1 => smallest,
            _ => {
                let by_largest = tails::sidak(smallest, count);
                let by_squares = tails::chi_square(self.chi_square(mean_square / SQUARES_SLACK), dof);
                tails::sidak(by_largest.min(by_squares), 2.0)
            }
        };
        LevelTest {
            edge: self.edge,
            cells: self.cells.len(),
            max_z: if count > 0.0 { tails::normal_deviate(smallest) } else { 0.0 },
            mean_square,
            chi2: if count > 0.0 { self.chi_square(mean_square) } else { 0.0 },
            dof,
            p_value,
            passed: p_value >= share,
            smallest_change: self.smallest_change(share),
            median_cell: self.median().map(|cell| cell.index),
        }
    }

    /// The chi-square of these degrees of freedom has the skewness of the sum of squares: 8 dof / (2 dof)^(3/2) is
    /// 8 tr P^3 / (2 tr P^2)^(3/2).
    fn degrees_of_freedom(&self) -> f64 {
        self.correlation.pairs.powi(3) / self.correlation.triples.powi(2)
    }

    /// Its value as far above its mean, in standard deviations, as the mean square is: that has the variance 2 tr P^2 /
    /// n^2.
    fn chi_square(&self, mean_square: f64) -> f64 {
        let dof = self.degrees_of_freedom();
        dof + (mean_square - 1.0) * (dof / self.correlation.pairs).sqrt()
    }

    /// The tested cell of median noise.
    fn median(&self) -> Option<&Tested> {
        let mut cells: Vec<&Tested> = self.cells.iter().collect();
        cells.sort_by(|a, b| a.relative_error.total_cmp(&b.relative_error));
        cells.get(cells.len() / 2).copied()
    }

    /// By the largest deviate, in the cell of median noise. A cell that is picked by its error has one that is too
    /// small where few paths bring light, so each film's error is that of the cells that the other film picks. Brighter
    /// light is noisier: of the relative variances u and v of both films, d^2 = k^2 (u + (1 + d)^2 v + b (s + d)^2)
    /// with k standard errors and b for the border that it looks like, beside the step s from its neighbours that there
    /// is. None: no change is seen.
    fn smallest_change(&self, share: f64) -> Option<f64> {
        let each = match self.cells.len() {
            0 | 1 => share,
            count => tails::sidak(tails::sidak(share, 0.5), 1.0 / count as f64),
        };
        let first = self.about_median(Tested::of_second, Tested::of_first);
        let second = self.about_median(Tested::of_first, Tested::of_second);
        let k = tails::seen_in_90_percent(each, self.median()?.freedom);
        let (u, v, b) = (k * k * first, k * k * second, k * k * self.border);
        let step = self.about_median(Tested::of_first, |cell| cell.step);
        let (left, linear) = (1.0 - v - b, v + b * step);
        (left > 0.0).then(|| (linear + (linear * linear + left * (u + v + b * step * step)).sqrt()) / left)
    }

    /// Mean of a number over the tenth of the cells that lie about the median of another.
    fn about_median(&self, pick: impl Fn(&Tested) -> f64, number: impl Fn(&Tested) -> f64) -> f64 {
        let mut cells: Vec<&Tested> = self.cells.iter().collect();
        cells.sort_by(|a, b| pick(a).total_cmp(&pick(b)));
        let (middle, reach) = (cells.len() / 2, cells.len() / 20);
        let about = cells.get(middle - reach..=middle + reach).unwrap_or_default();
        about.iter().map(|cell| number(cell)).sum::<f64>() / about.len().max(1) as f64
    }
}

#[cfg(test)]
pub(super) mod tests;
