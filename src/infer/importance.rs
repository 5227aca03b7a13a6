//! Draws of a density by importance: from mixtures of kernels with heavy tails that are fitted to it round after round
//! (West, J. R. Stat. Soc. B 55(2), 1993), weighed by the density over the mixture's.
//!
//! A chain of the same work keeps the shape of its start for longer than it runs where the density is a long, bent ridge,
//! as that of modulus and size is: its intervals lacked their far ends. Here every draw is independent, and how many
//! they are worth is known.

use crate::camera::noise::PixelRandom;
use faer::linalg::solvers::Llt;
use faer::{Mat, Side};
use rayon::prelude::*;

/// Kernels of a mixture, and their degrees of freedom.
const KERNELS: usize = 256;
const TAILS: f64 = 5.0;
/// Draws of a round, and the most rounds.
const DRAWS: usize = 6_000;
const ROUNDS: usize = 8;
/// Independent draws that suffice: an end of a 95 % interval is then known to 0.06 standard deviations.
const ENOUGH: f64 = 2_000.0;

/// Draws with their weights.
#[derive(Debug, Clone, Default)]
pub(super) struct Weighted {
    places: Vec<Vec<f64>>,
    weights: Vec<f64>,
    /// Largest logarithm of the density, and where.
    pub top: Option<(f64, Vec<f64>)>,
    /// How many independent draws of the density they are worth.
    pub worth: f64,
}

impl Weighted {
    /// Draws of a density, from places that are roughly of it. None where these lie in a plane.
    pub fn of(start: Vec<Vec<f64>>, seed: u32, log_density: &(impl Fn(&[f64]) -> f64 + Sync)) -> Option<Self> {
        let mut cloud = Self { weights: vec![1.0; start.len()], places: start, ..Self::default() };
        let mut kept = Self::default();
        for round in 0..ROUNDS {
            let mut random = PixelRandom::new(seed, round as u32);
            let mixture = Mixture::of(&cloud, &mut random)?;
            let places: Vec<Vec<f64>> = (0..DRAWS).map(|_| mixture.draw(&mut random)).collect();
            let logs: Vec<f64> = places.par_iter().map(|place| log_density(place)).collect();
            let off = logs.par_iter().zip(&places).map(|(log, place)| match log.is_finite() {
                true => log - mixture.log_density(place),
                false => f64::NEG_INFINITY,
            });
            let off: Vec<f64> = off.collect();
            let most = off.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            if !most.is_finite() {
                return None;
            }
            let weights: Vec<f64> = off.iter().map(|off| (off - most).exp()).collect();
            let best = (0..logs.len()).max_by(|&a, &b| logs[a].total_cmp(&logs[b]))?;
            cloud = Self { worth: worth(&weights), top: Some((logs[best], places[best].clone())), places, weights };
            // The first mixture is that of a guess.
            if round > 0 {
                kept.add(&cloud);
            }
            if kept.worth >= ENOUGH {
                break;
            }
        }
        Some(kept)
    }

    /// Draws of another mixture beside these. A round counts by what its draws are worth.
    fn add(&mut self, other: &Self) {
        let sum: f64 = other.weights.iter().sum();
        self.places.extend(other.places.iter().cloned());
        self.weights.extend(other.weights.iter().map(|weight| weight * other.worth / sum));
        self.worth += other.worth;
        if self.top.as_ref().map(|top| top.0) < other.top.as_ref().map(|top| top.0) {
            self.top.clone_from(&other.top);
        }
    }

    /// So many draws of equal weight.
    pub fn drawn(&self, count: usize, random: &mut PixelRandom) -> Vec<Vec<f64>> {
        let sum: f64 = self.weights.iter().sum();
        let first = random.uniform();
        let (mut at, mut reached) = (0, self.weights.first().copied().unwrap_or(0.0));
        let mut draw = |k: usize| {
            let wanted = (k as f64 + first) / count as f64 * sum;
            while reached < wanted && at + 1 < self.places.len() {
                at += 1;
                reached += self.weights[at];
            }
            self.places.get(at).cloned()
        };
        (0..count).filter_map(&mut draw).collect()
    }
}

