//! Sampling of a density by an ensemble of walkers that take their steps from each other: the stretch move of Goodman
//! and Weare (Comm. App. Math. Comp. Sci. 5(1), 2010), which no linear map of the unknowns changes.

use crate::camera::noise::PixelRandom;

/// Longest stretch; its shortest is the inverse.
const STRETCH: f64 = 2.0;

/// A density to be sampled.
pub(super) struct Ensemble {
    /// Where the walkers are, and the logarithm of the density there.
    pub walkers: Vec<(Vec<f64>, f64)>,
    random: PixelRandom,
}

impl Ensemble {
    /// Walkers at these places, at least twice as many as there are unknowns.
    pub fn new(places: Vec<Vec<f64>>, seed: u32, log_density: &impl Fn(&[f64]) -> f64) -> Self {
        let walkers = places.into_iter().map(|place| (log_density(&place), place)).map(|(log, place)| (place, log));
        Self { walkers: walkers.collect(), random: PixelRandom::new(seed, 0) }
    }

    /// Each walker takes a step.
    pub fn step(&mut self, log_density: &impl Fn(&[f64]) -> f64) {
        let count = self.walkers.len();
        for k in 0..count {
            // One of the other half.
            let other = 2 * ((self.random.uniform() * (count / 2) as f64) as usize) + usize::from(k % 2 == 0);
            let u = self.random.uniform();
            let stretch = (1.0 + (STRETCH - 1.0) * u).powi(2) / STRETCH;
            let (Some((place, log)), Some((from, _))) = (self.walkers.get(k), self.walkers.get(other)) else {
                continue;
            };
            let tried: Vec<f64> = place.iter().zip(from).map(|(x, from)| from + stretch * (x - from)).collect();
            let found = log_density(&tried);
            let chance = (place.len() as f64 - 1.0) * stretch.ln() + found - log;
            if self.random.uniform().ln() < chance {
                self.walkers[k] = (tried, found);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A normal density of two unknowns, far from round, cut at half a standard deviation.
    #[test]
    fn moments_are_those_of_the_density() {
        let log_density = |x: &[f64]| match x[0] > 0.0 {
            true => -0.5 * (x[0].powi(2) + ((x[1] - 10.0 * x[0]) / 0.1).powi(2)),
            false => f64::NEG_INFINITY,
        };
        let mut random = PixelRandom::new(4, 0);
        let mut place = || {
            let x = random.uniform();
            vec![x, 10.0 * x + 0.05 * random.normal()]
        };
        let places = (0..40).map(|_| place()).collect();
        let mut ensemble = Ensemble::new(places, 5, &log_density);
        let (mut count, mut sums) = (0.0, [0.0; 3]);
        for step in 0..6000 {
            ensemble.step(&log_density);
            if step < 200 {
                continue;
            }
            for (place, _) in &ensemble.walkers {
                let off = place[1] - 10.0 * place[0];
                count += 1.0;
                sums.iter_mut().zip([place[0], place[0].powi(2), off * off]).for_each(|(sum, v)| *sum += v);
            }
        }
        // Half a normal: mean sqrt(2/pi), square 1. Correlated for some 60 steps: 4000 independent draws, of sd 0.6
        // and 1.4, so four standard errors are 0.04 and 0.09; the other square is 0.01 (1 +- 0.09).
        assert!((sums[0] / count - 0.7979).abs() < 0.04, "{}", sums[0] / count);
        assert!((sums[1] / count - 1.0).abs() < 0.09, "{}", sums[1] / count);
        assert!((sums[2] / count / 0.01 - 1.0).abs() < 0.09, "{}", sums[2] / count);
    }
}
