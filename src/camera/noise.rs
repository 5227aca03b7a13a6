//! Random numbers of the sensor: one stream per (seed, pixel), so that the bits do not depend on the order of work.
//!
//! SplitMix64 (Steele, Lea and Flood, OOPSLA 2014): a counter with a fixed stride behind a bijective mix. Poisson
//! draws are exact: multiplication of uniforms for small means, Hörmann's transformed rejection PTRS ("The
//! transformed rejection method for generating Poisson random variables", Insurance: Mathematics and Economics
//! 12, 1993) from 10 on.

/// Mean from which PTRS is used: the least for which its hat function holds (Hörmann 1993).
const PTRS_FROM: f64 = 10.0;

/// The random numbers of one pixel.
#[derive(Debug, Clone)]
pub struct PixelRandom {
    counter: u64,
}

fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

impl PixelRandom {
    /// The stream of one pixel (row-major number) of one exposure.
    pub fn new(seed: u32, pixel: u32) -> Self {
        // Mixed once, the streams start at unrelated places of the counter's cycle of 2^64.
        Self { counter: mix((u64::from(seed) << 32 | u64::from(pixel)).wrapping_add(0x9e37_79b9_7f4a_7c15)) }
    }

    /// A uniform number strictly between 0 and 1.
    pub fn uniform(&mut self) -> f64 {
        self.counter = self.counter.wrapping_add(0x9e37_79b9_7f4a_7c15);
        // 52 bits and a half: both ends are left out and every value is exact.
        ((mix(self.counter) >> 12) as f64 + 0.5) * (1.0 / (1u64 << 52) as f64)
    }

    /// A standard normal number (Box and Muller).
    pub fn normal(&mut self) -> f64 {
        let radius = (-2.0 * self.uniform().ln()).sqrt();
        radius * (std::f64::consts::TAU * self.uniform()).cos()
    }

    /// A Poisson number of the given mean (0 to about 1e10, where the logarithms still resolve one count).
    pub fn poisson(&mut self, mean: f64) -> f64 {
        if mean < PTRS_FROM { self.poisson_by_products(mean) } else { self.poisson_by_rejection(mean) }
    }

    fn poisson_by_products(&mut self, mean: f64) -> f64 {
        let limit = (-mean).exp();
        let mut product = self.uniform();
        let mut count = 0.0;
        while product > limit {
            product *= self.uniform();
            count += 1.0;
        }
        count
    }

    fn poisson_by_rejection(&mut self, mean: f64) -> f64 {
        // Names and constants as in Hörmann's algorithm PTRS.
        let ln_mean = mean.ln();
        let b = 0.931 + 2.53 * mean.sqrt();
        let a = -0.059 + 0.02483 * b;
        let inv_alpha = 1.1239 + 1.1328 / (b - 3.4);
        let v_r = 0.9277 - 3.6224 / (b - 2.0);
        loop {
            let u = self.uniform() - 0.5;
            let v = self.uniform();
            let us = 0.5 - u.abs();
            let k = ((2.0 * a / us + b) * u + mean + 0.43).floor();
            if us >= 0.07 && v <= v_r {
                return k;
            }
            if k < 0.0 || (us < 0.013 && v > us) {
                continue;
            }
            let hat = (v * inv_alpha / (a / (us * us) + b)).ln();
            if hat <= k * ln_mean - mean - ln_factorial(k) {
                return k;
            }
        }
    }
}

/// ln(k!) for whole k: the product below 10, Stirling's series (next term below 6e-11) from there.
fn ln_factorial(k: f64) -> f64 {
    if k < 10.0 {
        return (2..=k as u32).map(f64::from).product::<f64>().ln();
    }
    let inv = 1.0 / k;
    let series = inv * (1.0 / 12.0 - inv * inv * (1.0 / 360.0 - inv * inv / 1260.0));
    (k + 0.5) * k.ln() - k + 0.5 * std::f64::consts::TAU.ln() + series
}

#[cfg(test)]
mod tests {
    use super::*;

