//! Designs: which points of the unit cube a sweep computes.
//!
//! Latin hypercubes: McKay, Beckman and Conover, Technometrics 21(2), 1979. Sobol: Owen-scrambled by hashing (Burley,
//! JCGT 9(4), 2020). Morris trajectories: Morris, Technometrics 33(2), 1991. Saltelli: Saltelli et al., Computer
//! Physics Communications 181(2), 2010.

use super::sensitivity::{BASE_POINTS, TRAJECTORIES};
use crate::camera::noise::PixelRandom;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// Most points of a design.
pub const MOST_POINTS: u64 = 1_000_000;
/// Most points of a Sobol sequence, and its dimensions.
const SOBOL: (u32, u32) = (1 << 16, sobol_burley::NUM_DIMENSIONS);
/// Levels of what a Morris design draws; a list has one for each of its values.
const LEVELS: u32 = 4;

/// Which points are computed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields, tag = "kind")]
pub enum Design {
    /// Every value of each variable with every value of the others; the last variable changes fastest.
    Grid {},
    /// One point in each of as many strips along every variable.
    LatinHypercube {
        /// Points.
        points: u32,
        /// Seed.
        #[serde(default)]
        seed: u32,
    },
    /// A scrambled Sobol sequence, at most 65536 points: even at any number of points, best at powers of two.
    Sobol {
        /// Points.
        points: u32,
        /// Seed of the scrambling.
        #[serde(default)]
        seed: u32,
    },
    /// Independent draws.
    Random {
        /// Points.
        points: u32,
        /// Seed.
        #[serde(default)]
        seed: u32,
    },
    /// Trajectories that change one variable after the other: which variables matter at all.
    Morris {
        /// Trajectories, at least 6; each takes a point more than there are variables.
        trajectories: u32,
        /// Seed.
        #[serde(default)]
        seed: u32,
    },
    /// Saltelli's design of Sobol indices: `points` times as many points as there are variables and two more.
    Saltelli {
        /// Base points, at least 64.
        points: u32,
        /// Seed.
        #[serde(default)]
        seed: u32,
    },
    /// The rows of a table, whose columns are variables or keys.
    Csv {
        /// The table, relative to the sweep's folder.
        file: PathBuf,
    },
}

/// Points of the unit cube; row after row, each is computed when it is asked for.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Units {
    /// Indices into lists of these lengths.
    Grid(Vec<usize>),
    /// Strips of each dimension.
    LatinHypercube {
        strips: Vec<Vec<u32>>,
        seed: u32,
    },
    Sobol {
        dimensions: u32,
        seed: u32,
    },
    Random {
        dimensions: u32,
        seed: u32,
    },
    /// With so many levels of each dimension.
    Morris {
        levels: Vec<u32>,
        seed: u32,
    },
    Saltelli {
        dimensions: u32,
        seed: u32,
    },
}

/// Random numbers of a design, apart from all else that a seed is used for.
fn random(seed: u32, row: u32) -> PixelRandom {
    PixelRandom::new(seed ^ 0x5eed_de51, row)
}

fn below(random: &mut PixelRandom, count: usize) -> usize {
    ((random.uniform() * count as f64) as usize).min(count.saturating_sub(1))
}

/// A random order of 0..count (Fisher and Yates).
fn shuffled(random: &mut PixelRandom, count: u32) -> Vec<u32> {
    let mut order: Vec<u32> = (0..count).collect();
    for k in (1..order.len()).rev() {
        order.swap(k, below(random, k + 1));
    }
    order
}

/// A scrambled Sobol number strictly between 0 and 1.
fn sobol(row: u32, dimension: u32, seed: u32) -> f64 {
    // Single precision: half a step up keeps it off both ends.
    f64::from(sobol_burley::sample(row, dimension, seed)) + 0.5 / f64::from(1u32 << 24)
}

impl Design {
    /// How many rows belong together where so many variables are drawn: those of a trajectory, or of a base point. None
    /// where each stands by itself.
    pub fn block(&self, variables: usize) -> Option<usize> {
        match self {
            Self::Morris { .. } => Some(variables + 1),
            Self::Saltelli { .. } => Some(variables + 2),
            _ => None,
        }
    }

