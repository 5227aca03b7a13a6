//! A simulated frame with what is known of its noise: of the camera, pixel by pixel, and of the light, replicate by
//! replicate.

use crate::camera::{ExposureError, Response, Signal, expected_electrons};
use crate::film::{Film, Group};
use crate::scene::Camera;
use rayon::prelude::*;

/// Equal paths that light needs to count as normal.
const FEW_PATHS: f64 = 4.0;

/// Whether fewer than [`FEW_PATHS`] equal paths would vary as much (of n the relative variance is 1/n).
pub(super) fn of_few_paths(light: f64, variance: f64) -> bool {
    light * light < FEW_PATHS * variance
}

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
        let dark = Signal { mean: dark_e * gain + sensor.black_level, sd: of_camera(dark_e).sqrt() };
        let mut exposed = Self { film, grey_per_radiance, signal, read: Vec::new(), light_variance, dark, top };
        exposed.read = (0..film.mean.len()).into_par_iter().map(|pixel| exposed.read_of(pixel)).collect();
        Ok(exposed)
    }

    fn read_of(&self, pixel: usize) -> Response {
        let signal = self.signal(pixel);
        if !self.is_of_few_paths(pixel) {
            return signal.read(self.top);
        }
        let sd = (signal.sd * signal.sd - self.light_variance(pixel)).max(0.0).sqrt();
        self.of_few_paths(pixel, |shift| Signal { mean: signal.mean + shift, sd }.read(self.top))
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

    /// Whether so few paths brought a pixel's light that it is not normal.
    pub(super) fn is_of_few_paths(&self, pixel: usize) -> bool {
        let variance = self.light_variance(pixel);
        variance > 0.0 && of_few_paths(self.light(pixel), variance)
    }

    /// Grey levels that the light of the LEDs makes of a pixel.
    pub(super) fn light(&self, pixel: usize) -> f64 {
        self.signal(pixel).mean - self.dark.mean
    }

    /// What is made of the light of a pixel that few paths brought. `respond` says it for the light as it is, moved by
    /// so many grey levels. The light's share of the variance is that of leaving out one group of replicates at a time
    /// (the jackknife, which errs to the safe side: Efron and Stein 1981), the slope the line through those values: no
    /// less than the share that follows the line, the rest is the pixel's own.
    pub(super) fn of_few_paths(&self, pixel: usize, respond: impl Fn(f64) -> Response) -> Response {
        let found = respond(0.0);
        let total: f64 = self.groups().iter().map(|group| f64::from(group.replicates)).sum();
        let left_out = self.groups().iter().map(|group| {
            let share = f64::from(group.replicates);
            let shift = -share * self.deviation(group, pixel) / (total - share);
            (shift, respond(shift).mean)
        });
        let left_out: Vec<(f64, f64)> = left_out.collect();
        let groups = left_out.len() as f64;
        let middle = left_out.iter().map(|(_, mean)| mean).sum::<f64>() / groups;
        let sum =
            |of: &dyn Fn(f64, f64) -> f64| left_out.iter().map(|(shift, mean)| of(*shift, mean - middle)).sum::<f64>();
        let jackknife = (groups - 1.0) / groups * sum(&|_, off| off * off);
        let squares = sum(&|shift, _| shift * shift);
        let slope = if squares > 0.0 { sum(&|shift, off| shift * off) / squares } else { 0.0 };
        Response { mean: found.mean, variance: found.variance + jackknife, slope }
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
