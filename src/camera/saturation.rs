//! How many pixels are expected at the top grey level.

use super::exposure::top_grey;
use crate::scene::Sensor;
use statrs::function::erf::erfc;
use statrs::function::gamma::ln_gamma;
use std::f64::consts::{PI, SQRT_2};

/// Standard deviations on either side of the top grey level beyond which a pixel is there never, or always.
const REACH: f64 = 9.0;
/// Steps of the table between them.
const STEPS: usize = 1024;
/// A smaller chance is none: less than what rounding does to the share of an image.
const NONE: f64 = 1e-12;
/// From so many electrons on their number is normal but for its skewness.
const MANY: f64 = 1e4;

/// The chance of a pixel to read the top grey level, by its expected electrons: shot noise, read noise and rounding are
/// those of [`super::expose`].
#[derive(Debug, Clone)]
pub struct Saturation {
    from: f64,
    step: f64,
    chances: Vec<f64>,
}

impl Saturation {
    /// That of a sensor.
    pub fn of(sensor: &Sensor) -> Self {
        let top = f64::from(top_grey(sensor.bit_depth));
        let least = (top - 0.5 - sensor.black_level) * sensor.full_well_e / top;
        let reach = REACH * (least.max(0.0) + sensor.read_noise_e.powi(2)).sqrt();
        let from = (least - reach).max(0.0);
        // A few electrons are not normal: their upper tail is longer.
        let to = least.max(0.0) + reach + REACH * REACH;
        let step = (to - from) / STEPS as f64;
        let chance = |k: usize| match chance(from + step * k as f64, least, sensor.read_noise_e) {
            small if small < NONE => 0.0,
            chance => chance,
        };
        Self { from, step, chances: (0..=STEPS).map(chance).collect() }
    }

    /// Mean chance of pixels with so many expected electrons each: the expected share of them at the top grey level.
    pub fn share(&self, electrons: &[f64]) -> f64 {
        electrons.iter().map(|&mean| self.at(mean)).sum::<f64>() / electrons.len().max(1) as f64
    }

    fn at(&self, electrons: f64) -> f64 {
        let place = ((electrons - self.from) / self.step).clamp(0.0, STEPS as f64);
        let below = (place as usize).min(STEPS - 1);
        let [low, high] = [self.chances[below], self.chances[below + 1]];
        low + (high - low) * (place - below as f64)
    }
}

/// Chance that a Poisson number of a given mean plus normal noise is no less than `least`.
fn chance(mean: f64, least: f64, noise: f64) -> f64 {
    let normal = |x: f64| 0.5 * erfc(x / SQRT_2);
    if mean > MANY {
        // Edgeworth's first term; the skewness of a Poisson number times its cubed deviation is its mean.
        let deviation = (mean + noise * noise).sqrt();
        let x = (least - mean) / deviation;
        let density = (-0.5 * x * x).exp() / (2.0 * PI).sqrt();
        return normal(x) + mean / deviation.powi(3) / 6.0 * (x * x - 1.0) * density;
    }
    let reach = REACH * mean.sqrt() + REACH * REACH;
    let [first, last] = [mean - reach, mean + reach].map(|k| k.max(0.0) as u32);
    (first..=last)
        .map(f64::from)
        .map(|k| {
            let drawn = if mean > 0.0 { (k * mean.ln() - mean - ln_gamma(k + 1.0)).exp() } else { f64::from(k == 0.0) };
            let reaches = if noise > 0.0 { normal((least - k) / noise) } else { f64::from(k >= least) };
            drawn * reaches
        })
        .sum()
}

#[cfg(test)]
mod tests {
    use super::super::exposure::read_out;
    use super::super::noise::PixelRandom;
    use super::*;

    /// Against frames of the same camera, from wells of a few electrons to large ones.
    #[test]
    fn the_chance_is_that_of_frames() {
        let sensor = |full_well_e, read_noise_e, bit_depth, black_level| Sensor {
            full_well_e,
            read_noise_e,
            bit_depth,
            black_level,
            ..Sensor::default()
        };
        let sensors = [
            sensor(3.0, 0.0, 8, 0.0),
            sensor(30.0, 0.4, 8, 5.0),
            sensor(400.0, 12.0, 8, 0.0),
            sensor(9_000.0, 2.5, 12, 64.0),
            sensor(60_000.0, 8.0, 8, 2.0),
            sensor(1e7, 20.0, 16, 0.0),
        ];
        const DRAWS: u32 = 20_000;
        for sensor in sensors {
            let saturation = Saturation::of(&sensor);
            let top = top_grey(sensor.bit_depth);
            let least = (f64::from(top) - 0.5 - sensor.black_level) * sensor.full_well_e / f64::from(top);
            let spread = (least + sensor.read_noise_e.powi(2)).sqrt();
            for (row, off) in [-3.0, -1.2, -0.3, 0.0, 0.4, 1.5, 3.0].into_iter().enumerate() {
                let mean = (least + off * spread).max(0.0);
                let mut random = PixelRandom::new(7, row as u32);
                let seen = (0..DRAWS).filter(|_| read_out(mean, &sensor, &mut random) == top).count();
                let [expected, seen] = [saturation.share(&[mean]), seen as f64 / f64::from(DRAWS)];
                let error = (expected * (1.0 - expected) / f64::from(DRAWS)).sqrt();
                // Four standard errors, and what a table of these steps leaves.
                assert!((expected - seen).abs() < 4.0 * error + 2e-4, "{sensor:?} {mean}: {expected} {seen}");
            }
            assert_eq!(saturation.share(&[0.0, 0.0]), 0.0, "{sensor:?}");
            assert!((saturation.share(&[0.0, 1e12]) - 0.5).abs() < 1e-9, "{sensor:?}");
        }
    }
}
