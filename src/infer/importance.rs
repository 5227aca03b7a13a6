//! Draws of a density by importance: from mixtures of kernels with heavy tails that are fitted to it round after round
//! (West, J. R. Stat. Soc. B 55(2), 1993), weighed by the density over the mixtures'.
//!
//! A chain of the same work keeps the shape of its start for longer than it runs where the density is a long, bent
//! ridge, as that of modulus and size is: its intervals lacked their far ends. Here every draw is independent, and how
//! many they are worth is known.

use crate::camera::noise::PixelRandom;
use crate::emulate::weighted_points::{Student, WeightedPoints};
use faer::linalg::solvers::Llt;
use faer::{Mat, Side};
use rayon::prelude::*;

/// Kernels of a mixture, and their degrees of freedom.
const KERNELS: usize = 128;
const TAILS: u32 = 5;
/// What kernels are wider by than those that smooth a cloud best, so that they reach beyond it.
const REACH: f64 = 1.3;
/// Share of the draws from kernels that are wider yet, and their width in that of the cloud.
const WIDE: f64 = 0.1;
const WIDTH: f64 = 1.5;
/// Draws of a round, the fewest rounds that count, and the most.
const DRAWS: usize = 6_000;
const LEAST: usize = 2;
const ROUNDS: usize = 8;
/// Independent draws that suffice.
const ENOUGH: f64 = 3_000.0;

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
        // Of all draws: logarithms of the density, and the mixtures' densities together.
        let (mut mixtures, mut logs, mut reached) = (Vec::<Mixture>::new(), Vec::new(), Vec::new());
        for round in 0..ROUNDS {
            let mut random = PixelRandom::new(seed, round as u32);
            let mixture = Mixture::of(&cloud, &mut random)?;
            let drawn: Vec<Vec<f64>> = (0..DRAWS).map(|_| mixture.draw(&mut random)).collect();
            let found: Vec<f64> = drawn.par_iter().map(|place| log_density(place)).collect();
            // The first mixture is of a guess, and drops out.
            if round <= 1 {
                (mixtures, logs, reached, cloud.places) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
            }
            let by_this = |(place, sum): (&Vec<f64>, f64)| sum + mixture.density(place);
            reached = cloud.places.par_iter().zip(reached).map(by_this).collect();
            mixtures.push(mixture);
            let by_all = |place: &Vec<f64>| mixtures.iter().map(|mixture| mixture.density(place)).sum::<f64>();
            reached.par_extend(drawn.par_iter().map(by_all));
            logs.extend(found);
            cloud.places.extend(drawn);
            cloud.weigh(&reached, &logs)?;
            if mixtures.len() >= LEAST && cloud.worth >= ENOUGH {
                break;
            }
        }
        Some(cloud)
    }

    /// Weighs all draws by what all their mixtures reach them with: one that a mixture hardly reached, and another did,
    /// weighs little more than its neighbours (Cornuet et al., Scand. J. Stat. 39(4), 2012).
    fn weigh(&mut self, reached: &[f64], logs: &[f64]) -> Option<()> {
        let off = |(log, reached): (&f64, &f64)| if log.is_finite() { log - reached.ln() } else { f64::NEG_INFINITY };
        let off: Vec<f64> = logs.iter().zip(reached).map(off).collect();
        let most = off.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let best = (0..logs.len()).max_by(|&a, &b| logs[a].total_cmp(&logs[b])).filter(|_| most.is_finite())?;
        self.weights = off.iter().map(|off| (off - most).exp()).collect();
        self.worth = worth(&self.weights);
        self.top = Some((logs[best], self.places[best].clone()));
        Some(())
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

/// Kernels of one shape about some of the draws, and wide ones about the same.
struct Mixture {
    narrow: Kernels,
    wide: Kernels,
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
        let lower: Vec<Vec<f64>> = (0..unknowns).map(|i| (0..=i).map(|j| factor.L()[(i, j)]).collect()).collect();
        // In a plane only rounding is left of a direction.
        let flat = |(i, row): (usize, &Vec<f64>)| row[i] <= 1e-7 * covariance[(i, i)].sqrt();
        if lower.iter().enumerate().any(flat) {
            return None;
        }
        // Silverman's width; centers drawn in keep the cloud's covariance.
        let (d, worth) = (unknowns as f64, worth(&cloud.weights).min(KERNELS as f64));
        let width = (REACH * (4.0 / ((d + 2.0) * worth)).powf(1.0 / (d + 4.0))).min(0.95);
        let shrunk = (1.0 - width * width).sqrt();
        let centers = cloud.drawn(KERNELS, random);
        let inward = |place: &Vec<f64>| place.iter().zip(&mean).map(|(x, mean)| mean + shrunk * (x - mean)).collect();
        let drawn_in = centers.iter().map(inward).collect();
        Some(Self { narrow: Kernels::of(drawn_in, &lower, width), wide: Kernels::of(centers, &lower, WIDTH) })
    }

    fn draw(&self, random: &mut PixelRandom) -> Vec<f64> {
        let kernels = if random.uniform() < WIDE { &self.wide } else { &self.narrow };
        kernels.draw(random)
    }

    /// But for a factor that all mixtures share.
    fn density(&self, place: &[f64]) -> f64 {
        (1.0 - WIDE) * self.narrow.density(place) + WIDE * self.wide.density(place)
    }
}

