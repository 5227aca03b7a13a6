//! Means over blocks of pixels, with variances that know how neighbours hang together.
//!
//! Neighbouring pixels share photons (`splat`) and texels (`map`), so the variance of a block is not the sum of its
//! pixels' variances. Each replicate's block means are therefore averaged on their own, beside the pixels. A file
//! keeps their variances as channels in which each pixel has that of its block. (A model of what pixels share, of a few
//! numbers in the header, did not see the rim of the light: blocks that it crosses had a fifth of their variance, and
//! nine of ten pairs of one pressed phantom were called different.)

use super::groups::Groups;
use super::{Film, Parts};
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
pub(super) struct Grid {
    pub edge: u32,
    pub columns: u32,
    pub rows: u32,
    width: u32,
}

impl Grid {
    pub fn new(width: u32, height: u32, edge: u32) -> Self {
        let (columns, rows) = match edge {
            0 => (1, 1),
            edge => (width.div_ceil(edge), height.div_ceil(edge)),
        };
        Self { edge, columns, rows, width }
    }

    pub fn cells(&self) -> usize {
        self.columns as usize * self.rows as usize
    }

    /// The block of a pixel.
    pub fn block_of(&self, pixel: usize) -> usize {
        let (width, edge) = (self.width.max(1) as usize, if self.edge == 0 { usize::MAX } else { self.edge as usize });
        pixel / width / edge * self.columns as usize + pixel % width / edge
    }

    /// Sums the values of each block, in pixel order.
    pub fn sums(&self, values: &[f64]) -> Vec<f64> {
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
        let mut film = Film {
            width: self.width,
            height: self.height,
            mean: self.pixels.mean(),
            variance: self.pixels.variance(self.count),
            replicates: self.count,
            blocks: blocks.collect(),
            groups: self.groups.finish(),
            ..Film::default()
        };
        film.correlation = film.measured_correlation();
        film.parts = Parts::of(&film);
        film
    }
}

impl Film {
    /// This film with blocks of independent pixels.
    #[must_use]
    pub fn with_independent_blocks(mut self) -> Self {
        let level = |edge: u32| {
            let (grid, pixels, mean) = self.block_means(edge);
            let sums = grid.sums(&self.variance.iter().map(|&variance| variance.into()).collect::<Vec<_>>());
            let variances = sums.iter().zip(&pixels).map(|(sum, pixels)| (sum / (pixels * pixels)) as f32);
            BlockLevel { edge, columns: grid.columns, rows: grid.rows, mean, variance: variances.collect() }
        };
        self.blocks = EDGES.map(level).into();
        self
    }

    /// For each edge an image in which every pixel has the variance of its block. Where blocks are unknown, pixels
    /// count as independent.
    pub(crate) fn block_variance_images(&self) -> Vec<Vec<f32>> {
        if self.blocks.len() != EDGES.len() {
            return self.clone().with_independent_blocks().block_variance_images();
        }
        let image = |level: &BlockLevel| {
            let grid = Grid::new(self.width, self.height, level.edge);
            (0..self.mean.len()).map(|pixel| level.variance.get(grid.block_of(pixel)).copied().unwrap_or(0.0)).collect()
        };
        self.blocks.iter().map(image).collect()
    }

    /// This film with the blocks of such images, in the order of [`EDGES`]; none where one varies within a block.
    pub(crate) fn with_block_variance_images(mut self, images: &[Vec<f32>]) -> Option<Self> {
        let level = |(edge, image): (u32, &Vec<f32>)| {
            let (grid, _, mean) = self.block_means(edge);
            let mut variance = vec![None; grid.cells()];
            for (pixel, &value) in image.iter().enumerate() {
                let known = variance.get_mut(grid.block_of(pixel))?;
                if *known.get_or_insert(value) != value {
                    return None;
                }
            }
            let variance = variance.into_iter().collect::<Option<_>>()?;
            Some(BlockLevel { edge, columns: grid.columns, rows: grid.rows, mean, variance })
        };
        self.blocks = EDGES.into_iter().zip(images).map(level).collect::<Option<_>>()?;
        Some(self)
    }

    /// Blocks of this edge: their grid, their pixels and their means.
    fn block_means(&self, edge: u32) -> (Grid, Vec<f64>, Vec<f32>) {
        let grid = Grid::new(self.width, self.height, edge);
        let pixels = grid.sums(&vec![1.0; self.mean.len()]);
        let sums = grid.sums(&self.mean.iter().map(|&mean| f64::from(mean)).collect::<Vec<_>>());
        let means = sums.iter().zip(&pixels).map(|(sum, pixels)| (sum / pixels.max(1.0)) as f32).collect();
        (grid, pixels, means)
    }
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
    fn blocks_survive_as_images_and_independent_pixels_add_up() {
        let mut sums = BlockAccumulator::new(70, 9);
        for replicate in 0..5_usize {
            sums.add(&(0..630).map(|k| ((k / 3 + 1) * (replicate + 2) * 31 % 17) as f64).collect::<Vec<_>>()).unwrap();
        }
        let film = sums.finish();
        let mut images = film.block_variance_images();
        let bare = Film { blocks: Vec::new(), ..film.clone() };
        let again = bare.clone().with_block_variance_images(&images).unwrap();
        for (again, level) in again.blocks.iter().zip(&film.blocks) {
            assert_eq!((again.edge, again.columns, &again.variance), (level.edge, level.columns, &level.variance));
        }
        images[1][3] += 1.0;
        assert_eq!(bare.with_block_variance_images(&images), None, "it varies within a block");
        let even = Film { width: 8, height: 8, mean: vec![1.0; 64], variance: vec![0.5; 64], ..Film::default() };
        let even = even.with_independent_blocks();
        assert_eq!((even.blocks[0].variance[0], even.blocks[3].variance[0]), (0.5 / 16.0, 0.5 / 64.0));
        assert!(even.blocks.iter().all(|level| level.mean.iter().all(|&mean| mean == 1.0)));
    }

    #[test]
    fn a_replicate_of_another_size_is_refused() {
        let mut sums = BlockAccumulator::new(2, 2);
        assert_eq!(sums.add(&[0.0; 3]), Err(ReplicateSize { expected: 4, found: 3 }));
    }
}
