//! Means over blocks of pixels, with variances that know how neighbours hang together.
//!
//! Neighbouring pixels share photons (`splat`) and texels (`map`), so the variance of a block is not the sum of its
//! pixels' variances. Each replicate's block means are therefore averaged on their own, beside the pixels. A file
//! keeps only the pixels; of each block it keeps one number, its [`Inflation`].

use super::Film;
use super::groups::Groups;
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// Edges of the blocks of a film, pixels; 0 stands for the whole image.
pub const EDGES: [u32; 4] = [4, 16, 64, 0];

/// The means of all blocks of one size. The last block of a row or column may be cut by the image's edge.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct BlockLevel {
    /// Edge of a block, pixels; 0: one block, the whole image.
    pub edge: u32,
    /// Blocks in a row.
    pub columns: u32,
    /// Rows of blocks.
    pub rows: u32,
    /// Mean radiance over each block, row-major, W/(m^2 sr).
    pub mean: Vec<f32>,
    /// Variance of that mean, the square of that unit.
    pub variance: Vec<f32>,
}

/// How much the variances of a level's blocks exceed what independent pixels would give.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Inflation {
    /// Edge of a block, pixels; 0: the whole image.
    pub edge: u32,
    /// The median over the blocks that are clear of noise.
    pub factor: f64,
    /// Of each block, row-major, to 4.5 % of the variance; empty: `factor` for all.
    #[serde(with = "factors", default)]
    pub blocks: Vec<f64>,
}

/// A factor in a byte: the binary logarithm in steps of 1/8, from 2^-4 on.
mod factors {
    use base64::{Engine, engine::general_purpose::STANDARD};
    use serde::{Deserialize, Deserializer, Serializer, de::Error};

    pub fn serialize<S: Serializer>(factors: &[f64], serializer: S) -> Result<S::Ok, S::Error> {
        let bytes: Vec<u8> = factors.iter().map(|factor| super::coded(*factor)).collect();
        serializer.serialize_str(&STANDARD.encode(bytes))
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<f64>, D::Error> {
        let text = String::deserialize(deserializer)?;
        let bytes = STANDARD.decode(text).map_err(D::Error::custom)?;
        Ok(bytes.into_iter().map(super::decoded).collect())
    }
}

fn coded(factor: f64) -> u8 {
    ((factor.log2() + 4.0) * 8.0).round().clamp(0.0, 255.0) as u8
}

fn decoded(byte: u8) -> f64 {
    (f64::from(byte) / 8.0 - 4.0).exp2()
}

/// A replicate whose size is not the film's.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error("a replicate of {found} pixels was added to a film of {expected}")]
pub struct ReplicateSize {
    /// Pixels of the film.
    pub expected: usize,
    /// Pixels of the replicate.
    pub found: usize,
}

/// How pixels fall into blocks.
#[derive(Debug, Clone, Copy)]
struct Grid {
    edge: u32,
    columns: u32,
    rows: u32,
    width: u32,
}

impl Grid {
    fn new(width: u32, height: u32, edge: u32) -> Self {
        let (columns, rows) = match edge {
            0 => (1, 1),
            edge => (width.div_ceil(edge), height.div_ceil(edge)),
        };
        Self { edge, columns, rows, width }
    }

    fn cells(&self) -> usize {
        self.columns as usize * self.rows as usize
    }

    /// Sums the values of each block, in pixel order.
    fn sums(&self, values: &[f64]) -> Vec<f64> {
        let mut sums = vec![0.0; self.cells()];
        let edge = if self.edge == 0 { usize::MAX } else { self.edge as usize };
        let columns = self.columns as usize;
        for (y, row) in values.chunks(self.width.max(1) as usize).enumerate() {
            for (sum, chunk) in sums.iter_mut().skip(y / edge * columns).zip(row.chunks(edge)) {
                chunk.iter().for_each(|value| *sum += value);
            }
        }
        sums
    }
}

/// How many blocks of one edge an image has.
pub fn cells(width: u32, height: u32, edge: u32) -> usize {
    Grid::new(width, height, edge).cells()
}

/// Running mean and sum of squared deviations of many cells (Welford 1962).
#[derive(Debug, Clone)]
struct Running {
    mean: Vec<f64>,
    m2: Vec<f64>,
}

impl Running {
    fn new(cells: usize) -> Self {
        Self { mean: vec![0.0; cells], m2: vec![0.0; cells] }
    }

    fn add(&mut self, count: u32, values: impl Iterator<Item = f64>) {
        let cells = self.mean.iter_mut().zip(&mut self.m2);
        for ((mean, m2), value) in cells.zip(values) {
            let delta = value - *mean;
            *mean += delta / f64::from(count);
            *m2 += delta * (value - *mean);
        }
    }

    fn mean(&self) -> Vec<f32> {
        self.mean.iter().map(|&mean| mean as f32).collect()
    }

