//! Studies of the TSIS paper, to the letter: its figures of several images of each of a few phantoms.
//!
//! Images are read as they are, nothing subtracted: d = 2 sqrt(A / pi) above k grey levels, h at the centroid, and of
//! pairs E = P / T. The paper gives means, standard deviations and the ratios of means to the first; so does this.

use super::StudyError;
use super::trial::{Seen, exposed, seen};
use crate::calibrate::CalibrateError;
use crate::estimate::{Calibration, GreyImage, Settings, Stiffness, Value, estimate, stiffness};
use crate::pipeline::Truth;
use crate::statistics::Mean;
use crate::sweep::{Format, Sweep};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Which of the paper's figures is studied.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Paper {
    /// The figure.
    pub figure: PaperFigure,
    /// Threshold k of lit pixels, grey levels. Default: the paper's 5.
    #[serde(default = "five")]
    pub threshold_grey: f64,
    /// Published ratios of means to that of the first phantom, by ascending truth. Absent: none to compare with.
    pub published: Option<Vec<f64>>,
}

fn five() -> f64 {
    Settings::default().threshold_grey
}

/// A figure of the paper.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum PaperFigure {
    /// Diameter d of the lit area, mm: against the inclusion's size. Of the last image of each point.
    Size,
    /// Depth indicator h, grey levels: against the depth of its top. Of the last image of each point.
    Depth,
    /// Relative stiffness E = P / T, kPa: against its Young's modulus. Of the last two images of each point.
    Stiffness,
}

impl PaperFigure {
    /// Its name, and its unit.
    pub fn named(self) -> [&'static str; 2] {
        match self {
            Self::Size => ["diameter d of the lit area", "mm"],
            Self::Depth => ["depth indicator h", "grey levels"],
            Self::Stiffness => ["relative stiffness E", "kPa"],
        }
    }

    /// What it is meant to tell, and its unit.
    pub fn truth(self) -> [&'static str; 2] {
        match self {
            Self::Size => ["size", "mm"],
            Self::Depth => ["depth to its top", "mm"],
            Self::Stiffness => ["Young's modulus", "kPa"],
        }
    }

    /// Whether the paper's own figures rise with the truth: h falls with the depth.
    pub fn rises(self) -> bool {
        self != Self::Depth
    }
}

/// What one image, or a pair of images, says.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Reading {
    /// Row of the point in its sweep.
    pub row: usize,
    /// What is true of the inclusion: size (mm), depth (mm) or modulus (kPa), by the figure.
    pub truth: f64,
    /// Depth of the press of the image, or of the second of a pair, mm.
    pub press_mm: f64,
    /// The figure.
    pub value: Value,
    /// What it is made of, where it is a stiffness.
    pub stiffness: Option<Stiffness>,
}

/// Readings of one phantom.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Phantom {
    /// What is true of it.
    pub truth: f64,
    /// Readings.
    pub readings: usize,
    /// Of how many the figure is known.
    pub known: usize,
    /// Mean of these, with the 95 % interval of Student's t.
    pub mean: Value,
    /// Their standard deviation, as the paper gives it.
    pub standard_deviation: Option<f64>,
    /// Truth over that of the first phantom.
    pub true_ratio: f64,
    /// Mean over that of the first phantom.
    pub ratio: Option<f64>,
    /// The same as published.
    pub published_ratio: Option<f64>,
}

/// A study of one of the paper's figures.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PaperSummary {
    /// The figure.
    pub figure: PaperFigure,
    /// Phantoms by ascending truth.
    pub phantoms: Vec<Phantom>,
    /// Whether means of neighbours lie in the paper's order; none where a mean is not known.
    pub same_order: Option<bool>,
    /// Whether intervals of all neighbours lie apart: else their order may be chance.
    pub apart: Option<bool>,
}

