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
use crate::sweep::Sweep;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Which of the paper's figures is studied.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Paper {
    /// The figure.
    pub figure: PaperFigure,
    /// Threshold k of lit pixels, grey levels: of the size and the stiffness. Default: the paper's 5.
    #[serde(default = "five")]
    pub threshold_grey: f64,
    /// What is published: true value and mean of each phantom, the means in any unit. Absent: nothing to compare with.
    pub published: Option<Vec<[f64; 2]>>,
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
    /// What a reader must know about the image.
    pub warnings: Vec<String>,
}

/// Readings of all images with one truth.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Phantom {
    /// What is true of it.
    pub truth: f64,
    /// Readings.
    pub readings: usize,
    /// Of how many the figure is known.
    pub known: usize,
    /// How many have a warning.
    pub warned: usize,
    /// Mean of these, with the 95 % interval of Student's t: as wide as images that are drawn at random make it.
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
    /// Whether means follow the truth as the paper's do; none where the figure of an image is not known, for a mean of
    /// the others would be of the images that show it.
    pub same_order: Option<bool>,
    /// Whether intervals of all neighbours lie apart: else the means do not tell the order.
    pub apart: Option<bool>,
}

/// Truths that differ by less than this share are the same.
const SAME_TRUTH: f64 = 1e-9;

fn is_same(a: f64, b: f64) -> bool {
    (a - b).abs() <= SAME_TRUTH * b.abs()
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
    if !sweep.keeps_radiance() {
        return Err(unsuited("keeps no radiance: images = { format = \"exr\" }".to_owned()));
    }
    let kept: Vec<_> = sweep.kept(&records).collect();
    if kept.is_empty() {
        return Err(unsuited("has no point with images".to_owned()));
    }
    let mut readings = Vec::new();
    for (done, (row, record)) in kept.iter().enumerate() {
        if !observe(done, kept.len()) {
            return Ok(None);
        }
        let [.., image] = record.images.as_slice() else { continue };
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
        let mm_per_pixel = calibration.map_or(image.mm_per_pixel, |known| known.mm_per_pixel);
        let (value, stiffness) = paper.read(&frames, mm_per_pixel, calibration);
        let settings = paper.settings();
        let warnings = frames.iter().flat_map(|frame| estimate(frame, &settings).warnings).collect();
        let press_mm = image.load.map_or(0.0, |load| load.depth_mm);
        readings.push(Reading { row: *row, truth, press_mm, value, stiffness, warnings });
    }
    Ok(Some(readings))
}

impl Paper {
    fn settings(&self) -> Settings {
        Settings { threshold_grey: self.threshold_grey, ..Settings::default() }
    }

    /// The figure of an image, or of a pair.
    fn read(
        &self,
        frames: &[GreyImage],
        mm_per_pixel: f64,
        calibration: Option<&Calibration>,
    ) -> (Value, Option<Stiffness>) {
        let settings = self.settings();
        match (self.figure, frames, calibration) {
            // Where nothing is lit A is 0, and so is d.
            (PaperFigure::Size, [frame], _) if frame.brighter_than(self.threshold_grey) == 0 => {
                (Value::known(0.0, 0.0, 0.0), None)
            }
            (PaperFigure::Size, [frame], _) => (estimate(frame, &settings).scaled(mm_per_pixel).diameter_mm, None),
            (PaperFigure::Depth, [frame], _) => (estimate(frame, &settings).h_grey, None),
            (PaperFigure::Stiffness, [first, second], Some(calibration)) => {
                let found = stiffness(first, second, &settings, calibration);
                (found.relative_stiffness_kpa.clone(), Some(found))
            }
            _ => (Value::undefined("the stiffness needs two images and a calibration of the sensor"), None),
        }
    }

    /// The published mean of a phantom.
    fn published(&self, truth: f64) -> Option<f64> {
        let published = self.published.iter().flatten().find(|[of, _]| is_same(*of, truth));
        published.map(|[_, mean]| *mean)
    }

