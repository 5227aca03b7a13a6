//! The paper's figures of a camera frame.

use super::Failure;
use super::shot::Shot;
use crate::estimate::{Calibration, Estimates, GreyImage, PaperEstimate, Settings, estimate};
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
    /// Subtract the frame of the same press without inclusions, made along the way (scenes with a press).
    #[arg(long, conflicts_with = "reference")]
    pub subtract_baseline: bool,
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
    /// The reference image, where one is given, for a camera of as many pixels.
    pub fn reference(&self, pixels: [u32; 2]) -> Result<Option<GreyImage>, Failure> {
        let Some(path) = &self.reference else {
            return Ok(None);
        };
        let (image, _) = grey_image(path)?;
        let [width, height] = pixels;
        if (image.width(), image.height()) != (width as usize, height as usize) {
            let found = format!("{} x {}", image.width(), image.height());
            let message = format!("{}: has {found} pixels, the camera {width} x {height}", path.display());
            return Err(Failure::input(message).in_file(path));
        }
        Ok(Some(image))
    }

    /// What is subtracted, if anything.
    pub fn reference_name(&self) -> Option<String> {
        match (&self.reference, self.subtract_baseline) {
            (Some(path), _) => Some(path.display().to_string()),
            (None, true) => Some("baseline.png".into()),
            (None, false) => None,
        }
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
        let read = |variance: f64| {
            estimate(&image, &Settings { threshold_grey: self.threshold, noise_grey: (frames * variance).sqrt() })
        };
        let noise = Noise::of(shot)?;
        // The lit area hangs on pixels at the threshold, h on those at the centroid, sums on all.
        let sums = read(noise.mean_variance());
        let h_grey = match sums.centroid_px.best() {
            Some(&place) => read(noise.variance_near(place)).h_grey,
            None => sums.h_grey.clone(),
        };
        let paper = PaperEstimate { diameter_px: read(noise.of_camera(self.threshold)).diameter_px, h_grey, ..sums };
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
    shot: &'a Shot<'a>,
    /// Grey levels an electron.
    gain: f64,
    /// Variance by the tracer of each pixel, grey levels squared.
    traced: Vec<f64>,
}

impl<'a> Noise<'a> {
    fn of(shot: &'a Shot) -> Result<Self, Failure> {
        let gain = f64::from(shot.frame.top_grey()) / shot.job.scene().camera.sensor.full_well_e;
        let variance = &shot.outcome.film.variance;
        // Electrons are linear in radiance, above a background.
        let error = shot.job.electrons(variance.iter().map(|v| v.sqrt()).collect())?;
        let background = shot.job.electrons(vec![0.0; variance.len()])?;
        let traced = error.iter().zip(background).map(|(e, b)| ((e - b) * gain).powi(2)).collect();
        Ok(Self { shot, gain, traced })
    }

    /// Of the camera alone, at a grey level: photons, read-out, rounding. What the tracer adds at the rim of a lit area
    /// is independent from pixel to pixel and averages out over the rim.
    fn of_camera(&self, grey: f64) -> f64 {
        let sensor = &self.shot.job.scene().camera.sensor;
        let photons = self.gain * (grey - sensor.black_level).max(0.0);
        photons + (sensor.read_noise_e * self.gain).powi(2) + 1.0 / 12.0
    }

    /// Of the pixel at a place (column, row).
    fn variance_near(&self, [column, row]: [f64; 2]) -> f64 {
        let (width, height) = (self.shot.frame.width as usize, self.shot.frame.height as usize);
        let pixel =
            (row as usize).min(height.saturating_sub(1)) * width + (column as usize).min(width.saturating_sub(1));
        let grey = self.shot.frame.grey.get(pixel).copied().unwrap_or(0);
        self.of_camera(grey.into()) + self.traced.get(pixel).copied().unwrap_or(0.0)
    }

    /// Mean over all pixels.
    fn mean_variance(&self) -> f64 {
        let pixels = self.traced.len().max(1) as f64;
        let grey = self.shot.frame.grey.iter().map(|&level| f64::from(level)).sum::<f64>() / pixels;
        self.of_camera(grey) + self.traced.iter().sum::<f64>() / pixels
    }
}

fn threshold(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number: &f64| number.is_finite() && *number >= 0.0);
    number.ok_or_else(|| "it must be a finite number, 0 or more".into())
}
