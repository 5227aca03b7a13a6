//! Principal components: many numbers that move together, told by a few.
//!
//! Vectors y_k, k = 1..n, are y_k = mean + sum_j score_kj direction_j + rest, the directions those of most variance
//! (Jolliffe 2002). They come from the n x n matrix of inner products, for vectors are longer than they are many.

use faer::{Mat, Side};
use serde::{Deserialize, Serialize};

/// Shares of variance below which a direction is round-off.
const ROUND_OFF: f64 = 1e-13;

/// A mean and directions of most variance, of length 1 and at right angles.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Components {
    /// Mean of the vectors.
    pub mean: Vec<f64>,
    /// Directions, that of most variance first.
    pub directions: Vec<Vec<f64>>,
    /// Variance along each.
    pub variances: Vec<f64>,
}

impl Components {
    /// The first components of some vectors of one length; fewer than `most` where the rest is round-off.
    pub fn of(vectors: &[Vec<f64>], most: usize) -> Self {
        let n = vectors.len();
        let length = vectors.first().map_or(0, Vec::len);
        let mut mean = vec![0.0; length];
        for vector in vectors {
            mean.iter_mut().zip(vector).for_each(|(mean, v)| *mean += v / n as f64);
        }
        let apart = Mat::from_fn(n, length, |k, i| vectors[k][i] - mean[i]);
        let products = &apart * apart.transpose();
        let mut components = Self { mean, directions: Vec::new(), variances: Vec::new() };
        let Ok(eigen) = products.self_adjoint_eigen(Side::Lower) else { return components };
        let largest = (0..n).map(|j| eigen.S()[j]).fold(0.0, f64::max);
        // Eigenvalues rise.
        for j in (0..n).rev().take(most) {
            let value = eigen.S()[j];
            if value <= ROUND_OFF * largest {
                break;
            }
            let direction = apart.transpose() * eigen.U().col(j);
            let norm = value.sqrt();
            components.directions.push((0..length).map(|i| direction[i] / norm).collect());
            components.variances.push(value / (n as f64 - 1.0).max(1.0));
        }
        components
    }

    /// Scores of a vector along the directions.
    pub fn scores(&self, vector: &[f64]) -> Vec<f64> {
        let along = |direction: &Vec<f64>| -> f64 {
            direction.iter().zip(vector.iter().zip(&self.mean)).map(|(d, (v, mean))| d * (v - mean)).sum()
        };
        self.directions.iter().map(along).collect()
    }

    /// The vector of some scores.
    pub fn vector(&self, scores: &[f64]) -> Vec<f64> {
        let mut vector = self.mean.clone();
        for (direction, score) in self.directions.iter().zip(scores) {
            vector.iter_mut().zip(direction).for_each(|(v, d)| *v += score * d);
        }
        vector
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Twelve vectors in a plane through (1, 1, ..): two components hold them, whatever is asked for.
    #[test]
    fn vectors_of_a_plane_have_two_components() {
        let length = 30;
        let vector = |k: usize| -> Vec<f64> {
            let (a, b) = ((k as f64).sin(), 0.1 * (k as f64 * 1.7).cos());
            (0..length).map(|i| 1.0 + a * (0.3 * i as f64).cos() + b * (0.2 * i as f64).sin()).collect()
        };
        let vectors: Vec<Vec<f64>> = (0..12).map(vector).collect();
        let components = Components::of(&vectors, 5);
        assert_eq!(components.directions.len(), 2);
        let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let [first, second] = [&components.directions[0], &components.directions[1]];
        assert!((product(first, first) - 1.0).abs() < 1e-12 && product(first, second).abs() < 1e-7);
        for vector in &vectors {
            let back = components.vector(&components.scores(vector));
            assert!(back.iter().zip(vector).all(|(a, b)| (a - b).abs() < 1e-9));
        }
        // Variance along the first: that of the scores.
        let scores: Vec<f64> = vectors.iter().map(|vector| components.scores(vector)[0]).collect();
        let variance = scores.iter().map(|s| s * s).sum::<f64>() / 11.0;
        assert!((variance / components.variances[0] - 1.0).abs() < 1e-9);
        assert!(components.variances[0] > components.variances[1]);
        // One component loses what the second holds.
        let one = Components::of(&vectors, 1);
        let lost: f64 = vectors
            .iter()
            .map(|v| {
                let back = one.vector(&one.scores(v));
                back.iter().zip(v).map(|(a, b)| (a - b).powi(2)).sum::<f64>()
            })
            .sum();
        assert!((lost / 11.0 / components.variances[1] - 1.0).abs() < 1e-6);
    }

    #[test]
    fn vectors_that_are_alike_have_none() {
        let components = Components::of(&vec![vec![1.0, 2.0]; 4], 3);
        assert_eq!((components.mean, components.directions.len()), (vec![1.0, 2.0], 0));
    }
}
