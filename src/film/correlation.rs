//! How much the cells of a level move together: two numbers that say how widely a sum of their squared deviates
//! scatters.
//!
//! Take n cells whose standardised noise has the correlation matrix P. A sum of their squares has the mean n, the
//! variance 2 tr P^2 and the third cumulant 8 tr P^3. So a level needs tr P^2 / n^2 and tr P^3 / n^3 only: 1/n and
//! 1/n^2 where cells are independent, 1 where all move as one. Standardised noise counts dim cells as bright ones, as
//! the sum does.
//!
//! Both are estimated from the replicates. Each cell's noise, over the root of its sum of squares, is a unit vector
//! of as many dimensions as there are degrees of freedom, nu. The mean over pairs of cells of their products squared
//! is the trace of the square of a small Gram matrix, that over triples the trace of its cube. Vectors of unrelated
//! cells are not orthogonal, since nu is small: their squared product is 1/nu on average, the product of three such
//! is 1/nu^2. What cells in clusters then leave is solved for both numbers (exact for clusters of any number; normal
//! noise gives the same to order 1/nu: Bai and Saranadasa 1996; Himeno and Yamada 2014).

use super::Film;
use super::blocks::{EDGES, Grid};
use super::compare::cells::Cells;
use serde::{Deserialize, Serialize};

/// How much the cells of one level move together.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Correlation {
    /// Edge of a cell, pixels; 1: pixels, 0: the whole image.
    pub edge: u32,
    /// Mean over all pairs of cells (a cell and itself is one) of the square of their correlation.
    pub pairs: f64,
    /// Mean over all triples of cells of the product of their three correlations.
    pub triples: f64,
}

impl Correlation {
    /// That of so many cells that do not know of each other.
    pub(super) fn independent(edge: u32, cells: f64) -> Self {
        let each = 1.0 / cells.max(1.0);
        Self { edge, pairs: each, triples: each * each }
    }

    /// Both numbers within what a correlation matrix of so many cells can have: 1/n <= p <= 1, p^2 <= t <= p^(3/2).
    pub(super) fn of_cells(self, cells: f64) -> Self {
        let pairs = self.pairs.clamp(1.0 / cells.max(1.0), 1.0);
        Self { pairs, triples: self.triples.clamp(pairs * pairs, pairs.powf(1.5)), ..self }
    }

    /// To four digits, which a header gives back to the bit.
    fn rounded(self) -> Self {
        let round = |value: f64| format!("{value:.3e}").parse().unwrap_or(value);
        Self { pairs: round(self.pairs), triples: round(self.triples), ..self }
    }

    /// That of the difference of two films, of which the first has the given share of the variance: both numbers are
    /// norms of the matrix (Schatten's), and a norm of a sum is at most the sum of the norms.
    pub(super) fn of_difference(self, other: Self, share: f64) -> Self {
        let mix = |a: f64, b: f64, power: f64| {
            (share * a.powf(1.0 / power) + (1.0 - share) * b.powf(1.0 / power)).powf(power)
        };
        Self {
            edge: self.edge,
            pairs: mix(self.pairs, other.pairs, 2.0),
            triples: mix(self.triples, other.triples, 3.0),
        }
    }
}

impl Film {
    /// Estimates it for pixels and blocks from the groups of replicates; empty where there are fewer than four.
    pub(super) fn measured_correlation(&self) -> Vec<Correlation> {
        if self.groups.len() < 4 {
            return Vec::new();
        }
        let level = |edge: u32| {
            let noise = self.unit_noise(edge);
            let freedom = self.groups.len() as f64 - 1.0;
            estimate(&noise, freedom).map(|[pairs, triples]| {
                let found = Correlation { edge, pairs, triples };
                found.of_cells(noise.first().map_or(1.0, |first| first.len() as f64)).rounded()
            })
        };
        let edges = std::iter::once(1).chain(EDGES).filter(|&edge| edge != 0);
        edges.filter_map(level).collect()
    }