/// Readings of all points of a sweep's folder that kept radiance.
///
/// # Errors
/// A folder of another kind; points that keep too few images for the figure, or hold more than one inclusion.
pub fn readings(
    folder: &Path,
    paper: &Paper,
    calibration: Option<&Calibration>,
    exposure_ms: Option<f64>,
    observe: &dyn Fn(usize, usize) -> bool,
) -> Result<Option<Vec<Reading>>, StudyError> {
    let unsuited = |why: String| StudyError::from(CalibrateError::Unsuited { folder: folder.to_path_buf(), why });
    let (sweep, records) = Sweep::of_folder(folder).map_err(CalibrateError::from)?;
    let needed = if paper.figure == PaperFigure::Stiffness { 2 } else { 1 };
    if sweep.file.sweep.images.is_none_or(|images| images.format != Format::Exr) {
        return Err(unsuited("keeps no radiance: images = { format = \"exr\" }".to_owned()));
    }
    let kept: Vec<_> = sweep.kept(&records).collect();
    let mut readings = Vec::new();
    for (done, (row, record)) in kept.iter().enumerate() {
        if !observe(done, kept.len()) {
            return Ok(None);
        }
        if record.images.len() < needed {
            return Err(unsuited("keeps one image a point where the stiffness needs two: loads = \"all\"".to_owned()));
        }
        let Seen { loaded, films } = seen(&sweep, &records, *row, record)?;
        let truth = Truth::of(loaded.scene.phantom.as_ref(), &loaded.files, false)?;
        let truth = match paper.figure {
            PaperFigure::Size => &truth.size_mm,
            PaperFigure::Depth => &truth.depth_mm,
            PaperFigure::Stiffness => &truth.youngs_kpa,
        };
        let truth = truth.value().ok_or_else(|| unsuited(format!("point {row} has not one inclusion")))?;
        let (mut camera, wavelength_nm) = (loaded.scene.camera.clone(), loaded.scene.light.wavelength_nm);
        camera.sensor.exposure_ms = exposure_ms.unwrap_or(camera.sensor.exposure_ms);
        let last = &films[films.len() - needed..];
        let frames = last.iter().map(|film| exposed(film, &camera, wavelength_nm, 0));
        let frames = frames.collect::<Result<Vec<GreyImage>, StudyError>>()?;
        let scale = calibration.map(|known| known.mm_per_pixel);
        let mm_per_pixel = scale.or(record.images.last().map(|image| image.mm_per_pixel));
        let (value, stiffness) = paper.read(&frames, mm_per_pixel.unwrap_or(f64::NAN), calibration);
        let press_mm = record.images.last().and_then(|image| image.load).map_or(0.0, |(_, depth_mm, _)| depth_mm);
        readings.push(Reading { row: *row, truth, press_mm, value, stiffness });
    }
    Ok(Some(readings))
}

impl Paper {
    /// The figure of an image, or of a pair.
    fn read(
        &self,
        frames: &[GreyImage],
        mm_per_pixel: f64,
        calibration: Option<&Calibration>,
    ) -> (Value, Option<Stiffness>) {
        let settings = Settings { threshold_grey: self.threshold_grey, ..Settings::default() };
        match (self.figure, frames, calibration) {
            (PaperFigure::Size, [frame], _) => (estimate(frame, &settings).scaled(mm_per_pixel).diameter_mm, None),
            (PaperFigure::Depth, [frame], _) => (estimate(frame, &settings).h_grey, None),
            (PaperFigure::Stiffness, [first, second], Some(calibration)) => {
                let found = stiffness(first, second, &settings, calibration);
                (found.relative_stiffness_kpa.clone(), Some(found))
            }
            _ => (Value::undefined("the stiffness needs two images and a calibration of the sensor"), None),
        }
    }