/// Kernels of one shape.
struct Kernels {
    centers: Vec<Vec<f64>>,
    /// The same in units in which a kernel is round.
    round: WeightedPoints,
    /// Lower triangle of the kernels' shape, row after row.
    lower: Vec<Vec<f64>>,
    /// One over the volume of that shape.
    dense: f64,
}

impl Kernels {
    fn of(centers: Vec<Vec<f64>>, shape: &[Vec<f64>], width: f64) -> Self {
        let lower: Vec<Vec<f64>> = shape.iter().map(|row| row.iter().map(|l| width * l).collect()).collect();
        let dense = 1.0 / lower.iter().filter_map(|row| row.last()).product::<f64>();
        let round = WeightedPoints::new(lower.len(), centers.iter().map(|center| (rounded(&lower, center), 1.0)));
        Self { round, centers, lower, dense }
    }

    fn draw(&self, random: &mut PixelRandom) -> Vec<f64> {
        let k = ((random.uniform() * self.centers.len() as f64) as usize).min(self.centers.len() - 1);
        // Student's t: a normal over the root of a mean of squares.
        let squares: f64 = (0..TAILS).map(|_| random.normal().powi(2)).sum();
        let longer = (f64::from(TAILS) / squares.max(f64::MIN_POSITIVE)).sqrt();
        let steps: Vec<f64> = (0..self.lower.len()).map(|_| longer * random.normal()).collect();
        let along = |row: &Vec<f64>| row.iter().zip(&steps).map(|(l, step)| l * step).sum::<f64>();
        self.centers[k].iter().zip(&self.lower).map(|(x, row)| x + along(row)).collect()
    }

    fn density(&self, place: &[f64]) -> f64 {
        let at = rounded(&self.lower, place);
        let profile = Student { freedom: TAILS, dimensions: at.len() as u32 };
        self.dense * self.round.sum(&at, profile)
    }
}

/// A place in units in which kernels of this shape are round.
fn rounded(lower: &[Vec<f64>], place: &[f64]) -> Vec<f64> {
    let mut out: Vec<f64> = Vec::with_capacity(place.len());
    for (row, x) in lower.iter().zip(place) {
        let known: f64 = row.iter().zip(&out).map(|(l, z)| l * z).sum();
        out.push((x - known) / row.last().copied().unwrap_or(1.0));
    }
    out
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::super::ensemble::Ensemble;
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

    /// Where walkers are after the steps of an inversion, from the best of draws over a box.
    fn start(seed: u32) -> Vec<Vec<f64>> {
        let mut random = PixelRandom::new(seed, 77);
        let box_of = [4.0, 4.0, 8.0, 8.0, 0.04, 0.4];
        let drawn =
            |random: &mut PixelRandom| box_of.iter().map(|half| half * (2.0 * random.uniform() - 1.0)).collect();
        let mut places: Vec<Vec<f64>> = (0..4000).map(|_| drawn(&mut random)).collect();
        places.sort_by(|a, b| ridge(b).total_cmp(&ridge(a)));
        places.truncate(64);
        let mut ensemble = Ensemble::new(places, seed, &ridge);
        let mut cloud = Vec::new();
        for step in 0..300 {
            ensemble.step(&ridge);
            if step >= 225 && step % 5 == 0 {
                cloud.extend(ensemble.walkers.iter().map(|(place, _)| place.clone()));
            }
        }
        cloud
    }

    #[test]
    fn ends_of_intervals_are_those_of_the_density() {
        use statrs::distribution::{ContinuousCDF, Normal};
        let normal = Normal::new(0.0, 1.0).unwrap();
        let below = normal.cdf(-1.0);
        let cut = [0.025, 0.5, 0.975].map(|share| normal.inverse_cdf(below + share * (1.0 - below)));
        let seeds = 12;
        let off = |seed: u32| {
            let weighted = Weighted::of(start(seed), seed, &ridge).unwrap();
            assert!(weighted.worth >= ENOUGH, "{}", weighted.worth);
            let (log, place) = weighted.top.clone().unwrap();
            assert!(log > -2.0 && log <= 0.0 && (ridge(&place) - log).abs() < 1e-12);
            let straight = ends(&weighted, 2);
            let straight = straight.iter().zip([-3.92, 0.0, 3.92]).map(|(a, b)| (a - b).abs() / 2.0);
            assert!(straight.fold(0.0, f64::max) < 0.25);
            let found = ends(&weighted, 0);
            [0, 1, 2].map(|k| found[k] - cut[k])
        };
        let all: Vec<[f64; 3]> = (0..seeds).into_par_iter().map(off).collect();
        let mean = |k: usize| all.iter().map(|off| off[k]).sum::<f64>() / f64::from(seeds);
        let most = |k: usize| all.iter().map(|off| off[k].abs()).fold(0.0, f64::max);
        // The far end lies in the arm of the ridge that is bent most, and comes out a tenth short.
        assert!([0, 1].iter().all(|&k| mean(k).abs() < 0.03 && most(k) < 0.12), "{} {}", mean(0), mean(1));
        assert!(mean(2).abs() < 0.2 && most(2) < 0.5, "{} {}", mean(2), most(2));
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
        let flat = (0..50).map(|k| vec![f64::from(k), 0.1 * f64::from(k)]).collect();
        assert!(Weighted::of(flat, 1, &|_| 0.0).is_none());
        assert!(Weighted::of(Vec::new(), 1, &|_| 0.0).is_none());
    }
}
