//! A simulated frame with what is known of its noise: of the camera, pixel by pixel, and of the light, replicate by replicate.

use crate::camera::{ExposureError, Response, Signal, expected_electrons};
use crate::film::{Film, Group};
use crate::scene::Camera;
use rayon::prelude::*;

/// Equal paths that light needs to count as normal.
const FEW_PATHS: f64 = 4.0;

/// A film as a camera sees it. All variances are of grey levels before rounding.
#[derive(Debug, Clone)]
pub struct Exposed<'a> {
    film: &'a Film,
    /// Grey levels for a radiance of 1 W/(m^2 sr), each pixel.
    grey_per_radiance: Vec<f64>,
    /// Grey level of each pixel before rounding: its mean, and the spread by light and camera together.
    signal: Vec<Signal>,
    /// What each pixel reads of that.
    read: Vec<Response>,
    /// Share of the light in the variance of each signal, grey levels squared.
    light_variance: Vec<f64>,
    /// A pixel that no LED lights.
    dark: Signal,
    top: f64,
}

impl<'a> Exposed<'a> {
    /// A film seen by a camera.
    ///
    /// # Errors
    /// As [`expected_electrons`].
    pub fn new(film: &'a Film, camera: &Camera, wavelength_nm: f64) -> Result<Self, ExposureError> {
        let (width, height) = (film.width, film.height);
        let even = |radiance| Film { width, height, mean: vec![radiance; film.mean.len()], ..Film::default() };
        let background = expected_electrons(&even(0.0), camera, wavelength_nm)?;
        let lit = expected_electrons(&even(1.0), camera, wavelength_nm)?;
        let sensor = &camera.sensor;
        let top = f64::from((1u32 << sensor.bit_depth) - 1);
        let gain = top / sensor.full_well_e;
        let grey_per_radiance: Vec<f64> = lit.iter().zip(&background).map(|(lit, dark)| (lit - dark) * gain).collect();
        let dark_e = background.first().copied().unwrap_or(0.0);
        // Photons are Poisson, so their variance in electrons is their number (EMVA 1288, linear model).
        let of_camera = |electrons: f64| (electrons + sensor.read_noise_e.powi(2)) * gain * gain;
        let known = film.groups.len() > 1;
        let light_variance: Vec<f64> = match known {
            true => {
                film.variance.iter().zip(&grey_per_radiance).map(|(v, scale)| f64::from(*v) * scale * scale).collect()
            }
            false => vec![0.0; film.mean.len()],
        };
        let pixel = |((&radiance, scale), light): ((&f32, &f64), &f64)| {
            let grey = dark_e * gain + f64::from(radiance) * scale;
            Signal { mean: grey + sensor.black_level, sd: (of_camera(grey / gain) + light).sqrt() }
        };
        let signal: Vec<Signal> =
            film.mean.par_iter().zip(&grey_per_radiance).zip(&light_variance).map(pixel).collect();
        let read = signal.par_iter().map(|signal| signal.read(top)).collect();
        let dark = Signal { mean: dark_e * gain + sensor.black_level, sd: of_camera(dark_e).sqrt() };
        Ok(Self { film, grey_per_radiance, signal, read, light_variance, dark, top })
    }

    /// Columns.
    pub(super) fn width(&self) -> usize {
        self.film.width as usize
    }

    /// Number of pixels.
    pub(super) fn pixels(&self) -> usize {
        self.film.mean.len()
    }

    /// Grey level of a pixel before rounding.
    pub(super) fn signal(&self, pixel: usize) -> Signal {
        self.signal.get(pixel).copied().unwrap_or(self.dark)
    }

    /// What a pixel reads.
    pub(super) fn read(&self, pixel: usize) -> Response {
        self.read.get(pixel).copied().unwrap_or(Response { mean: 0.0, variance: 0.0, slope: 0.0 })
    }

    /// Variance of a pixel's signal by the light alone.
    pub(super) fn light_variance(&self, pixel: usize) -> f64 {
        self.light_variance.get(pixel).copied().unwrap_or(0.0)
    }

    /// Whether so few paths brought a pixel's light that it is not normal: fewer than [`FEW_PATHS`] equal ones would vary as
    /// much (of n the relative variance is 1/n).
    pub(super) fn is_of_few_paths(&self, pixel: usize) -> bool {
        let light = self.signal(pixel).mean - self.dark.mean;
        let variance = self.light_variance(pixel);
        variance > 0.0 && light * light < FEW_PATHS * variance
    }

    /// Grey levels by which a pixel's mean moves when one group of replicates is left out, group by group.
    pub(super) fn left_out(&self, pixel: usize) -> impl Iterator<Item = f64> {
        let total: f64 = self.groups().iter().map(|group| f64::from(group.replicates)).sum();
        self.groups().iter().map(move |group| {
            let share = f64::from(group.replicates);
            -share * self.deviation(group, pixel) / (total - share)
        })
    }

    /// A pixel that no LED lights.
    pub(super) fn dark(&self) -> Signal {
        self.dark
    }

    /// The top grey level.
    pub(super) fn top(&self) -> f64 {
        self.top
    }

    /// Groups of replicates, from which the light's share of an error is taken; none where the film keeps none.
    pub(super) fn groups(&self) -> &'a [Group] {
        match self.film.groups.len() {
            0 | 1 => &[],
            _ => &self.film.groups,
        }
    }

    /// How far a group's signal is from the mean of all, grey levels.
    pub(super) fn deviation(&self, group: &Group, pixel: usize) -> f64 {
        match (group.mean.get(pixel), self.film.mean.get(pixel), self.grey_per_radiance.get(pixel)) {
            (Some(one), Some(all), Some(scale)) => (f64::from(*one) - f64::from(*all)) * scale,
            _ => 0.0,
        }
    }
}