/// How many equal draws unequal ones are worth (Kish).
fn worth(weights: &[f64]) -> f64 {
    let sum: f64 = weights.iter().sum();
    sum * sum / weights.iter().map(|weight| weight * weight).sum::<f64>()
}

/// Kernels of one shape about some of the draws.
struct Mixture {
    centers: Vec<Vec<f64>>,
    /// The same in units in which a kernel is round.
    round: Vec<Vec<f64>>,
    /// Lower triangle of the kernels' shape, row after row.
    lower: Vec<Vec<f64>>,
}

impl Mixture {
    fn of(cloud: &Weighted, random: &mut PixelRandom) -> Option<Self> {
        let unknowns = cloud.places.first()?.len();
        let sum: f64 = cloud.weights.iter().sum();
        let weighed = || cloud.places.iter().zip(&cloud.weights).map(|(place, weight)| (place, weight / sum));
        let mean: Vec<f64> = (0..unknowns).map(|i| weighed().map(|(place, weight)| weight * place[i]).sum()).collect();
        let covariance = Mat::from_fn(unknowns, unknowns, |i, j| {
            weighed().map(|(place, weight)| weight * (place[i] - mean[i]) * (place[j] - mean[j])).sum::<f64>()
        });
        let factor = Llt::new(covariance.as_ref(), Side::Lower).ok()?;
        // Silverman's width; centers drawn in keep the cloud's covariance.
        let (d, worth) = (unknowns as f64, worth(&cloud.weights).min(KERNELS as f64));
        let width = (4.0 / ((d + 2.0) * worth)).powf(1.0 / (d + 4.0)).min(0.95);
        let shrunk = (1.0 - width * width).sqrt();
        let inward = |place: Vec<f64>| place.iter().zip(&mean).map(|(x, mean)| mean + shrunk * (x - mean)).collect();
        let centers: Vec<Vec<f64>> = cloud.drawn(KERNELS, random).into_iter().map(inward).collect();
        let lower = (0..unknowns).map(|i| (0..=i).map(|j| width * factor.L()[(i, j)]).collect()).collect();
        let mut mixture = Self { centers, round: Vec::new(), lower };
        mixture.round = mixture.centers.iter().map(|center| mixture.rounded(center)).collect();
        Some(mixture)
    }

    /// A place in units in which a kernel is round.
    fn rounded(&self, place: &[f64]) -> Vec<f64> {
        let mut out: Vec<f64> = Vec::with_capacity(place.len());
        for (row, x) in self.lower.iter().zip(place) {
            let known: f64 = row.iter().zip(&out).map(|(l, z)| l * z).sum();
            out.push((x - known) / row.last().copied().unwrap_or(1.0));
        }
        out
    }

    fn draw(&self, random: &mut PixelRandom) -> Vec<f64> {
        let k = ((random.uniform() * self.centers.len() as f64) as usize).min(self.centers.len() - 1);
        // Student's t: a normal over the root of a mean of squares.
        let squares: f64 = (0..TAILS as usize).map(|_| random.normal().powi(2)).sum();
        let longer = (TAILS / squares.max(f64::MIN_POSITIVE)).sqrt();
        let steps: Vec<f64> = (0..self.lower.len()).map(|_| longer * random.normal()).collect();
        let along = |row: &Vec<f64>| row.iter().zip(&steps).map(|(l, step)| l * step).sum::<f64>();
        self.centers[k].iter().zip(&self.lower).map(|(x, row)| x + along(row)).collect()
    }

