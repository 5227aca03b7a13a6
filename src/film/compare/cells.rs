//! One cell against the other, and the light around it.

use super::super::tails;
use super::ratio::{MIN_CONTRIBUTIONS, ROUNDING, Ratio};

/// Cells along a neighbourhood: 256 of them estimate a variance, so one's own share in it is lost.
const TILE: usize = 16;

/// The cells of one film at one level.
#[derive(Clone, Copy)]
pub(in crate::film) struct Cells<'a> {
    pub columns: u32,
    pub mean: &'a [f32],
    pub variance: &'a [f32],
    /// Degrees of freedom of every variance.
    pub freedom: f64,
    /// Least variance of each cell, known without replicates; empty: 0.
    pub least: &'a [f32],
}

/// One cell of one film.
#[derive(Clone, Copy, Default)]
pub(in crate::film) struct Cell {
    pub mean: f64,
    variance: f64,
    freedom: f64,
}

impl Cells<'_> {
    pub fn iter(&self) -> impl Iterator<Item = Cell> {
        let least = self.least.iter().copied().chain(std::iter::repeat(0.0));
        let freedom = self.freedom;
        self.mean.iter().zip(self.variance).zip(least).map(move |((&mean, &variance), least)| match variance < least {
            true => Cell { mean: mean.into(), variance: least.into(), freedom: f64::INFINITY },
            false => Cell { mean: mean.into(), variance: variance.into(), freedom },
        })
    }

    /// Least variances of pixels that few samples may have taken for even. Of n samples of a pixel that a border
    /// crosses all may fall on one side; what lies beyond has then at most 3/n of it in 95 of 100 cases (the rule of
    /// three) and is as bright as a neighbour at most. A number of that share has the variance 3 d^2 / n^2 where the
    /// neighbour differs by d, its noise taken off.
    pub fn across_borders(&self, samples: f64) -> Vec<f32> {
        let columns = self.columns.max(1) as usize;
        let at = |column: usize, row: usize| {
            let index = row.checked_mul(columns)? + column;
            let inside = column < columns;
            Some((f64::from(*self.mean.get(index).filter(|_| inside)?), f64::from(*self.variance.get(index)?)))
        };
        let pixel = |(index, (&mean, &variance)): (usize, (&f32, &f32))| {
            let (column, row) = (index % columns, index / columns);
            let around = (0..9).filter_map(|k| at((column + k % 3).checked_sub(1)?, (row + k / 3).checked_sub(1)?));
            let beyond = around.map(|(other, noise)| (other - f64::from(mean)).powi(2) - noise - f64::from(variance));
            (border(samples) * beyond.fold(0.0, f64::max)) as f32
        };
        self.mean.iter().zip(self.variance).enumerate().map(pixel).collect()
    }

    /// The cells that vary and have light enough to be tested, by this film alone.
    pub fn lit(&self) -> Vec<usize> {
        let weights = self.weights();
        let lit = |(cell, weight): (Cell, &Option<f64>)| {
            cell.variance > 0.0 && weight.is_some_and(|weight| cell.mean >= MIN_CONTRIBUTIONS * weight)
        };
        let judged: Vec<bool> = self.iter().zip(&weights).map(lit).collect();
        (0..judged.len()).filter(|&cell| judged.get(cell) == Some(&true)).collect()
    }

    pub fn first(&self) -> Cell {
        self.iter().next().unwrap_or_default()
    }

    /// Variance per radiance, the weight of one contribution, around each cell; that of the whole film where the
    /// neighbourhood is dark, perhaps by chance; none where the film is.
    pub fn weights(&self) -> Vec<Option<f64>> {
        let tiles = Tiles::new(self.columns, self.mean.len());
        let mut sums = vec![(0.0, 0.0); tiles.count()];
        for (index, cell) in self.iter().enumerate() {
            if let Some((mean, variance)) = sums.get_mut(tiles.of(index)) {
                *mean += cell.mean;
                *variance += cell.variance;
            }
        }
        let of = |(mean, variance): (f64, f64)| (mean > 0.0).then_some(variance / mean);
        let whole = of(sums.iter().fold((0.0, 0.0), |whole, tile| (whole.0 + tile.0, whole.1 + tile.1)));
        let weight = |index| sums.get(tiles.of(index)).copied().and_then(of).or(whole);
        (0..self.mean.len()).map(weight).collect()
    }
}

