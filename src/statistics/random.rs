//! Pseudo-random numbers by a counter: splitmix64 (Steele, Lea & Flood 2014, with the constants of Vigna's C code).
//!
//! Number i of a seed is a mix of the bits of seed + i * 0x9E3779B97F4A7C15. It is the same on every machine.

/// A stream of random numbers.
pub(super) struct Random(u64);

impl Random {
    /// The stream of a seed.
    pub(super) fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// The next 64 bits.
    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// An integer from 0 to `n` - 1, by the high half of a product: no bias above n / 2^64 (Lemire 2019).
    pub(super) fn below(&mut self, n: usize) -> usize {
        ((u128::from(self.bits()) * n as u128) >> 64) as usize
    }

    /// A number from 0 to 1, 1 exclusive.
    #[cfg(test)]
    pub(super) fn uniform(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1u64 << 53) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The first numbers of seed 1234567 by Vigna's splitmix64.c, as Rosetta Code lists them.
    #[test]
    fn the_stream_is_splitmix64() {
        let mut random = Random::new(1_234_567);
        let pinned = [6_457_827_717_110_365_317, 3_203_168_211_198_807_973, 9_817_491_932_198_370_423];
        assert_eq!([random.bits(), random.bits(), random.bits()], pinned);
    }

    /// 70 000 draws: 10 000 of each; 4 standard deviations are 370.
    #[test]
    fn integers_are_uniform() {
        let mut random = Random::new(3);
        let mut counts = [0i32; 7];
        (0..70_000).for_each(|_| counts[random.below(7)] += 1);
        assert!(counts.iter().all(|count| (count - 10_000).abs() < 370), "{counts:?}");
    }
}
