//! Images of a few groups of replicates: what any figure of an image needs to know its own error.
//!
//! A variance per pixel does not say how neighbours move together. The figures of an image (sums, centroids, areas
//! above a threshold) leave out one group at a time and take the spread (the jackknife, Tukey 1958): no model of the
//! correlation is needed. Replicates fill at most [`MOST_GROUPS`] groups; when these are full, neighbours are joined,
//! so memory is bounded.

/// Most groups kept. 16 to 31 replicates are the rule, and each is then a group of its own.
pub const MOST_GROUPS: usize = 32;

/// The mean image of a few replicates.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Group {
    /// Replicates in it.
    pub replicates: u32,
    /// Mean radiance of each pixel over them, row-major, W/(m^2 sr).
    pub mean: Vec<f32>,
}

/// Groups that are being filled, all but the last with as many replicates.
#[derive(Debug, Clone)]
pub(super) struct Groups {
    /// Replicates of a full group.
    full: u32,
    groups: Vec<Group>,
}

impl Groups {
    pub fn new() -> Self {
        Self { full: 1, groups: Vec::new() }
    }

    pub fn add(&mut self, replicate: &[f64]) {
        if self.groups.last().is_none_or(|group| group.replicates >= self.full) {
            if self.groups.len() == MOST_GROUPS {
                self.join();
            }
            self.groups.push(Group { replicates: 0, mean: vec![0.0; replicate.len()] });
        }
        if let Some(group) = self.groups.last_mut() {
            group.replicates += 1;
            let share = 1.0 / f64::from(group.replicates);
            for (mean, value) in group.mean.iter_mut().zip(replicate) {
                *mean += ((value - f64::from(*mean)) * share) as f32;
            }
        }
    }

    pub fn finish(&self) -> Vec<Group> {
        self.groups.clone()
    }

    /// Joins neighbours of a full set into groups of twice the size.
    fn join(&mut self) {
        self.full *= 2;
        let joined = self.groups.chunks(2).map(|pair| match pair {
            [a, b] => Group {
                replicates: a.replicates + b.replicates,
                mean: a.mean.iter().zip(&b.mean).map(|(a, b)| 0.5 * (a + b)).collect(),
            },
            rest => rest.first().cloned().unwrap_or_default(),
        });
        self.groups = joined.collect();
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn groups_are_few_and_hold_the_mean_of_all_replicates() {
        let mut groups = Groups::new();
        let count = 5 * MOST_GROUPS as u32 + 3;
        for replicate in 0..count {
            groups.add(&[f64::from(replicate), 1.0]);
        }
        let groups = groups.finish();
        assert!(groups.len() <= MOST_GROUPS && groups.len() > MOST_GROUPS / 2);
        assert_eq!(groups.iter().map(|group| group.replicates).sum::<u32>(), count);
        assert!(groups[..groups.len() - 1].iter().all(|group| group.replicates == groups[0].replicates));
        let sum: f64 = groups.iter().map(|group| f64::from(group.replicates) * f64::from(group.mean[0])).sum();
        // Means of small whole numbers: exact in f32 but for the last group's thirds.
        assert!((sum / f64::from(count) - f64::from(count - 1) / 2.0).abs() < 1e-4);
    }

    #[test]
    fn few_replicates_are_groups_of_their_own() {
        let mut groups = Groups::new();
        (0..20).for_each(|replicate| groups.add(&[f64::from(replicate)]));
        let expected: Vec<f32> = (0..20u8).map(f32::from).collect();
        assert_eq!(groups.finish().iter().map(|group| group.mean[0]).collect::<Vec<_>>(), expected);
    }
}