/// Variance that a border may leave, over the square of the step of light across it.
pub(super) fn border(samples: f64) -> f64 {
    3.0 / (samples * samples)
}

/// Neighbourhoods of at least [`TILE`] by [`TILE`] cells, or all there are.
struct Tiles {
    cells: [usize; 2],
    tiles: [usize; 2],
}

impl Tiles {
    fn new(columns: u32, cells: usize) -> Self {
        let columns = columns.max(1) as usize;
        let cells = [columns, cells.div_ceil(columns).max(1)];
        Self { cells, tiles: cells.map(|cells| (cells / TILE).max(1)) }
    }

    fn count(&self) -> usize {
        self.tiles.iter().product()
    }

    fn of(&self, index: usize) -> usize {
        let ([columns, rows], [across, down]) = (self.cells, self.tiles);
        (index / columns * down / rows) * across + index % columns * across / columns
    }
}

/// A tested cell.
#[derive(Clone, Copy)]
pub(super) struct Tested {
    /// Its place, row-major.
    pub index: usize,
    /// Two-sided probability of its difference.
    pub p: f64,
    /// Share of the first film in the variance of the difference.
    pub share: f64,
    /// Standard error of the difference over the light of both.
    pub relative_error: f64,
    /// Degrees of freedom of the difference.
    pub freedom: f64,
    /// Mean of both films, pooled.
    pub light: f64,
    /// Largest step from a neighbour of the second film, beyond noise, over that light.
    pub step: f64,
}

impl Tested {
    /// Relative variance that the first film adds.
    pub fn of_first(&self) -> f64 {
        self.share * self.relative_error.powi(2)
    }

    /// Relative variance that the second film adds.
    pub fn of_second(&self) -> f64 {
        (1.0 - self.share) * self.relative_error.powi(2)
    }
}

/// Tests a cell's difference; none where it is dark in both films or has too little light.
pub(super) fn test_cell(index: usize, [mut a, mut b]: [Cell; 2], weights: [f64; 2], always: bool) -> Option<Tested> {
    let dark = |cell: Cell| cell.mean == 0.0 && cell.variance == 0.0;
    if dark(a) && dark(b) {
        return None;
    }
    // The pooled light: of all sums of both it alone says nothing about their difference, so a choice by it does not
    // favour cells that happen to be bright in the noisier film.
    let [weight_a, weight_b] = weights;
    let both = weight_a + weight_b;
    let light = if both > 0.0 { (a.mean * weight_b + b.mean * weight_a) / both } else { (a.mean + b.mean) / 2.0 };
    if !always && weights.iter().any(|weight| light < MIN_CONTRIBUTIONS * weight) {
        return None;
    }
    for (cell, weight) in [&mut a, &mut b].into_iter().zip(weights) {
        if dark(*cell) {
            cell.variance = weight * light.max(0.0);
        }
    }
    let floor = (ROUNDING * a.mean.abs().max(b.mean.abs())).powi(2);
    let variance = a.variance + b.variance + floor;
    let (difference, freedom) = (a.mean - b.mean, welch(variance, a, b));
    let p = if difference == 0.0 { 1.0 } else { tails::two_sided(difference / variance.sqrt(), freedom) };
    let share = (a.variance + 0.5 * floor) / variance;
    let light = light.abs();
    Some(Tested { index, p, share, relative_error: variance.sqrt() / light, freedom, light, step: 0.0 })
}

/// Degrees of freedom of a difference of two cells (Welch 1947).
fn welch(variance: f64, a: Cell, b: Cell) -> f64 {
    let part = |cell: Cell| cell.variance * cell.variance / cell.freedom;
    variance * variance / (part(a) + part(b))
}

/// Second mean over first, with its interval from the relative variances.
pub(super) fn ratio(a: Cell, b: Cell) -> Option<Ratio> {
    if a.mean == 0.0 {
        return None;
    }
    let value = b.mean / a.mean;
    // The derivatives of b/a turn both into variances of the ratio.
    let of_a = Cell { variance: a.variance * (value / a.mean).powi(2), ..a };
    let of_b = Cell { variance: b.variance / (a.mean * a.mean), ..b };
    let variance = of_a.variance + of_b.variance;
    if variance == 0.0 {
        return Some(Ratio { value, low: value, high: value });
    }
    let half = tails::quantile_95(welch(variance, of_a, of_b)) * variance.sqrt();
    Some(Ratio { value, low: value - half, high: value + half })
}