    /// What readings say, phantom by phantom.
    pub fn summary(&self, readings: &[Reading]) -> PaperSummary {
        let mut truths: Vec<f64> = readings.iter().map(|reading| reading.truth).collect();
        truths.sort_by(f64::total_cmp);
        truths.dedup();
        let mut phantoms: Vec<Phantom> = Vec::with_capacity(truths.len());
        for (k, truth) in truths.iter().copied().enumerate() {
            let of_it = || readings.iter().filter(|reading| reading.truth == truth);
            let known: Vec<f64> = of_it().filter_map(|reading| reading.value.best().copied()).collect();
            let (mean, standard_deviation) = match Mean::of(&known) {
                Ok(Mean { mean, standard_deviation }) => (mean, Some(standard_deviation)),
                Err(error) => (Value::undefined(error.to_string()), None),
            };
            let first = phantoms.first().map_or(&mean, |first| &first.mean).best();
            phantoms.push(Phantom {
                truth,
                readings: of_it().count(),
                known: known.len(),
                standard_deviation,
                true_ratio: truth / truths[0],
                ratio: mean.best().zip(first).map(|(mean, first)| mean / first),
                published_ratio: self.published.as_ref().and_then(|published| published.get(k).copied()),
                mean,
            });
        }
        let ends = |phantom: &Phantom| match phantom.mean {
            Value::Known { value, low, high } => Some([value, low, high]),
            Value::Undefined { .. } => None,
        };
        let means: Option<Vec<[f64; 3]>> = phantoms.iter().map(ends).collect();
        let means = means.filter(|means| means.len() > 1);
        let all = |holds: &dyn Fn(&[f64; 3], &[f64; 3]) -> bool| {
            Some(means.as_ref()?.windows(2).all(|pair| holds(&pair[0], &pair[1])))
        };
        let same_order = all(&|[a, ..], [b, ..]| if self.figure.rises() { a < b } else { a > b });
        let apart = all(&|[_, a_low, a_high], [_, b_low, b_high]| a_high < b_low || b_high < a_low);
        PaperSummary { figure: self.figure, phantoms, same_order, apart }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    fn reading(truth: f64, value: Option<f64>) -> Reading {
        let value = value.map_or(Value::undefined("nothing is lit"), |value| Value::known(value, value, value));
        Reading { row: 0, truth, press_mm: 2.0, value, stiffness: None }
    }

    fn paper(figure: PaperFigure) -> Paper {
        Paper { figure, threshold_grey: 5.0, published: Some(vec![1.0, 1.85, 6.71]) }
    }

    #[test]
    fn phantoms_are_told_apart_with_means_ratios_and_order() {
        let values = [(8.0, 4.0), (2.0, 1.0), (8.0, 6.0), (14.0, 9.0), (2.0, 3.0), (14.0, 11.0)];
        let mut readings: Vec<Reading> = values.map(|(truth, value)| reading(truth, Some(value))).to_vec();
        readings.push(reading(2.0, None));
        let found = paper(PaperFigure::Size).summary(&readings);
        let told = |k: usize| {
            let phantom = &found.phantoms[k];
            (phantom.truth, phantom.known, phantom.readings, *phantom.mean.best().unwrap(), phantom.ratio.unwrap())
        };
        assert_eq!(
            [told(0), told(1), told(2)],
            [(2.0, 2, 3, 2.0, 1.0), (8.0, 2, 2, 5.0, 2.5), (14.0, 2, 2, 10.0, 5.0)]
        );
        assert_eq!(found.phantoms[1].true_ratio, 4.0);
        assert_eq!(found.phantoms[2].published_ratio, Some(6.71));
        assert!((found.phantoms[0].standard_deviation.unwrap() - 2f64.sqrt()).abs() < 1e-12);
        // Two readings say little: from 2 to 5 the means rise, their intervals overlap.
        assert_eq!((found.same_order, found.apart), (Some(true), Some(false)));
        let close = |value: f64| [reading(value, Some(value)), reading(value, Some(value + 0.01))];
        let found_apart = paper(PaperFigure::Size).summary(&[close(2.0), close(8.0)].concat());
        assert_eq!((found_apart.same_order, found_apart.apart), (Some(true), Some(true)));
        // The depth indicator falls where the depth rises.
        assert_eq!(paper(PaperFigure::Depth).summary(&readings).same_order, Some(false));
    }

    #[test]
    fn a_phantom_with_one_known_reading_has_no_mean_and_there_is_no_order() {
        let readings = [reading(2.0, Some(1.0)), reading(2.0, None), reading(8.0, Some(4.0)), reading(8.0, Some(5.0))];
        let found = paper(PaperFigure::Size).summary(&readings);
        assert_eq!((found.phantoms[0].known, found.phantoms[0].mean.best()), (1, None));
        assert_eq!((found.phantoms[1].ratio, found.same_order), (None, None));
        assert_eq!(paper(PaperFigure::Size).summary(&[]).same_order, None);
    }
}
