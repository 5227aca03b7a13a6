//! The paper's figures of a shot.

use super::{PipelineError, Shot};
use crate::estimate::{
    Calibration, Estimates, Exposed, GreyImage, GreyImageError, PaperEstimate, Settings, Subtracted, measure,
};
use crate::film::Film;

/// What is subtracted from a frame.
#[derive(Debug, Clone)]
pub struct Reference {
    /// Its grey values.
    pub image: GreyImage,
    /// What it was exposed from, where that is known.
    pub film: Option<Film>,
}

/// How a shot is read.
#[derive(Debug, Clone)]
pub struct ReadAs<'a> {
    /// Brighter pixels are lit, grey levels.
    pub threshold_grey: f64,
    /// What is subtracted first.
    pub reference: Option<&'a Reference>,
    /// The scale, where another than the scene's is known.
    pub calibration: Option<&'a Calibration>,
}

impl Default for ReadAs<'_> {
    /// The raw frame by the paper's threshold.
    fn default() -> Self {
        Self { threshold_grey: Settings::default().threshold_grey, reference: None, calibration: None }
    }
}

/// What was read from one image.
#[derive(Debug, Clone)]
pub struct Reading {
    /// The frame that was measured: raw, or less the reference.
    pub image: GreyImage,
    /// Brighter pixels are lit, grey levels.
    pub threshold_grey: f64,
    /// The paper's figures.
    pub paper: PaperEstimate,
    /// What they say of the inclusion.
    pub estimates: Estimates,
}

impl Shot<'_> {
    /// Reads the camera's frame.
    ///
    /// # Errors
    /// A reference of another size or depth.
    pub fn read(&self, read_as: &ReadAs) -> Result<Reading, PipelineError> {
        let raw = GreyImage::from_frame(&self.frame)?;
        let reference = read_as.reference;
        let image = match reference {
            Some(reference) => raw.minus(&reference.image)?,
            None => raw,
        };
        let scene = self.prepared.scene();
        let expose = |film| Exposed::new(film, &scene.camera, scene.light.wavelength_nm);
        let frame = expose(&self.outcome.film)?;
        let other = reference.and_then(|reference| reference.film.as_ref()).map(expose).transpose()?;
        let subtracted = match (&other, reference) {
            (Some(frame), _) => Subtracted::Frame(frame),
            (None, Some(reference)) => Subtracted::Image(&reference.image),
            (None, None) => Subtracted::Nothing,
        };
        let mm_per_pixel = read_as.calibration.map_or(self.mm_per_pixel, |calibration| calibration.mm_per_pixel);
        let threshold_grey = read_as.threshold_grey;
        let paper = measure(&image, &frame, subtracted, threshold_grey).scaled(mm_per_pixel);
        Ok(Reading { image, threshold_grey, paper, estimates: Estimates::without_model() })
    }

    /// The shot as what is subtracted from another.
    ///
    /// # Errors
    /// Never for a camera's frame.
    pub fn as_reference(&self) -> Result<Reference, GreyImageError> {
        Ok(Reference { image: GreyImage::from_frame(&self.frame)?, film: Some(self.outcome.film.clone()) })
    }
}
