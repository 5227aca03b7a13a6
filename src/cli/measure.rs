//! The paper's figures of a camera frame.

use super::Failure;
use super::shot::Shot;
use crate::camera::top_grey;
use crate::estimate::{Calibration, Estimates, GreyImage, PaperEstimate, Settings, estimate};
use crate::image_io::read_grey;
use crate::report::Marks;
use crate::scene::Camera;
use clap::Args;
use std::path::{Path, PathBuf};

/// Flags of the commands that read figures from images.
#[derive(Debug, Clone, Default, Args)]
pub(super) struct Reading {
    /// Threshold k: brighter pixels are lit, in grey levels, or as a share of full scale (`2%`).
    #[arg(long, value_name = "K", default_value_t, allow_negative_numbers = true)]
    pub threshold: Threshold,
    /// Image to subtract first: a frame without inclusion, or without press.
    #[arg(long, value_name = "IMAGE")]
    pub reference: Option<PathBuf>,
    /// Calibration file (TOML).
    #[arg(long, value_name = "FILE")]
    pub calibration: Option<PathBuf>,
}

/// The same for commands that make their image, and can make its reference too.
#[derive(Debug, Clone, Default, Args)]
pub(super) struct SceneReading {
    #[command(flatten)]
    pub image: Reading,
    /// Subtract the frame of the same press without inclusions, made along the way (scenes with a press).
    #[arg(long, conflicts_with = "reference")]
    pub subtract_baseline: bool,
}

/// What was read from one image.
pub(super) struct Figures {
    /// The frame that was measured: raw, or less the reference.
    pub image: GreyImage,
    pub threshold_grey: f64,
    pub paper: PaperEstimate,
    pub estimates: Estimates,
}

impl Reading {
    /// The calibration, where one is given.
    pub fn calibration(&self) -> Result<Option<Calibration>, Failure> {
        Ok(self.calibration.as_deref().map(Calibration::load).transpose()?)
    }
}

impl SceneReading {
    /// The reference image, where one is given, for a camera of as many pixels and bits.
    pub fn reference(&self, camera: &Camera) -> Result<Option<GreyImage>, Failure> {
        let Some(path) = &self.image.reference else {
            return Ok(None);
        };
        let (image, _) = grey_image(path, Some(camera.sensor.bit_depth))?;
        let [width, height] = camera.pixels;
        if (image.width(), image.height()) != (width as usize, height as usize) {
            let found = format!("{} x {}", image.width(), image.height());
            let message = format!("{}: has {found} pixels, the camera {width} x {height}", path.display());
            return Err(Failure::input(message).in_file(path));
        }
        let top = f64::from(top_grey(camera.sensor.bit_depth));
        // What does not fit is told before the work.
        let frame = GreyImage::new(image.width(), image.height(), &vec![0.0; image.grey().len()], Some(top))?;
        less(&frame, &image, Some(path))?;
        Ok(Some(image))
    }

    /// What is subtracted, if anything.
    pub fn reference_name(&self) -> Option<String> {
        match (&self.image.reference, self.subtract_baseline) {
            (Some(path), _) => Some(path.display().to_string()),
            (None, true) => Some("baseline.png".into()),
            (None, false) => None,
        }
    }

    /// The threshold for a camera, grey levels.
    pub fn threshold_grey(&self, camera: &Camera) -> f64 {
        self.image.threshold.of(f64::from(top_grey(camera.sensor.bit_depth)))
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
            Some(reference) => less(&raw, reference, self.image.reference.as_deref())?,
            None => raw,
        };
        // A reference is taken to be as noisy as the image.
        let frames = if reference.is_some() { 2.0 } else { 1.0 };
        let threshold_grey = self.threshold_grey(&shot.job.scene().camera);
        let read =
            |variance: f64| estimate(&image, &Settings { threshold_grey, noise_grey: (frames * variance).sqrt() });
        let noise = Noise::of(shot)?;
        // The lit area hangs on pixels at the threshold, h on those at the centroid, sums on all.
        let sums = read(noise.mean_variance());
        let h_grey = match sums.centroid_px.best() {
            Some(&place) => read(noise.variance_near(place)).h_grey,
            None => sums.h_grey.clone(),
        };
        let paper = PaperEstimate { diameter_px: read(noise.of_camera(threshold_grey)).diameter_px, h_grey, ..sums };
        let known = Calibration { mm_per_pixel: shot.mm_per_pixel, bottom_area_mm2: None, force_n_from_sum_grey: None };
        let estimates = Estimates::from_paper(&paper, Some(calibration.unwrap_or(&known)));
        Ok(Figures { image, threshold_grey, paper, estimates })
    }
}

impl Figures {
    /// What is drawn on the frame that was measured.
    pub fn marks(&self) -> Marks {
        Marks { threshold: self.threshold_grey, centroid_px: self.paper.centroid_px.best().copied() }
    }
}

/// An image less a reference; a mistake names the reference.
pub(super) fn less(image: &GreyImage, reference: &GreyImage, path: Option<&Path>) -> Result<GreyImage, Failure> {
    let path = path.unwrap_or(Path::new("reference"));
    image.minus(reference).map_err(|error| Failure::input(format!("{}: {error}", path.display())).in_file(path))
}

/// Reads an image for the estimators, of a camera of so many bits where that is known; also whether its values are
/// radiances and not grey levels.
pub(super) fn grey_image(path: &Path, bits: Option<u32>) -> Result<(GreyImage, bool), Failure> {
    let mut read = read_grey(path)?;
    if let Some(bits) = bits {
        read = read.with_bits(bits, path)?;
    }
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

/// A threshold as it is asked for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Threshold {
    /// Grey levels.
    Levels(f64),
    /// Per cent of the top grey level.
    Percent(f64),
}

impl Default for Threshold {
    fn default() -> Self {
        Self::Levels(Settings::default().threshold_grey)
    }
}

impl Threshold {
    /// In grey levels of an image whose top level is `top_grey`.
    pub fn of(self, top_grey: f64) -> f64 {
        match self {
            Self::Levels(levels) => levels,
            Self::Percent(percent) => 0.01 * percent * top_grey,
        }
    }
}

impl std::fmt::Display for Threshold {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Levels(levels) => write!(f, "{levels}"),
            Self::Percent(percent) => write!(f, "{percent}%"),
        }
    }
}

impl std::str::FromStr for Threshold {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let number = |text: &str| text.trim().parse().ok().filter(|number: &f64| number.is_finite() && *number >= 0.0);
        match text.strip_suffix('%') {
            Some(share) => number(share).filter(|percent| *percent < 100.0).map(Self::Percent),
            None => number(text).map(Self::Levels),
        }
        .ok_or_else(|| {
            "it must be a finite number of grey levels, 0 or more, or a share below 100 % such as `2%`".into()
        })
    }
}