    /// For each group the noise of the cells with light enough to be tested, over the root of its sum of squares.
    fn unit_noise(&self, edge: u32) -> Vec<Vec<f64>> {
        let grid = Grid::new(self.width, self.height, edge);
        let pixels = grid.sums(&vec![1.0; self.mean.len()]);
        let (mean, variance) = match self.blocks.iter().find(|level| level.edge == edge) {
            Some(level) => (&level.mean, &level.variance),
            None => (&self.mean, &self.variance),
        };
        let cells = Cells { columns: grid.columns, mean, variance, freedom: f64::INFINITY, least: &[] };
        let lit = cells.lit();
        let replicates: f64 = self.groups.iter().map(|group| f64::from(group.replicates)).sum();
        let mut noise: Vec<Vec<f64>> = Vec::new();
        for group in &self.groups {
            let sums = grid.sums(&group.mean.iter().map(|&v| f64::from(v)).collect::<Vec<_>>());
            noise.push(lit.iter().map(|&cell| sums[cell] / pixels[cell]).collect());
        }
        for cell in 0..lit.len() {
            let weights = self.groups.iter().map(|group| f64::from(group.replicates));
            let mean =
                noise.iter().zip(weights.clone()).map(|(group, weight)| weight * group[cell]).sum::<f64>() / replicates;
            for (group, weight) in noise.iter_mut().zip(weights) {
                group[cell] = weight.sqrt() * (group[cell] - mean);
            }
            let length = noise.iter().map(|group| group[cell] * group[cell]).sum::<f64>().sqrt();
            if length > 0.0 {
                noise.iter_mut().for_each(|group| group[cell] /= length);
            }
        }
        noise
    }
}

/// Both numbers from the unit vectors of the cells, given by coordinates; none where there are no cells.
fn estimate(noise: &[Vec<f64>], freedom: f64) -> Option<[f64; 2]> {
    let cells = noise.first().map_or(0, Vec::len) as f64;
    if cells == 0.0 {
        return None;
    }
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>() / cells;
    let gram: Vec<Vec<f64>> = noise.iter().map(|a| noise.iter().map(|b| dot(a, b)).collect()).collect();
    let (mut squares, mut cubes) = (0.0, 0.0);
    for (g, row) in gram.iter().enumerate() {
        for (h, &product) in row.iter().enumerate() {
            squares += product * product;
            cubes += product * gram[h].iter().zip(&gram[g]).map(|(a, b)| a * b).sum::<f64>();
        }
    }
    let by_chance = 1.0 / freedom;
    let pairs = (squares - by_chance) / (1.0 - by_chance);
    let triples = cubes - 3.0 * by_chance * (1.0 - by_chance) * pairs - by_chance * by_chance;
    Some([pairs, triples / ((1.0 - by_chance) * (1.0 - 2.0 * by_chance))])
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::film::BlockAccumulator;
    use crate::film::compare::tests::Noise;

    /// A film of 16 replicates whose rows of `together` pixels move as one; half of the pixels are 1000 times as
    /// bright and noisy.
    fn film(seed: u64, together: u32) -> Film {
        let mut noise = Noise(seed);
        let mut sums = BlockAccumulator::new(64, 32);
        for _ in 0..16 {
            let shared: Vec<f64> = (0..64 * 32 / together).map(|_| noise.normal()).collect();
            let scale = |pixel: u32| if pixel.is_multiple_of(2) { 1000.0 } else { 1.0 };
            let image = (0..64 * 32).map(|k| scale(k) * (1.0 + 0.01 * shared[(k / together) as usize]));
            sums.add(&image.collect::<Vec<_>>()).unwrap();
        }
        sums.finish()
    }

    #[test]
    fn clusters_of_bright_and_dim_cells_are_found_with_their_number() {
        for together in [1, 16, 512] {
            let (mut pairs, mut triples) = (0.0, 0.0);
            for seed in 0..40 {
                let found = film(seed, together).correlation[0];
                assert_eq!(found.edge, 1);
                pairs += found.pairs / 40.0;
                triples += found.triples / 40.0;
            }
            let clusters = f64::from(64 * 32 / together);
            // Four clusters, 15 degrees of freedom: one estimate scatters by a third, 40 by 5 %. The clamp from below
            // and the small numbers of many clusters lift the triples.
            assert!((pairs * clusters - 1.0).abs() < 0.2, "{together}: {pairs} of {clusters} clusters");
            let most = if together == 512 { 1.4 } else { 4.0 };
            let triples = triples * clusters * clusters;
            assert!((0.7..most).contains(&triples), "{together}: {triples}");
        }
    }

    #[test]
    fn a_film_of_too_few_replicates_does_not_say() {
        let mut sums = BlockAccumulator::new(4, 4);
        (0..3).for_each(|k| sums.add(&[f64::from(k); 16]).unwrap());
        assert!(sums.finish().correlation.is_empty());
    }

    #[test]
    fn a_difference_has_the_correlation_of_the_noisier_film() {
        let (one, many) = (Correlation { edge: 1, pairs: 1.0, triples: 1.0 }, Correlation::independent(1, 1e4));
        assert_eq!(one.of_difference(many, 1.0), one);
        let mixed = one.of_difference(many, 0.5);
        // (0.5 + 0.5 * 0.01)^2.
        assert!((mixed.pairs - 0.255_025).abs() < 1e-9 && mixed.triples < mixed.pairs);
    }
}