    /// Variance of the mean; 0 where one replicate cannot tell.
    fn variance(&self, count: u32) -> Vec<f32> {
        let n = f64::from(count);
        let scale = if count > 1 { 1.0 / (n * (n - 1.0)) } else { 0.0 };
        self.m2.iter().map(|&m2| (m2 * scale) as f32).collect()
    }
}

#[derive(Debug, Clone)]
struct Level {
    grid: Grid,
    pixels: Vec<f64>,
    running: Running,
}

/// Turns independent replicates of one image into a [`Film`]. The order of the replicates is the order of the sums.
#[derive(Debug, Clone)]
pub struct BlockAccumulator {
    width: u32,
    height: u32,
    count: u32,
    pixels: Running,
    levels: Vec<Level>,
    groups: Groups,
}

impl BlockAccumulator {
    /// An empty film of `width` columns and `height` rows.
    #[must_use]
    pub fn new(width: u32, height: u32) -> Self {
        let cells = width as usize * height as usize;
        let levels = EDGES.map(|edge| {
            let grid = Grid::new(width, height, edge);
            let pixels = grid.sums(&vec![1.0; cells]);
            let running = Running::new(pixels.len());
            Level { grid, pixels, running }
        });
        Self { width, height, count: 0, pixels: Running::new(cells), levels: levels.into(), groups: Groups::new() }
    }

    /// Adds one replicate: radiances in W/(m^2 sr), row-major.
    ///
    /// # Errors
    /// When its number of pixels is not the film's.
    pub fn add(&mut self, replicate: &[f64]) -> Result<(), ReplicateSize> {
        let expected = self.width as usize * self.height as usize;
        if replicate.len() != expected {
            return Err(ReplicateSize { expected, found: replicate.len() });
        }
        self.count += 1;
        self.pixels.add(self.count, replicate.iter().copied());
        self.groups.add(replicate);
        for level in &mut self.levels {
            let sums = level.grid.sums(replicate);
            let means = sums.iter().zip(&level.pixels).map(|(sum, pixels)| sum / pixels);
            level.running.add(self.count, means);
        }
        Ok(())
    }

    /// Replicates added so far.
    #[must_use]
    pub fn replicates(&self) -> u32 {
        self.count
    }

    /// The film of all replicates added so far.
    #[must_use]
    pub fn finish(&self) -> Film {
        let blocks = self.levels.iter().map(|level| BlockLevel {
            edge: level.grid.edge,
            columns: level.grid.columns,
            rows: level.grid.rows,
            mean: level.running.mean(),
            variance: level.running.variance(self.count),
        });
        Film {
            width: self.width,
            height: self.height,
            mean: self.pixels.mean(),
            variance: self.pixels.variance(self.count),
            replicates: self.count,
            blocks: blocks.collect(),
            groups: self.groups.finish(),
        }
    }
}

impl Film {
    /// How much the variances of this film's blocks exceed those of independent pixels. Empty where it has no blocks.
    ///
    /// The factor of a level is the median over its blocks, weighted by their pixels with a relative error below 10 %; the
    /// median of a chi-square over its mean is taken out (Wilson and Hilferty 1931).
    #[must_use]
    pub fn inflation(&self) -> Vec<Inflation> {
        let freedom = f64::from(self.replicates.saturating_sub(1).max(1));
        let median_over_mean = (1.0 - 2.0 / (9.0 * freedom)).powi(3);
        let clear =
            |(&mean, &variance): (&f32, &f32)| f64::from(u8::from(variance > 0.0 && mean * mean > 100.0 * variance));
        let level = |level: &BlockLevel| {
            let independent = independent_variances(self, level.edge);
            let ratio = |(&measured, &by_pixel): (&f32, &f64)| match by_pixel > 0.0 {
                true => decoded(coded(f64::from(measured) / by_pixel)),
                false => 1.0,
            };
            let blocks: Vec<f64> = level.variance.iter().zip(&independent).map(ratio).collect();
            let counts = Grid::new(self.width, self.height, level.edge)
                .sums(&self.mean.iter().zip(&self.variance).map(clear).collect::<Vec<_>>());
            let median =
                |weights: &[f64]| weighted_median(blocks.iter().copied().zip(weights.iter().copied()).collect());
            let median = median(&counts).or_else(|| median(&independent));
            let factor = median.map_or(1.0, |median| (median / median_over_mean).max(1.0));
            Inflation { edge: level.edge, factor, blocks }
        };
        self.blocks.iter().map(level).collect()
    }

