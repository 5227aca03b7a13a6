//! Chebyshev's polynomial in the matrix over its diagonal blocks: a smoother that is the same for any number of threads
//! (Adams, Brezina, Hu and Tuminaro, J. Comput. Phys. 188, 593, 2003).

use super::blocks::{Block, BlockMatrix, inverse};
use rayon::prelude::*;

/// Steps of a smoothing, and the largest over the least eigenvalue that it damps.
const DEGREE: usize = 3;
const RANGE: f32 = 10.0;
/// Steps of the power method, and the room above what it finds.
const POWER: usize = 12;
const ROOM: f32 = 1.1;

/// A smoother of one matrix.
#[derive(Debug, Clone)]
pub struct Smoother {
    inverse: Vec<Block>,
    /// Largest eigenvalue of the matrix over its diagonal.
    pub largest: f32,
}

impl Smoother {
    /// Of a matrix.
    pub fn new(matrix: &BlockMatrix) -> Self {
        let inverse = (0..matrix.nodes()).into_par_iter().map(|row| inverse(&matrix.diagonal(row))).collect();
        let mut smoother = Self { inverse, largest: 1.0 };
        smoother.largest = ROOM * smoother.power(matrix);
        smoother
    }

    /// The inverse of a row's diagonal block.
    pub fn inverse_of(&self, row: usize) -> &Block {
        &self.inverse[row]
    }

    fn power(&self, matrix: &BlockMatrix) -> f32 {
        let n = 3 * matrix.nodes();
        let mut x: Vec<f32> = (0..n).map(|k| ((k as f32) * 0.618_034).fract() - 0.5).collect();
        let mut y = vec![0.0; n];
        let mut size = 1.0;
        for _ in 0..POWER {
            matrix.multiply(&x, &mut y);
            self.over_diagonal(&y, &mut x);
            size = norm(&x);
            if size == 0.0 || !size.is_finite() {
                return 1.0;
            }
            x.iter_mut().for_each(|x| *x /= size);
        }
        size
    }

    /// out = D^-1 x.
    pub fn over_diagonal(&self, x: &[f32], out: &mut [f32]) {
        let lines = out.par_chunks_mut(3).zip(x.par_chunks(3)).zip(&self.inverse);
        lines.with_min_len(1024).for_each(|((out, x), b)| {
            for i in 0..3 {
                out[i] = b[3 * i] * x[0] + b[3 * i + 1] * x[1] + b[3 * i + 2] * x[2];
            }
        });
    }

    /// Improves `x` towards A x = b; where `zero`, `x` counts as 0.
    pub fn smooth(&self, matrix: &BlockMatrix, b: &[f32], x: &mut [f32], zero: bool) {
        let (high, low) = (self.largest, self.largest / RANGE);
        let (middle, half) = (0.5 * (high + low), 0.5 * (high - low));
        let sigma = middle / half;
        let mut rho = 1.0 / sigma;
        let n = b.len();
        let (mut residual, mut step, mut direction) = (b.to_vec(), vec![0.0; n], vec![0.0; n]);
        if zero {
            x.fill(0.0);
        } else {
            matrix.multiply(x, &mut residual);
            residual.iter_mut().zip(b).for_each(|(r, b)| *r = b - *r);
        }
        self.over_diagonal(&residual, &mut direction);
        direction.iter_mut().for_each(|d| *d /= middle);
        for k in 0..DEGREE {
            x.iter_mut().zip(&direction).for_each(|(x, d)| *x += d);
            if k + 1 == DEGREE {
                break;
            }
            matrix.multiply(&direction, &mut step);
            residual.iter_mut().zip(&step).for_each(|(r, s)| *r -= s);
            self.over_diagonal(&residual, &mut step);
            let next = 1.0 / (2.0 * sigma - rho);
            let (keep, take) = (next * rho, 2.0 * next / half);
            direction.iter_mut().zip(&step).for_each(|(d, s)| *d = keep * *d + take * s);
            rho = next;
        }
    }
}

fn norm(v: &[f32]) -> f32 {
    v.iter().map(|&c| f64::from(c) * f64::from(c)).sum::<f64>().sqrt() as f32
}
