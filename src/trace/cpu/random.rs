//! Twin of `random.wgsl`: counter-based random numbers, equal bit for bit; those of launches are even (`launch.rs`).

use super::Path;
use crate::trace::constants::{DRAW_FIRST, DRAW_SECOND, DRAW_STEP, OF_24_BITS, ROUND_BITS};
use crate::trace::launch::{even, scramble};
use crate::trace::model::Real;
use crate::trace::pcg::pcg3d;

impl<T: Real> Path<'_, T> {
    /// Starts the random numbers of path (a, b) of a seed.
    pub fn start_random(&mut self, seed: u32, a: u32, b: u32) {
        let key = pcg3d([seed, a, b]);
        self.key = [key[0], key[1]];
        self.draws = 0;
        self.number = (b << ROUND_BITS).wrapping_add(a);
        self.seed = seed;
    }

    /// Uniform in [0, 1), 24 bits, and even over the paths of a seed: a coordinate of a launch.
    pub fn even_draw(&mut self, coordinate: usize) -> T {
        let h = even(self.number, coordinate, scramble(self.seed, coordinate));
        T::of(f64::from(h >> 8) * OF_24_BITS)
    }

    /// Uniform in [0, 1), 24 bits.
    pub fn draw(&mut self) -> T {
        let mut h = self.key[0].wrapping_add(self.draws.wrapping_mul(DRAW_STEP));
        self.draws = self.draws.wrapping_add(1);
        h = (h ^ (h >> 16)).wrapping_mul(DRAW_FIRST);
        h = (h ^ (h >> 15)).wrapping_add(self.key[1]).wrapping_mul(DRAW_SECOND);
        h ^= h >> 15;
        T::of(f64::from(h >> 8) * OF_24_BITS)
    }
}
