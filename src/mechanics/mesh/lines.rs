//! Grid lines along one axis, graded by a field of element sizes.
//!
//! The size at x is the smallest of size + growth * distance over all features, and never above the coarsest. Between
//! two breaks lie n cells of equal integral of dx / size. A subdivision s makes n s cells from the same integral, so
//! the meshes of a ladder are nested.

use super::MeshError;

/// Fewest samples of the size field between two breaks; it sets where lines lie, not whether they fit.
const SAMPLES: usize = 2000;

/// Samples in a cell: where sizes span many decades, a fixed number of samples would miss the smallest.
const SAMPLES_PER_CELL: f64 = 20.0;

/// Most cells along one axis.
const MOST_CELLS: usize = 100_000;

/// Ascending positions of grid lines, mm.
#[derive(Debug, Clone, PartialEq)]
pub struct Lines(pub Vec<f64>);

impl Lines {
    /// Number of cells between the lines.
    pub fn cells(&self) -> usize {
        self.0.len().saturating_sub(1)
    }

    /// Positions of quadratic elements' nodes: the lines and the middles between them.
    pub fn nodes(&self) -> Vec<f64> {
        let middles = self.0.windows(2).flat_map(|pair| [pair[0], 0.5 * (pair[0] + pair[1])]);
        middles.chain(self.0.last().copied()).collect()
    }

    /// The lines from `low` to `high`, both included.
    pub fn between(&self, low: f64, high: f64) -> Lines {
        Lines(self.0.iter().copied().filter(|&x| x >= low && x <= high).collect())
    }
}

/// Where elements have to be small.
#[derive(Debug, Clone)]
pub(super) struct Grading {
    /// Growth of the size per length.
    pub growth: f64,
    /// Largest size, mm.
    pub coarsest_mm: f64,
    /// From, to, size there, mm.
    pub features: Vec<[f64; 3]>,
}

impl Grading {
    fn size(&self, x: f64) -> f64 {
        self.features.iter().fold(self.coarsest_mm, |size, [low, high, at]| {
            size.min(at + self.growth * (low - x).max(x - high).max(0.0))
        })
    }

    /// Lines through all `breaks`, which must ascend.
    pub fn lines(&self, breaks: &[f64], subdivision: usize) -> Result<Lines, MeshError> {
        let mut fine = self.clone();
        for pair in breaks.windows(2) {
            let (low, high) = (pair[0], pair[1]);
            if high - low < self.size(0.5 * (low + high)) {
                fine.features.push([low, high, high - low]);
            }
        }
        let mut lines: Vec<f64> = breaks.first().copied().into_iter().collect();
        for pair in breaks.windows(2) {
            fine.interval(pair[0], pair[1], subdivision, &mut lines)?;
            lines.push(pair[1]);
        }
        Ok(Lines(lines))
    }

    fn interval(&self, low: f64, high: f64, subdivision: usize, lines: &mut Vec<f64>) -> Result<(), MeshError> {
        let coarse = (high - low) / SAMPLES as f64;
        let (mut places, mut sums) = (vec![low], vec![0.0]);
        let (mut place, mut sum) = (low, 0.0);
        while place < high {
            let step = coarse.min(self.size(place) / SAMPLES_PER_CELL).min(high - place);
            sum += step / self.size(place + 0.5 * step);
            place = if step < high - place { place + step } else { high };
            places.push(place);
            sums.push(sum);
            if sums.len() > SAMPLES + MOST_CELLS * SAMPLES_PER_CELL as usize {
                return Err(MeshError::TooMany { elements: MOST_CELLS + 1, limit: MOST_CELLS });
            }
        }
        // The margin keeps round-off from adding a cell where the length is a whole number of sizes.
        let cells = ((sum - 1e-6).ceil().max(1.0) * subdivision as f64) as usize;
        if cells > MOST_CELLS {
            return Err(MeshError::TooMany { elements: cells, limit: MOST_CELLS });
        }
        for line in 1..cells {
            let target = sum * line as f64 / cells as f64;
            let k = sums.partition_point(|&s| s <= target).clamp(1, sums.len() - 1);
            let within = (target - sums[k - 1]) / (sums[k] - sums[k - 1]);
            lines.push(places[k - 1] + (places[k] - places[k - 1]) * within);
        }
        Ok(())
    }
}