    /// Points of the unit cube of so many dimensions, and how many; lists have these lengths in a grid.
    pub(super) fn units(&self, lists: &[usize]) -> Result<(Units, usize), String> {
        let dimensions = lists.len() as u32;
        let (units, count) = match *self {
            Self::Grid {} => {
                let count = lists.iter().try_fold(1u64, |count, length| count.checked_mul(*length as u64));
                (Units::Grid(lists.to_vec()), count.unwrap_or(u64::MAX))
            }
            Self::LatinHypercube { points, seed } => {
                let fits = u64::from(points) <= MOST_POINTS;
                let strips = (0..dimensions).map(|k| shuffled(&mut random(seed, k), if fits { points } else { 0 }));
                (Units::LatinHypercube { strips: strips.collect(), seed }, points.into())
            }
            Self::Sobol { points, seed } => {
                sobol_fits(points, dimensions)?;
                (Units::Sobol { dimensions, seed }, points.into())
            }
            Self::Random { points, seed } => (Units::Random { dimensions, seed }, points.into()),
            Self::Morris { trajectories, seed } => {
                let levels = lists.iter().map(|&length| if length > 0 { length as u32 } else { LEVELS }).collect();
                enough(trajectories, TRAJECTORIES, "morris needs", "trajectories")?;
                (Units::Morris { levels, seed }, u64::from(trajectories) * u64::from(dimensions + 1))
            }
            Self::Saltelli { points, seed } => {
                sobol_fits(points, 2 * dimensions)?;
                enough(points, BASE_POINTS, "saltelli needs", "base points")?;
                (Units::Saltelli { dimensions, seed }, u64::from(points) * u64::from(dimensions + 2))
            }
            // Its table has the points.
            Self::Csv { .. } => (Units::Grid(Vec::new()), 1),
        };
        match count {
            0 => Err("has no points".into()),
            count if count > MOST_POINTS => Err(format!("has {count} points; at most {MOST_POINTS} are computed")),
            count => Ok((units, count as usize)),
        }
    }
}

/// Designs that are for sensitivities alone are not computed where these cannot be told.
fn enough(count: u32, least: u32, needs: &str, what: &str) -> Result<(), String> {
    match count >= least {
        true => Ok(()),
        false => Err(format!("{needs} at least {least} {what}, for intervals that hold; has {count}")),
    }
}

fn sobol_fits(points: u32, dimensions: u32) -> Result<(), String> {
    let (most_points, most_dimensions) = SOBOL;
    if points > most_points {
        return Err(format!("has {points} points of a Sobol sequence, which has {most_points}"));
    }
    if dimensions > most_dimensions {
        return Err(format!("takes {dimensions} dimensions of a Sobol sequence, which has {most_dimensions}"));
    }
    Ok(())
}