    /// What readings say, phantom by phantom.
    pub fn summary(&self, readings: &[Reading]) -> PaperSummary {
        let mut truths: Vec<f64> = readings.iter().map(|reading| reading.truth).collect();
        truths.sort_by(f64::total_cmp);
        truths.dedup_by(|a, b| is_same(*a, *b));
        let mut phantoms: Vec<Phantom> = Vec::with_capacity(truths.len());
        for truth in truths.iter().copied() {
            let of_it: Vec<&Reading> = readings.iter().filter(|reading| is_same(reading.truth, truth)).collect();
            let known: Vec<f64> = of_it.iter().filter_map(|reading| reading.value.best().copied()).collect();
            let reason = of_it.iter().find_map(|reading| match &reading.value {
                Value::Undefined { reason } => Some(reason.clone()),
                Value::Known { .. } => None,
            });
            let (mean, standard_deviation) = match Mean::of(&known) {
                Ok(Mean { mean, standard_deviation }) => (mean, Some(standard_deviation)),
                Err(error) => (Value::undefined(reason.unwrap_or_else(|| error.to_string())), None),
            };
            let first = phantoms.first().map_or(&mean, |first| &first.mean).best();
            phantoms.push(Phantom {
                truth,
                readings: of_it.len(),
                known: known.len(),
                warned: of_it.iter().filter(|reading| !reading.warnings.is_empty()).count(),
                standard_deviation,
                true_ratio: truth / truths[0],
                ratio: mean.best().zip(first).map(|(mean, first)| mean / first).filter(|ratio| ratio.is_finite()),
                published_ratio: self.published(truth).zip(self.published(truths[0])).map(|(mean, first)| mean / first),
                mean,
            });
        }
        let ends = |phantom: &Phantom| match phantom.mean {
            Value::Known { value, low, high } if phantom.known == phantom.readings => Some([value, low, high]),
            _ => None,
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
        Reading { row: 0, truth, press_mm: 2.0, value, stiffness: None, warnings: Vec::new() }
    }

    fn paper(figure: PaperFigure) -> Paper {
        Paper { figure, threshold_grey: 5.0, published: Some(vec![[14.0, 60.0], [2.0, 10.0], [8.0, 20.0]]) }
    }

    #[test]
    fn phantoms_are_told_apart_with_means_ratios_and_order() {
        // What is computed is the same but for rounding.
        let values = [(8.0, 4.0), (2.0, 1.0), (8.0 + 1e-14, 6.0), (14.0, 9.0), (2.0, 3.0), (14.0, 11.0)];
        let readings: Vec<Reading> = values.map(|(truth, value)| reading(truth, Some(value))).to_vec();
        let found = paper(PaperFigure::Size).summary(&readings);
        let told = |k: usize| {
            let phantom = &found.phantoms[k];
            (phantom.truth, phantom.known, phantom.readings, *phantom.mean.best().unwrap(), phantom.ratio.unwrap())
        };
        assert_eq!(
            [told(0), told(1), told(2)],
            [(2.0, 2, 2, 2.0, 1.0), (8.0, 2, 2, 5.0, 2.5), (14.0, 2, 2, 10.0, 5.0)]
        );
        assert_eq!(found.phantoms[1].true_ratio, 4.0);
        let published = |found: &PaperSummary| -> Vec<f64> {
            found.phantoms.iter().map(|phantom| phantom.published_ratio.unwrap()).collect()
        };
        assert_eq!(published(&found), [1.0, 2.0, 6.0]);
        assert!((found.phantoms[0].standard_deviation.unwrap() - 2f64.sqrt()).abs() < 1e-12);
        // Two readings say little: from 2 to 5 the means rise, their intervals overlap.
        assert_eq!((found.same_order, found.apart), (Some(true), Some(false)));
        let close = |value: f64| [reading(value, Some(value)), reading(value, Some(value + 0.01))];
        // Without the smallest, published means are compared with that of the next.
        let apart = paper(PaperFigure::Size).summary(&[close(8.0), close(14.0)].concat());
        assert_eq!((apart.same_order, apart.apart), (Some(true), Some(true)));
        assert_eq!(published(&apart), [1.0, 3.0]);
        // The depth indicator falls where the depth rises.
        assert_eq!(paper(PaperFigure::Depth).summary(&readings).same_order, Some(false));
    }

    #[test]
    fn where_a_figure_is_not_known_there_is_no_order() {
        let some = [reading(2.0, Some(1.0)), reading(2.0, None), reading(8.0, Some(4.0)), reading(8.0, Some(5.0))];
        let found = paper(PaperFigure::Size).summary(&some);
        assert_eq!((found.phantoms[0].known, found.phantoms[1].ratio, found.same_order), (1, None, None));
        let Value::Undefined { reason } = &found.phantoms[0].mean else { panic!("{found:?}") };
        assert_eq!(reason, "nothing is lit");
        // A mean of those that show it is there, and no order.
        let found = paper(PaperFigure::Size).summary(&[&some[..], &[reading(2.0, Some(1.1))]].concat());
        assert!(found.phantoms[0].mean.best().is_some());
        assert_eq!((found.same_order, found.apart), (None, None));
        assert_eq!(paper(PaperFigure::Size).summary(&[]).same_order, None);
    }

    #[test]
    fn an_image_in_which_nothing_is_lit_has_no_diameter() {
        let dark = GreyImage::new(4, 3, &[5.0; 12], Some(255.0)).unwrap();
        assert_eq!(paper(PaperFigure::Size).read(&[dark], 0.1, None).0, Value::known(0.0, 0.0, 0.0));
        let lit = GreyImage::new(4, 3, &[6.0; 12], Some(255.0)).unwrap();
        let d = *paper(PaperFigure::Size).read(&[lit], 0.1, None).0.best().unwrap();
        // 2 sqrt(12 / pi) pixels of 0.1 mm.
        assert!((d - 0.390_882_0).abs() < 1e-6, "{d}");
    }
}
