//! Differences between images from independent replicates, with errors that come from their spread.

/// A value and its standard error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// The value.
    pub value: f64,
    /// Its standard error.
    pub error: f64,
}

/// Replicates of some cells: blocks of pixels, rings, or whole images.
#[derive(Debug, Clone, Default)]
pub struct Replicates {
    /// Cells of each replicate.
    pub rounds: Vec<Vec<f64>>,
}

impl Replicates {
    /// Mean of each cell.
    pub fn mean(&self) -> Vec<f64> {
        self.mean_without(usize::MAX)
    }

    /// Cells above 0.3 of the 99th percentile, the lit ones (as for a render's relative error).
    pub fn lit(&self) -> Vec<bool> {
        let mean = self.mean();
        let mut sorted = mean.clone();
        sorted.sort_by(f64::total_cmp);
        let threshold = sorted.get(sorted.len().saturating_sub(1) * 99 / 100).map_or(0.0, |p| 0.3 * p);
        mean.iter().map(|&m| m > threshold).collect()
    }

    /// Bias of a cell against the same cell of a reference, relative to the reference. Rounds of one seed are paired:
    /// what both have in common drops out.
    pub fn relative_bias(&self, reference: &Self, cell: usize) -> Estimate {
        let ratio = |skip: usize| {
            let (ours, theirs) = (self.mean_without(skip)[cell], reference.mean_without(skip)[cell]);
            ours / theirs - 1.0
        };
        jackknife(self.rounds.len(), ratio)
    }

    /// Root-mean-square bias over the marked cells, over the reference's mean there.
    ///
    /// The square of a noisy difference is too large by its variance, which is taken out; what is left may be negative
    /// where there is no bias to see, and is given with its sign.
    pub fn rms_bias(&self, reference: &Self, marked: &[bool]) -> Estimate {
        let rounds = self.rounds.iter().zip(&reference.rounds);
        let paired = Self { rounds: rounds.map(|(a, b)| a.iter().zip(b).map(|(a, b)| a - b).collect()).collect() };
        let scale = marked_mean(&reference.mean(), marked);
        let square = |skip: usize| {
            let difference: Vec<f64> = paired.mean_without(skip).iter().map(|d| d * d).collect();
            marked_mean(&difference, marked) - marked_mean(&paired.variance_of_mean(skip), marked)
        };
        let Estimate { value, error } = jackknife(paired.rounds.len(), square);
        // Half the width of the root over the square's interval: finite where the square itself is near zero.
        let root = |square: f64| square.signum() * square.abs().sqrt() / scale;
        Estimate { value: root(value), error: 0.5 * (root(value + error) - root(value - error)) }
    }

    /// Root-mean-square noise of one replicate over the marked cells, over their mean.
    pub fn noise(&self, marked: &[bool]) -> f64 {
        let n = self.rounds.len() as f64;
        let variance = marked_mean(&self.variance_of_mean(usize::MAX), marked) * n;
        variance.sqrt() / marked_mean(&self.mean(), marked)
    }

    fn mean_without(&self, skip: usize) -> Vec<f64> {
        let mut sum = vec![0.0; self.rounds.first().map_or(0, Vec::len)];
        let kept = self.rounds.iter().enumerate().filter(|(k, _)| *k != skip);
        let mut count = 0.0;
        for (_, round) in kept {
            sum.iter_mut().zip(round).for_each(|(s, v)| *s += v);
            count += 1.0;
        }
        sum.iter().map(|s| s / count).collect()
    }

    fn variance_of_mean(&self, skip: usize) -> Vec<f64> {
        let mean = self.mean_without(skip);
        let mut sum = vec![0.0; mean.len()];
        let kept = self.rounds.iter().enumerate().filter(|(k, _)| *k != skip);
        let mut count = 0.0;
        for (_, round) in kept {
            sum.iter_mut().zip(round).zip(&mean).for_each(|((s, v), m)| *s += (v - m) * (v - m));
            count += 1.0;
        }
        sum.iter().map(|s| s / (count * (count - 1.0))).collect()
    }
}

/// Means over square blocks of pixels; the last block of a row or column may be cut.
pub fn block_means(image: &[f64], [width, height]: [u32; 2], edge: u32) -> Vec<f64> {
    let columns = width.div_ceil(edge);
    let mut sums = vec![(0.0, 0.0); (columns * height.div_ceil(edge)) as usize];
    for (pixel, value) in (0..).zip(image) {
        let (sum, count) = &mut sums[(pixel / width / edge * columns + pixel % width / edge) as usize];
        *sum += value;
        *count += 1.0;
    }
    sums.iter().map(|(sum, count)| sum / count).collect()
}

/// Mean over the marked values.
pub fn marked_mean(values: &[f64], marked: &[bool]) -> f64 {
    let chosen = || values.iter().zip(marked).filter(|(_, m)| **m).map(|(v, _)| v);
    chosen().sum::<f64>() / chosen().count() as f64
}

/// A statistic of all rounds and its standard error by leaving out one round at a time (Quenouille, Tukey).
fn jackknife(rounds: usize, statistic: impl Fn(usize) -> f64) -> Estimate {
    let parts: Vec<f64> = (0..rounds).map(&statistic).collect();
    let n = rounds as f64;
    let mean = parts.iter().sum::<f64>() / n;
    let variance = parts.iter().map(|p| (p - mean) * (p - mean)).sum::<f64>() * (n - 1.0) / n;
    Estimate { value: statistic(usize::MAX), error: variance.sqrt() }
}
