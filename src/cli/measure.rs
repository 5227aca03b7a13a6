//! The paper's figures of a camera frame.

use super::Failure;
use super::shot::Shot;
use crate::camera::expected_electrons;
use crate::estimate::{Calibration, Estimates, GreyImage, PaperEstimate, Settings, estimate};
use crate::film::Film;
use crate::image_io::read_grey;
use clap::Args;
use std::path::{Path, PathBuf};

/// Flags of the commands that read figures from images.
#[derive(Debug, Clone, Args)]
pub(super) struct Reading {
    /// Threshold k: brighter pixels are lit, grey levels.
    #[arg(long, value_name = "K", default_value = "5", value_parser = threshold, allow_negative_numbers = true)]
    pub threshold: f64,
    /// Image to subtract first: a frame without inclusion, or without press.
    #[arg(long, value_name = "IMAGE")]
    pub reference: Option<PathBuf>,
    /// Calibration file (TOML).
    #[arg(long, value_name = "FILE")]
    pub calibration: Option<PathBuf>,
}

/// What was read from one image.
pub(super) struct Figures {
    pub paper: PaperEstimate,
    pub estimates: Estimates,
}

impl Reading {
    /// The reference image, where one is given.
    pub fn reference(&self) -> Result<Option<GreyImage>, Failure> {
        self.reference.as_deref().map(|path| grey_image(path).map(|(image, _)| image)).transpose()
    }

    /// The calibration, where one is given.
    pub fn calibration(&self) -> Result<Option<Calibration>, Failure> {
        Ok(self.calibration.as_deref().map(Calibration::load).transpose()?)
    }

    /// Reads the figures of a shot: its camera frame, raw or less the reference.
    pub fn of_shot(
        &self,
        shot: &Shot,
        reference: Option<&GreyImage>,
        calibration: Option<&Calibration>,
    ) -> Result<Figures, Failure> {
        let raw = GreyImage::from_frame(&shot.frame)?;
        let image = match reference {
            Some(reference) => less(&raw, reference, self.reference.as_deref())?,
            None => raw,
        };
        // A reference is taken to be as noisy as the image.
        let frames = if reference.is_some() { 2.0 } else { 1.0 };
        let read = |noise: f64| estimate(&image, &Settings { threshold_grey: self.threshold, noise_grey: noise });
        let noise = Noise::of(shot)?;
        // The lit area hangs on pixels at the threshold, the sums on all of them.
        let edge = read((frames * noise.variance_at(self.threshold)).sqrt());
        let paper = PaperEstimate { diameter_px: edge.diameter_px, ..read((frames * noise.mean_variance()).sqrt()) };
        let known = Calibration { mm_per_pixel: shot.mm_per_pixel, bottom_area_mm2: None, force_n_from_sum_grey: None };
        let estimates = Estimates::from_paper(&paper, Some(calibration.unwrap_or(&known)));
        Ok(Figures { paper, estimates })
    }
}

/// An image less a reference; a mistake names the reference.
pub(super) fn less(image: &GreyImage, reference: &GreyImage, path: Option<&Path>) -> Result<GreyImage, Failure> {
    let path = path.unwrap_or(Path::new("reference"));
    image.minus(reference).map_err(|error| Failure::input(format!("{}: {error}", path.display())).in_file(path))
}

/// Reads an image for the estimators; also whether its values are radiances and not grey levels.
pub(super) fn grey_image(path: &Path) -> Result<(GreyImage, bool), Failure> {
    let read = read_grey(path)?;
    let image = GreyImage::new(read.width as usize, read.height as usize, &read.values, read.full_scale)
        .map_err(|error| Failure::input(format!("{}: {error}", path.display())).in_file(path))?;
    Ok((image, read.linear))
}

/// Noise of a simulated frame: of the camera, and of the tracer, whose image the camera exposes.
struct Noise<'a> {
    frame: &'a [u16],
    /// Grey levels an electron.
    gain: f64,
    black_level: f64,
    /// Read noise and rounding, grey levels squared.
    constant: f64,
    /// Variance by the tracer of each pixel, grey levels squared.
    traced: Vec<f64>,
}

impl<'a> Noise<'a> {
    fn of(shot: &'a Shot) -> Result<Self, Failure> {
        let scene = shot.job.scene();
        let sensor = &scene.camera.sensor;
        let gain = f64::from(shot.frame.top_grey()) / sensor.full_well_e;
        // Electrons are linear in radiance above a background.
        let electrons = |mean: Vec<f32>| {
            let film = Film { width: shot.frame.width, height: shot.frame.height, mean, ..Film::default() };
            expected_electrons(&film, &scene.camera, scene.light.wavelength_nm)
        };
        let variance = &shot.outcome.film.variance;
        let error = electrons(variance.iter().map(|v| v.sqrt()).collect())?;
        let background = electrons(vec![0.0; variance.len()])?;
        let traced = error.iter().zip(background).map(|(e, b)| ((e - b) * gain).powi(2)).collect();
        Ok(Self {
            frame: &shot.frame.grey,
            gain,
            black_level: sensor.black_level,
            constant: (sensor.read_noise_e * gain).powi(2) + 1.0 / 12.0,
            traced,
        })
    }

    /// Of one pixel of a grey level, with the tracer's share of pixels within a factor 2 of it.
    fn variance_at(&self, grey: f64) -> f64 {
        let near = |level: f64| (0.5 * grey..=2.0 * grey).contains(&level);
        let traced = self.frame.iter().zip(&self.traced).filter(|(level, _)| near(f64::from(**level)));
        let (count, sum) = traced.fold((0.0, 0.0), |(count, sum), (_, v)| (count + 1.0, sum + v));
        self.constant + self.gain * (grey - self.black_level).max(0.0) + sum / f64::max(count, 1.0)
    }

    /// Over all pixels.
    fn mean_variance(&self) -> f64 {
        let pixels = self.frame.len().max(1) as f64;
        let grey = self.frame.iter().map(|&level| f64::from(level)).sum::<f64>() / pixels;
        self.constant + self.gain * (grey - self.black_level).max(0.0) + self.traced.iter().sum::<f64>() / pixels
    }
}

fn threshold(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number: &f64| number.is_finite() && *number >= 0.0);
    number.ok_or_else(|| "it must be a finite number, 0 or more".into())
}
