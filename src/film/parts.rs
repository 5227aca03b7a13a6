//! Mean radiances of a few regions in a few groups of replicates: small enough for the header of a file.
//!
//! Two films of one seed and the same work share their random numbers, replicate by replicate. What changed between
//! them then shows in the differences of their replicates, far below the noise of either film.

use super::Film;
use serde::{Deserialize, Serialize};

/// Regions along x and y.
pub const REGIONS: [usize; 2] = [4, 3];
/// Most groups kept.
const MOST: usize = 16;

/// Mean radiances of the regions in each group of replicates.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Parts {
    /// Replicates of each group.
    pub replicates: Vec<u32>,
    /// Mean radiance of each region, row-major, for one group after the other, W/(m^2 sr).
    #[serde(with = "floats")]
    pub radiance: Vec<f32>,
}

/// Bytes of f32, the lowest first, in base64.
mod floats {
    use base64::{Engine, engine::general_purpose::STANDARD};
    use serde::{Deserialize, Deserializer, Serializer, de::Error};

    pub fn serialize<S: Serializer>(values: &[f32], serializer: S) -> Result<S::Ok, S::Error> {
        let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        serializer.serialize_str(&STANDARD.encode(bytes))
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<f32>, D::Error> {
        let text = String::deserialize(deserializer)?;
        let bytes = STANDARD.decode(text).map_err(D::Error::custom)?;
        let float = |four: &[u8]| four.try_into().map(f32::from_le_bytes).map_err(D::Error::custom);
        bytes.chunks(4).map(float).collect()
    }
}

impl Parts {
    /// Of a film with groups of replicates; empty where it has none. Neighbouring groups are joined until they are
    /// few.
    pub(super) fn of(film: &Film) -> Self {
        let region = Regions { size: [film.width, film.height].map(|edge| edge as usize) };
        let mut groups: Vec<(u32, Vec<f64>)> =
            film.groups.iter().map(|group| (group.replicates, region.means(&group.mean))).collect();
        while groups.len() > MOST {
            groups = groups.chunks(2).map(joined).collect();
        }
        Self {
            replicates: groups.iter().map(|(replicates, _)| *replicates).collect(),
            radiance: groups.iter().flat_map(|(_, means)| means.iter().map(|&mean| mean as f32)).collect(),
        }
    }

    /// Whether it holds as many finite numbers as it says.
    #[must_use]
    pub fn is_whole(&self) -> bool {
        self.radiance.len() == self.replicates.len() * REGIONS[0] * REGIONS[1]
            && self.radiance.iter().all(|value| value.is_finite())
            && self.replicates.iter().all(|&replicates| replicates > 0)
    }

    /// The radiances of one region, a group after the other.
    pub(super) fn region(&self, index: usize) -> impl Iterator<Item = f64> {
        self.radiance.iter().skip(index).step_by(REGIONS[0] * REGIONS[1]).map(|&value| f64::from(value))
    }
}

fn joined(pair: &[(u32, Vec<f64>)]) -> (u32, Vec<f64>) {
    let replicates = pair.iter().map(|(replicates, _)| replicates).sum::<u32>();
    let cells = pair.first().map_or(0, |(_, means)| means.len());
    let mean = |k: usize| {
        let sum: f64 = pair.iter().filter_map(|(n, means)| means.get(k).map(|mean| f64::from(*n) * mean)).sum();
        sum / f64::from(replicates.max(1))
    };
    (replicates, (0..cells).map(mean).collect())
}

/// How pixels fall into regions.
struct Regions {
    size: [usize; 2],
}

impl Regions {
    fn means(&self, image: &[f32]) -> Vec<f64> {
        let [width, height] = self.size;
        let mut sums = vec![(0.0, 0.0_f64); REGIONS[0] * REGIONS[1]];
        for (index, &value) in image.iter().enumerate() {
            let region = index / width * REGIONS[1] / height * REGIONS[0] + index % width * REGIONS[0] / width;
            if let Some((sum, count)) = sums.get_mut(region) {
                *sum += f64::from(value);
                *count += 1.0;
            }
        }
        sums.into_iter().map(|(sum, count)| sum / count.max(1.0)).collect()
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::film::BlockAccumulator;

    #[test]
    fn few_groups_keep_the_means_of_the_regions() {
        let mut sums = BlockAccumulator::new(8, 6);
        for replicate in 0..17_u32 {
            let image = (0..48_u32).map(|k| f64::from(replicate) + f64::from(k % 8 / 2 + 4 * (k / 8 / 2)));
            sums.add(&image.collect::<Vec<_>>()).unwrap();
        }
        let parts = sums.finish().parts;
        assert!(parts.is_whole());
        assert_eq!(parts.replicates, [2, 2, 2, 2, 2, 2, 2, 2, 1]);
        assert_eq!(parts.region(5).collect::<Vec<_>>(), [5.5, 7.5, 9.5, 11.5, 13.5, 15.5, 17.5, 19.5, 21.0]);
        let json = serde_json::to_string(&parts).unwrap();
        assert_eq!(serde_json::from_str::<Parts>(&json).unwrap(), parts);
        assert!(!Parts { replicates: vec![1; 3], ..parts }.is_whole());
    }
}
