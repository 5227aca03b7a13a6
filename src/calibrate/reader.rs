//! How a camera shows light: the grey level of a block, and its noise.

use crate::camera::{expected_electrons, top_grey};
use crate::film::Film;
use crate::scene::Camera;
use std::f64::consts::PI;

/// Darker blocks are not read, grey levels above black: rounding hides what they hold.
const LEAST_GREY: f64 = 3.0;
/// A block is saturated where so many standard deviations of a pixel reach the end.
const BELOW_END: f64 = 4.0;

/// A block of a frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Read {
    /// Logarithm of its mean radiance, W/(m^2 sr).
    pub log_light: f64,
    /// Variance of that by the camera.
    pub variance: f64,
}

/// A camera and its exposure.
pub(super) struct Reader<'a> {
    camera: &'a Camera,
    /// Electrons of each pixel by unit radiance, without those of the dark.
    lit: Vec<f64>,
    /// Electrons in the dark.
    background: f64,
    /// Grey levels an electron, and the highest level.
    gain: f64,
    top: f64,
}

impl<'a> Reader<'a> {
    /// # Errors
    /// Says why the exposure makes no sense.
    pub fn new(camera: &'a Camera, wavelength_nm: f64) -> Result<Self, String> {
        let [width, height] = camera.pixels;
        let mean = |radiance| vec![radiance; width as usize * height as usize];
        let even = |radiance| Film { width, height, mean: mean(radiance), ..Film::default() };
        let electrons = |radiance| expected_electrons(&even(radiance), camera, wavelength_nm);
        let (Ok(dark), Ok(lit)) = (electrons(0.0), electrons(1.0)) else {
            return Err("the camera's exposure makes no sense".into());
        };
        let background = dark.first().copied().unwrap_or(0.0);
        let top = f64::from(top_grey(camera.sensor.bit_depth));
        let gain = top / camera.sensor.full_well_e;
        Ok(Self { camera, lit: lit.into_iter().map(|lit| lit - background).collect(), background, gain, top })
    }

    /// Electrons of a mean pixel of the block by unit radiance.
    fn unit(&self, pixels: &[usize]) -> f64 {
        pixels.iter().filter_map(|&pixel| self.lit.get(pixel)).sum::<f64>() / pixels.len() as f64
    }

    /// Variance of a pixel of so many grey levels above black, before rounding.
    fn of_pixel(&self, grey: f64) -> f64 {
        (grey / self.gain + self.background + self.camera.sensor.read_noise_e.powi(2)) * self.gain * self.gain
    }

    /// A block of this mean grey level; none where it is too dark.
    pub fn read(&self, mean: f64, pixels: &[usize]) -> Option<Read> {
        let grey = mean - self.camera.sensor.black_level - self.background * self.gain;
        if grey < LEAST_GREY {
            return None;
        }
        let of_pixel = self.of_pixel(grey);
        // What rounding shifts the mean of a normal signal of this deviation by, at most (first harmonic).
        let rounded = (-2.0 * PI * PI * of_pixel).exp() / PI;
        let variance = (of_pixel + 1.0 / 12.0) / pixels.len() as f64 + 0.5 * rounded * rounded;
        let log_light = (grey / self.gain / self.unit(pixels)).ln();
        Some(Read { log_light, variance: variance / (grey * grey) })
    }

    /// The longest exposure at which none of these blocks saturates, ms: of g electrons above black, read noise r and
    /// the top t, all in electrons, g + 4 sqrt(g + r^2) = t.
    pub fn longest_ms(&self, blocks: &[(f64, &[usize])]) -> f64 {
        let brightest = blocks.iter().map(|(log, pixels)| log.exp() * self.unit(pixels)).fold(0.0, f64::max);
        let noise = self.camera.sensor.read_noise_e.powi(2) + self.background;
        let top = (self.top - self.camera.sensor.black_level) / self.gain - self.background;
        let root = (0.25 * BELOW_END.powi(2) + top + noise).max(0.0).sqrt() - 0.5 * BELOW_END;
        let most = (root * root - noise).max(0.0);
        // A little less: the dark's own charge grows with the exposure.
        0.99 * self.camera.sensor.exposure_ms * most / brightest.max(f64::MIN_POSITIVE)
    }

    /// How a block of this light would be read; none where it is too dark, or would saturate.
    pub fn expected(&self, log_light: f64, pixels: &[usize]) -> Option<Read> {
        let grey = log_light.exp() * self.unit(pixels) * self.gain;
        let mean = grey + self.camera.sensor.black_level + self.background * self.gain;
        let saturated = mean + BELOW_END * self.of_pixel(grey).sqrt() > self.top;
        self.read(mean, pixels).filter(|_| !saturated)
    }
}