    /// This film with blocks made from its pixels: variances as of independent pixels times their `inflation` (1 where it
    /// has none).
    #[must_use]
    pub fn with_blocks(mut self, inflation: &[Inflation]) -> Self {
        let level = |edge: u32| {
            let grid = Grid::new(self.width, self.height, edge);
            let pixels = grid.sums(&vec![1.0; self.mean.len()]);
            let sums = grid.sums(&self.mean.iter().map(|&mean| f64::from(mean)).collect::<Vec<_>>());
            let means = sums.iter().zip(&pixels).map(|(sum, pixels)| (sum / pixels.max(1.0)) as f32);
            let given = inflation.iter().find(|entry| entry.edge == edge);
            let factor = |block: usize| given.map_or(1.0, |e| e.blocks.get(block).copied().unwrap_or(e.factor));
            let variances = independent_variances(&self, edge);
            BlockLevel {
                edge,
                columns: grid.columns,
                rows: grid.rows,
                mean: means.collect(),
                variance: variances.iter().enumerate().map(|(k, v)| (v * factor(k)) as f32).collect(),
            }
        };
        self.blocks = EDGES.map(level).into();
        self
    }
}

/// Variances of the block means of one level if its pixels were independent.
fn independent_variances(film: &Film, edge: u32) -> Vec<f64> {
    let grid = Grid::new(film.width, film.height, edge);
    let pixels = grid.sums(&vec![1.0; film.variance.len()]);
    let sums = grid.sums(&film.variance.iter().map(|&variance| f64::from(variance)).collect::<Vec<_>>());
    sums.iter().zip(&pixels).map(|(sum, pixels)| sum / (pixels * pixels).max(1.0)).collect()
}

/// The value that splits the total weight in halves, from pairs of value and weight.
fn weighted_median(mut pairs: Vec<(f64, f64)>) -> Option<f64> {
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
    let half = pairs.iter().map(|(_, weight)| weight).sum::<f64>() / 2.0;
    if half <= 0.0 {
        return None;
    }
    let mut below = 0.0;
    for (value, weight) in &pairs {
        below += weight;
        if below >= half {
            return Some(*value);
        }
    }
    None
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn replicates_give_means_and_variances_of_pixels_and_blocks() {
        let mut sums = BlockAccumulator::new(5, 1);
        sums.add(&[1.0, 1.0, 1.0, 1.0, 8.0]).unwrap();
        sums.add(&[3.0, 3.0, 3.0, 3.0, 4.0]).unwrap();
        let film = sums.finish();
        assert_eq!(film.mean, [2.0, 2.0, 2.0, 2.0, 6.0]);
        // Two values 2 apart: sum of squares 2, over n (n - 1) = 2.
        assert_eq!(film.variance, [1.0, 1.0, 1.0, 1.0, 4.0]);
        let four = &film.blocks[0];
        assert_eq!((four.columns, four.rows), (2, 1));
        assert_eq!(four.mean, [2.0, 6.0], "the cut block averages its one pixel");
        assert_eq!(four.variance, [1.0, 4.0], "pixels that move together keep their variance");
        // Whole image: (4 * 1 + 8) / 5 and (4 * 3 + 4) / 5.
        assert_eq!(film.blocks[3].mean, [2.8]);
    }

    #[test]
    fn a_replicate_of_another_size_is_refused() {
        let mut sums = BlockAccumulator::new(2, 2);
        assert_eq!(sums.add(&[0.0; 3]), Err(ReplicateSize { expected: 4, found: 3 }));
    }

    #[test]
    fn the_factor_of_pixels_that_move_together_is_their_number() {
        let mut sums = BlockAccumulator::new(16, 16);
        for replicate in 0..8 {
            sums.add(&[f64::from(replicate); 256]).unwrap();
        }
        let film = sums.finish();
        let median_over_mean = (1.0_f64 - 2.0 / 63.0).powi(3);
        for (entry, pixels) in film.inflation().iter().zip([16.0, 256.0, 256.0, 256.0]) {
            // f32 variances: 6e-8 relative, summed over 256.
            assert!((entry.factor * median_over_mean / pixels - 1.0).abs() < 1e-5, "{entry:?}");
        }
        let again = Film { blocks: Vec::new(), ..film.clone() }.with_blocks(&film.inflation());
        let ratio = again.blocks[1].variance[0] / film.blocks[1].variance[0];
        assert!((f64::from(ratio) - 1.0).abs() < 1e-5);
        assert!([0.07, 1.0, 16.0, 3e7].iter().all(|&factor| (decoded(coded(factor)) / factor - 1.0).abs() < 0.045));
    }

    #[test]
    fn independent_pixels_have_a_factor_of_one() {
        let film = Film { width: 8, height: 8, mean: vec![1.0; 64], variance: vec![0.5; 64], ..Film::default() };
        assert!(film.inflation().is_empty());
        let film = film.with_blocks(&[]);
        assert_eq!(film.blocks[3].variance, [0.5 / 64.0]);
        assert!(film.blocks.iter().all(|level| level.mean.iter().all(|&mean| mean == 1.0)));
    }
}
