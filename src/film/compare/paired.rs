//! Two films of the same random numbers, replicate by replicate.
//!
//! Where both films were made from the same seed and with the same work, a replicate of one and that of the other see
//! nearly the same noise. What is left of it in the difference, b - r a with r the ratio of both means, is the spread
//! over the replicates. So LEDs brighter by 2 % show at any noise: the differences from the ratio 1.02 vanish.
//! Replicates are independent of each other, so Student's t holds whether or not the two films share noise; where
//! they do not, it sees no more than an image of the regions would.

use super::ratio::{ROUNDING, Ratio, or_undefined};
use crate::film::Parts;
use crate::film::parts::REGIONS;
use crate::film::tails;
use serde::Serialize;

/// The comparison of two films replicate by replicate.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Paired {
    /// Regions of the image with light.
    pub regions: usize,
    /// Groups of replicates that were compared.
    pub groups: usize,
    /// Largest deviate, as the normal one of the same probability.
    pub max_z: f64,
    /// Chance of a worse one by noise alone.
    pub p_value: f64,
    /// Whether that chance is above this test's share of the family-wise level.
    pub passed: bool,
    /// Second mean over first, from the differences of the replicates; none where the first is dark.
    #[serde(serialize_with = "or_undefined")]
    pub ratio: Option<Ratio>,
    /// The relative change of the whole image that would have been called different in 90 of 100 cases.
    #[serde(serialize_with = "or_undefined")]
    pub smallest_change: Option<f64>,
}

/// The difference of one region.
struct Region {
    mean: [f64; 2],
    /// Standard error of the difference that the ratio of both means leaves.
    error: f64,
    freedom: f64,
}

impl Paired {
    /// None where a film does not know its replicates, or they do not match.
    pub(super) fn of(a: &Parts, b: &Parts) -> Option<Self> {
        if a.replicates != b.replicates || a.replicates.len() < 2 || !a.is_whole() || !b.is_whole() {
            return None;
        }
        let of_region = |k: usize| Region::of(&a.replicates, a.region(k).collect(), b.region(k).collect());
        let regions = (0..REGIONS[0] * REGIONS[1]).map(of_region).filter(|region| region.mean != [0.0; 2]);
        let tails: Vec<f64> = regions.map(|region| region.tail()).collect();
        let sums = |parts: &Parts| -> Vec<f64> {
            let groups = parts.radiance.chunks(REGIONS[0] * REGIONS[1]);
            groups.map(|regions| regions.iter().map(|&v| f64::from(v)).sum()).collect()
        };
        let whole = Region::of(&a.replicates, sums(a), sums(b));
        let smallest = tails.iter().copied().fold(whole.tail(), f64::min);
        Some(Self {
            regions: tails.len(),
            groups: a.replicates.len(),
            max_z: tails::normal_deviate(smallest),
            p_value: tails::sidak(smallest, tails.len() as f64 + 1.0),
            passed: true,
            ratio: whole.ratio(),
            smallest_change: (whole.mean[0] > 0.0).then(|| whole.error / whole.mean[0]),
        })
    }

    /// At a share of the family-wise level.
    pub(super) fn judged(mut self, share: f64) -> Self {
        let each = tails::sidak(share, 1.0 / (self.regions as f64 + 1.0));
        let standard_errors = tails::seen_in_90_percent(each, self.groups as f64 - 1.0);
        self.passed = self.p_value >= share;
        self.smallest_change = self.smallest_change.map(|error| error * standard_errors);
        self
    }
}

impl Region {
    fn of(weights: &[u32], a: Vec<f64>, b: Vec<f64>) -> Self {
        let total: f64 = weights.iter().map(|&n| f64::from(n)).sum();
        let mean = |values: &[f64]| weights.iter().zip(values).map(|(&n, v)| f64::from(n) * v).sum::<f64>() / total;
        let [mean_a, mean_b] = [mean(&a), mean(&b)];
        let ratio = if mean_a == 0.0 { 0.0 } else { mean_b / mean_a };
        let square = |((&n, a), b): ((&u32, &f64), &f64)| f64::from(n) / total * (b - ratio * a).powi(2);
        let freedom = weights.len() as f64 - 1.0;
        let variance = weights.iter().zip(&a).zip(&b).map(square).sum::<f64>() / freedom;
        let floor = ROUNDING * mean_a.abs().max(mean_b.abs());
        Self { mean: [mean_a, mean_b], error: variance.sqrt().hypot(floor), freedom }
    }

    fn tail(&self) -> f64 {
        let difference = self.mean[1] - self.mean[0];
        if difference == 0.0 { 1.0 } else { tails::two_sided(difference / self.error, self.freedom) }
    }

    fn ratio(&self) -> Option<Ratio> {
        let value = self.mean[1] / self.mean[0];
        let half = tails::quantile_95(self.freedom) * self.error / self.mean[0].abs();
        (self.mean[0] != 0.0).then_some(Ratio { value, low: value - half, high: value + half })
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use crate::film::compare::tests::Noise;
    use crate::film::compare::{Comparison, compare, compare_paired};
    use crate::film::{BlockAccumulator, Film};

    /// Sixteen replicates of noise as large as the light, of one seed, `scale` times as bright; beside it independent
    /// noise.
    fn film(seed: u64, scale: f64, own: f64) -> Film {
        let (mut noise, mut other) = (Noise(seed), Noise(seed + (own.to_bits() ^ scale.to_bits())));
        let mut sums = BlockAccumulator::new(32, 24);
        for _ in 0..16 {
            let image = (0..32 * 24).map(|_| scale * (1.0 + noise.normal()) + own * other.normal());
            sums.add(&image.collect::<Vec<_>>()).unwrap();
        }
        sums.finish()
    }

    fn paired(scale: f64, own: [f64; 2], seed: u64, level: f64) -> Comparison {
        compare_paired(&film(seed, 1.0, own[0]), &film(seed, scale, own[1]), level).unwrap()
    }

    #[test]
    fn two_percent_more_light_of_the_same_seed_is_seen_pair_by_pair_only() {
        let found = paired(1.02, [0.0; 2], 1, 1e-3);
        assert!(!found.passed && found.tests.iter().all(|test| test.passed), "{found:?}");
        let ratio = found.paired.unwrap().ratio.unwrap();
        assert!(ratio.low < 1.02 && 1.02 < ratio.high && ratio.high - ratio.low < 1e-4, "{ratio:?}");
        assert!(found.paired.unwrap().smallest_change.unwrap() < 1e-4);
        assert!(
            compare(&film(1, 1.0, 0.0), &film(1, 1.02, 0.0), 1e-3).unwrap().passed,
            "which a plain comparison misses"
        );
        assert!(paired(1.0, [0.0; 2], 1, 1e-3).passed);
    }

    #[test]
    fn equal_light_pair_by_pair_fails_no_oftener_than_the_level_and_is_as_sensitive_as_it_says() {
        let level = 0.1;
        let (mut failures, mut seen) = (0, 0);
        for seed in 0..200 {
            let equal = paired(1.0, [0.01, 0.010_01], seed, level);
            failures += u32::from(!equal.paired.unwrap().passed);
            let change = equal.paired.unwrap().smallest_change.unwrap();
            seen += u32::from(!paired(1.0 + change, [0.01, 0.010_01], seed, level).passed);
        }
        // Five tests share the level: 4.2 of 200 expected, standard deviation 2; and 180 or more, less three times 4.2.
        assert!(failures <= 10, "{failures} of 200");
        assert!(seen >= 167, "{seen} of 200");
    }
}