    /// But for a constant.
    fn log_density(&self, place: &[f64]) -> f64 {
        let at = self.rounded(place);
        let power = -0.5 * (TAILS + at.len() as f64);
        let kernel = |center: &Vec<f64>| {
            let square: f64 = at.iter().zip(center).map(|(a, b)| (a - b).powi(2)).sum();
            (1.0 + square / TAILS).powf(power)
        };
        self.round.iter().map(kernel).sum::<f64>().ln()
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    /// A bent ridge in six unknowns, cut at a bound: the first is a normal one above -1, the second its square with
    /// little noise, the others normal and alike in pairs.
    fn ridge(x: &[f64]) -> f64 {
        if x[0] < -1.0 {
            return f64::NEG_INFINITY;
        }
        let square = |x: f64, sd: f64| -0.5 * (x / sd).powi(2);
        square(x[0], 1.0)
            + square(x[1] - x[0].powi(2), 0.3)
            + square(x[2], 2.0)
            + square(x[3] - x[2], 0.2)
            + square(x[4], 0.01)
            + square(x[5] - 10.0 * x[4], 0.05)
    }

    /// Ends of the 95 % interval, and the median, of an unknown.
    fn ends(weighted: &Weighted, unknown: usize) -> [f64; 3] {
        let drawn = weighted.drawn(4_000, &mut PixelRandom::new(9, 9));
        let mut values: Vec<f64> = drawn.iter().map(|place| place[unknown]).collect();
        values.sort_by(f64::total_cmp);
        [0.025, 0.5, 0.975].map(|share| values[(share * values.len() as f64) as usize])
    }

    fn start(seed: u32) -> Vec<Vec<f64>> {
        let mut random = PixelRandom::new(seed, 77);
        // About the top, far narrower than the density.
        (0..200)
            .map(|_| [1.0, 0.5, 0.5, 0.5, 0.02, 0.2].iter().map(|sd| 0.3 * sd * random.normal()).collect())
            .collect()
    }

    #[test]
    fn ends_of_intervals_are_those_of_the_density() {
        use statrs::distribution::{ContinuousCDF, Normal};
        let normal = Normal::new(0.0, 1.0).unwrap();
        let below = normal.cdf(-1.0);
        let cut = [0.025, 0.5, 0.975].map(|share| normal.inverse_cdf(below + share * (1.0 - below)));
        let mut sums = [0.0; 3];
        let seeds = 20;
        for seed in 0..seeds {
            let weighted = Weighted::of(start(seed), seed, &ridge).unwrap();
            assert!(weighted.worth >= ENOUGH, "{}", weighted.worth);
            for ((sum, found), exact) in sums.iter_mut().zip(ends(&weighted, 0)).zip(cut) {
                assert!((found - exact).abs() < 0.25, "{found} for {exact}");
                *sum += found - exact;
            }
            let [low, middle, high] = ends(&weighted, 2);
            assert!(
                (low + 3.92).abs() < 0.4 && middle.abs() < 0.25 && (high - 3.92).abs() < 0.4,
                "{low} {middle} {high}"
            );
            let (log, place) = weighted.top.unwrap();
            assert!(log > -2.0 && log <= 0.0 && (ridge(&place) - log).abs() < 1e-12);
        }
        // Four standard errors of the mean of as many ends, each known to 0.06.
        assert!(sums.iter().all(|sum| (sum / f64::from(seeds)).abs() < 0.06), "{sums:?}");
    }

    /// What a mixture leaves out the weights put right: without them the interval is another.
    #[test]
    fn draws_without_their_weights_are_not_of_the_density() {
        let mut weighted = Weighted::of(start(3), 3, &ridge).unwrap();
        weighted.weights.iter_mut().for_each(|weight| *weight = 1.0);
        let [low, ..] = ends(&weighted, 0);
        assert!(low < -1.1, "it is cut at -1: {low}");
    }

    #[test]
    fn places_in_a_plane_have_no_mixture() {
        let flat = (0..50).map(|k| vec![f64::from(k), 1.0]).collect();
        assert!(Weighted::of(flat, 1, &|_| 0.0).is_none());
        assert!(Weighted::of(Vec::new(), 1, &|_| 0.0).is_none());
    }
}