impl Units {
    /// A point, each coordinate strictly between 0 and 1.
    pub fn point(&self, row: usize) -> Vec<f64> {
        let at = row as u32;
        match self {
            Self::Grid(lengths) => {
                let mut left = row;
                let mut point: Vec<f64> = lengths
                    .iter()
                    .rev()
                    .map(|&length| {
                        let place = left % length;
                        left /= length;
                        (place as f64 + 0.5) / length as f64
                    })
                    .collect();
                point.reverse();
                point
            }
            Self::LatinHypercube { strips, seed } => {
                // Beyond the streams of the permutations.
                let mut random = random(!seed, at);
                let place = |strip: &Vec<u32>| {
                    let strip_of_row = strip.get(row).copied().unwrap_or(0);
                    (f64::from(strip_of_row) + random.uniform()) / strip.len() as f64
                };
                strips.iter().map(place).collect()
            }
            Self::Sobol { dimensions, seed } => (0..*dimensions).map(|k| sobol(at, k, *seed)).collect(),
            Self::Random { dimensions, seed } => {
                let mut random = random(*seed, at);
                (0..*dimensions).map(|_| random.uniform()).collect()
            }
            Self::Morris { levels: of, seed } => {
                let dimensions = of.len() as u32;
                let (trajectory, step) = (at / (dimensions + 1), at % (dimensions + 1));
                let mut random = random(*seed, trajectory);
                let mut levels: Vec<u32> = of.iter().map(|&count| below(&mut random, count as usize) as u32).collect();
                let order = shuffled(&mut random, dimensions);
                for &moved in order.iter().take(step as usize) {
                    if let (Some(level), Some(count)) = (levels.get_mut(moved as usize), of.get(moved as usize)) {
                        *level = (*level + count / 2) % count;
                    }
                }
                levels.iter().zip(of).map(|(&level, &count)| (f64::from(level) + 0.5) / f64::from(count)).collect()
            }
            Self::Saltelli { dimensions, seed } => {
                let (base, block) = (at / (dimensions + 2), at % (dimensions + 2));
                // Block 0 is A, block k + 1 is A with B's column k, the last one is B.
                let of_b = |k: u32| block == dimensions + 1 || block == k + 1;
                (0..*dimensions).map(|k| sobol(base, if of_b(k) { dimensions + k } else { k }, *seed)).collect()
            }
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    fn points(design: &Design, lists: &[usize]) -> Vec<Vec<f64>> {
        let (units, count) = design.units(lists).unwrap();
        (0..count).map(|row| units.point(row)).collect()
    }

    #[test]
    fn a_grid_counts_its_last_variable_fastest() {
        let found = points(&Design::Grid {}, &[2, 3]);
        let indices: Vec<_> = found.iter().map(|p| [(p[0] * 2.0) as u8, (p[1] * 3.0) as u8]).collect();
        assert_eq!(indices, [[0, 0], [0, 1], [0, 2], [1, 0], [1, 1], [1, 2]]);
    }

    #[test]
    fn a_latin_hypercube_has_one_point_in_each_strip() {
        let found = points(&Design::LatinHypercube { points: 50, seed: 3 }, &[0; 4]);
        for k in 0..4 {
            let mut strips: Vec<usize> = found.iter().map(|point| (point[k] * 50.0) as usize).collect();
            strips.sort_unstable();
            assert_eq!(strips, (0..50).collect::<Vec<_>>());
        }
        assert_ne!(found, points(&Design::LatinHypercube { points: 50, seed: 4 }, &[0; 4]));
    }

    #[test]
    fn a_sobol_sequence_is_evener_than_random_points() {
        // The integral of a smooth function, exactly 1, over eight scramblings.
        let error = |design: &dyn Fn(u32) -> Design| {
            let square = |seed| {
                let found = points(&design(seed), &[0; 3]);
                let value = |point: &Vec<f64>| point.iter().map(|x| 0.5 + x).product::<f64>();
                (found.iter().map(value).sum::<f64>() / found.len() as f64 - 1.0).powi(2)
            };
            ((0..8).map(square).sum::<f64>() / 8.0).sqrt()
        };
        let sobol = error(&|seed| Design::Sobol { points: 1024, seed });
        let random = error(&|seed| Design::Random { points: 1024, seed });
        // Standard deviation of the mean of 1024: sqrt((13/12)^3 - 1) / 32 = 0.0163.
        assert!(sobol < 0.001 && (0.008..0.033).contains(&random), "{sobol} {random}");
    }

    #[test]
    fn a_trajectory_changes_one_variable_at_a_time_by_half_the_range() {
        let found = points(&Design::Morris { trajectories: 20, seed: 1 }, &[0; 5]);
        assert_eq!(found.len(), 120);
        for trajectory in found.chunks(6) {
            let mut moved: Vec<usize> = trajectory
                .windows(2)
                .map(|pair| {
                    let steps: Vec<f64> = (0..5).map(|k| pair[1][k] - pair[0][k]).collect();
                    assert_eq!(steps.iter().filter(|step| **step != 0.0).count(), 1);
                    assert!(steps.iter().all(|step| *step == 0.0 || step.abs() == 0.5));
                    steps.iter().position(|step| *step != 0.0).unwrap()
                })
                .collect();
            moved.sort_unstable();
            assert_eq!(moved, [0, 1, 2, 3, 4]);
        }
    }

    #[test]
    fn a_trajectory_draws_each_value_of_a_list_as_often() {
        for length in [2, 3, 5, 8] {
            let found = points(&Design::Morris { trajectories: 2000, seed: 1 }, &[length, 0]);
            let mut counts = vec![0; length];
            found.iter().for_each(|point| counts[(point[0] * length as f64) as usize] += 1);
            // Each place of 6,000, half of which are moved ones: a binomial's spread, sixfold.
            let (each, of) = (6000.0 / length as f64, 6.0 * (6000.0 / length as f64).sqrt());
            assert!(counts.iter().all(|count| (f64::from(*count) - each).abs() < of), "{counts:?}");
            let steps = found.chunks(3).map(|one| (one[2][0] - one[0][0]).abs() * length as f64);
            let half = length / 2;
            assert!(steps.into_iter().all(|step| [half, length - half].contains(&(step.round() as usize))));
        }
    }

    #[test]
    fn saltellis_blocks_share_columns_with_a_and_b() {
        let found = points(&Design::Saltelli { points: 64, seed: 1 }, &[0; 3]);
        for base in found.chunks(5) {
            let [a, blocks @ .., b] = base else { panic!() };
            for (k, block) in blocks.iter().enumerate() {
                assert!((0..3).all(|j| block[j] == if j == k { b[j] } else { a[j] }));
                assert_ne!(a[k], b[k]);
            }
        }
    }

    #[test]
    fn every_coordinate_lies_inside_and_each_seed_gives_its_own() {
        for (one, other) in [
            (Design::Sobol { points: 4096, seed: 1 }, Design::Sobol { points: 4096, seed: 2 }),
            (Design::Random { points: 4096, seed: 1 }, Design::Random { points: 4096, seed: 2 }),
        ] {
            let [one, other] = [one, other].map(|design| points(&design, &[0; 6]));
            assert!(one.iter().flatten().all(|u| *u > 0.0 && *u < 1.0));
            assert_ne!(one, other);
        }
    }

    #[test]
    fn a_design_beyond_reason_is_refused() {
        for (design, lists, said) in [
            (Design::Grid {}, vec![1000, 1000, 1000], "1000000000 points"),
            (Design::Grid {}, vec![usize::MAX, 9], "points; at most"),
            (Design::Random { points: 0, seed: 0 }, vec![0], "has no points"),
            (Design::LatinHypercube { points: u32::MAX, seed: 0 }, vec![0], "at most"),
            (Design::Sobol { points: 70_000, seed: 0 }, vec![0], "which has 65536"),
            (Design::Saltelli { points: 8, seed: 0 }, vec![0; 200], "which has 256"),
            (Design::Saltelli { points: 63, seed: 0 }, vec![0], "at least 64 base points"),
            (Design::Morris { trajectories: 5, seed: 0 }, vec![0], "at least 6 trajectories"),
            (Design::Morris { trajectories: u32::MAX, seed: 0 }, vec![0; 9], "at most"),
        ] {
            let found = design.units(&lists).unwrap_err();
            assert!(found.contains(said), "{found}");
        }
    }
}