    fn draws(n: u32, mut draw: impl FnMut(&mut PixelRandom) -> f64) -> Vec<f64> {
        (0..n).map(|pixel| draw(&mut PixelRandom::new(7, pixel))).collect()
    }

    fn mean_and_variance(x: &[f64]) -> (f64, f64) {
        let n = x.len() as f64;
        let mean = x.iter().sum::<f64>() / n;
        (mean, x.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0))
    }

    #[test]
    fn poisson_has_the_mean_and_variance_of_theory() {
        let n = 20_000;
        for mean in [0.0, 0.01, 0.7, 4.0, 9.99, 10.0, 31.0, 800.0, 14_000.0] {
            let (m, v) = mean_and_variance(&draws(n, |r| r.poisson(mean)));
            if mean == 0.0 {
                assert_eq!((m, v), (0.0, 0.0));
                continue;
            }
            // var(mean) = mean/n; var(s^2) = (mu4 - sigma^4)/n = (mean + 2 mean^2)/n. Of 16 z-scores none passes 4
            // but by a chance of 1e-3.
            let z_mean = (m - mean) / (mean / f64::from(n)).sqrt();
            let z_var = (v - mean) / ((mean + 2.0 * mean * mean) / f64::from(n)).sqrt();
            assert!(z_mean.abs() < 4.0 && z_var.abs() < 4.0, "mean {mean}: z {z_mean} {z_var}");
        }
    }

    #[test]
    fn poisson_counts_follow_the_probabilities() {
        let n = 40_000;
        for mean in [3.0f64, 12.0] {
            let x = draws(n, |r| r.poisson(mean));
            let (mut chi2, mut cells) = (0.0, 0.0);
            for k in 0..60 {
                let k = f64::from(k);
                let expected = f64::from(n) * (k * mean.ln() - mean - ln_factorial(k)).exp();
                if expected > 20.0 {
                    let seen = x.iter().filter(|&&v| v == k).count() as f64;
                    chi2 += (seen - expected).powi(2) / expected;
                    cells += 1.0;
                }
            }
            // Chi-squared of `cells` degrees: mean cells, variance 2 cells; 4 standard deviations.
            assert!(chi2 < cells + 4.0 * (2.0f64 * cells).sqrt(), "mean {mean}: {chi2} of {cells}");
        }
    }

    #[test]
    fn normal_has_mean_zero_variance_one_and_its_kurtosis() {
        let n = 40_000;
        let x = draws(n, |r| r.normal());
        let (m, v) = mean_and_variance(&x);
        let kurtosis = x.iter().map(|x| x.powi(4)).sum::<f64>() / f64::from(n);
        // Standard errors: 1/sqrt(n), sqrt(2/n), sqrt(96/n).
        let n = f64::from(n);
        assert!(m.abs() < 4.0 / n.sqrt() && (v - 1.0).abs() < 4.0 * (2.0 / n).sqrt());
        assert!((kurtosis - 3.0).abs() < 4.0 * (96.0 / n).sqrt(), "{kurtosis}");
    }

    #[test]
    fn neighbouring_pixels_and_seeds_are_uncorrelated() {
        let n = 40_000;
        for other in [|p: u32| PixelRandom::new(7, p + 1), |p: u32| PixelRandom::new(8, p)] {
            let product = |p: u32| (PixelRandom::new(7, p).uniform() - 0.5) * (other(p).uniform() - 0.5);
            let correlation = 12.0 * (0..n).map(product).sum::<f64>() / f64::from(n);
            // Standard error 1/sqrt(n) for uncorrelated uniforms.
            assert!(correlation.abs() < 4.0 / f64::from(n).sqrt(), "{correlation}");
        }
    }

    #[test]
    fn log_factorial_meets_the_product_where_the_series_takes_over() {
        for k in 0..40u32 {
            let exact: f64 = (1..=k).map(|i| f64::from(i).ln()).sum();
            assert!((ln_factorial(f64::from(k)) - exact).abs() < 1e-10, "{k}");
        }
    }
}
