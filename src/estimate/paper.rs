//! Size, centroid, depth indicator and sum of grey values, as the TSIS paper defines them.
//!
//! - A = number of pixels with I > k; d = 2 sqrt(A / pi) pixels (its equation 10; k = 5 grey levels).
//! - Xc = sum(x I) / sum(I), Yc likewise, over the whole image; h = I(Xc, Yc), a grey value, bilinear between pixels.
//! - M = sum(I).
//!
//! Intervals say how far these figures of the image are known, not how far the inclusion is (a lit area grows with
//! brightness: for a Gaussian of peak I0, d = 2 sigma sqrt(2 ln(I0 / k))).
//!
//! Of an image alone ([`estimate`]) nothing is known of its noise, and they hold less than a new image would show:
//! - d: thresholds one grey level higher and lower (two standard deviations of the noise where that is more), widened
//!   by twice the rms error of counting pixels. Each of the pi d pixels on the edge adds a variance of 1/12 to A, as
//!   if the edge crossed it at random; discs at random places show 0.07.
//! - Xc, Yc, h, M: independent noise of `noise_grey` in every pixel, two standard deviations.
//!
//! h is undefined where a pixel about the centroid is saturated: a camera of a longer scale would have read more.
//!
//! Of a simulated frame ([`measure`]) they hold the mean of the figure over seeds, of light and camera together, 95 %
//! of the time: see `spread.rs`. `benches/coverage.rs` measures that.

use super::exposed::Exposed;
use super::image::GreyImage;
use super::spread::{Reader, Spread, Subtracted, with_error};
use super::told::{by_noise, most_of_the_frame};
use super::value::Value;
use crate::film::MeanError;
use serde::Serialize;
use std::f64::consts::PI;

/// How the image is read.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Settings {
    /// Threshold k: brighter pixels are lit, grey levels.
    pub threshold_grey: f64,
    /// Noise of one pixel, grey levels rms.
    pub noise_grey: f64,
}

impl Default for Settings {
    /// The paper's threshold and the noise of rounding to whole grey levels, 1/sqrt(12).
    fn default() -> Self {
        Self { threshold_grey: 5.0, noise_grey: 1.0 / 12f64.sqrt() }
    }
}

impl Settings {
    /// How far the threshold is moved for the interval of the diameter, grey levels.
    pub(super) fn threshold_step(&self) -> f64 {
        (2.0 * self.noise_grey).max(1.0)
    }
}

/// What the paper reads from one image.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PaperEstimate {
    /// Pixels brighter than the threshold.
    pub lit_pixels: usize,
    /// Diameter d of the disc of as many pixels, pixels.
    pub diameter_px: Value,
    /// The same in mm on the touched face, by the scale on the axis: of what is lit, not of what presses.
    pub diameter_mm: Value,
    /// Centroid (column, row) of the grey values, pixels.
    pub centroid_px: Value<[f64; 2]>,
    /// Depth indicator h, grey levels.
    pub h_grey: Value,
    /// Sum M of the grey values.
    pub sum_grey: Value,
    /// Highest grey value.
    pub max_grey: f64,
    /// Pixels at the camera's top grey level: size and M are then lower bounds.
    pub saturated_pixels: usize,
    /// What the intervals hold.
    pub intervals: &'static str,
    /// What a reader must know about these figures.
    pub warnings: Vec<String>,
}

/// What the intervals hold of an image whose noise is not known.
const OF_THE_IMAGE: &str =
    "rounding to whole grey levels and counting of pixels; noise of light and camera is not known";
/// Of a simulated frame.
const OF_THE_FIGURE: &str = "the mean of the figure over seeds, by the noise of light and camera";
/// Of a simulated frame less an image.
const OF_THE_FRAME: &str =
    "the mean of the figure over seeds, by the noise of light and camera; the reference is taken as it is";
/// Of a simulated frame whose replicates are not known.
const OF_THE_CAMERA: &str = "noise of the camera; that of the light is not known";

impl PaperEstimate {
    /// With the diameter in mm too, by the millimetres per pixel on the touched face.
    pub fn scaled(self, mm_per_pixel: f64) -> Self {
        Self { diameter_mm: self.diameter_px.scaled(mm_per_pixel), ..self }
    }
}

/// Applies the paper's estimators to a simulated frame; `image` is what the camera read of it, less what is subtracted.
pub fn measure(image: &GreyImage, frame: &Exposed, subtracted: Subtracted, threshold_grey: f64) -> PaperEstimate {
    let mut paper = estimate(image, &Settings { threshold_grey, ..Settings::default() });
    let (Some(&sum), centroid) = (paper.sum_grey.best(), paper.centroid_px.best().copied()) else {
        return paper;
    };
    let spread = Reader { frame, subtracted, threshold_grey }.spread(sum, centroid);
    // Rare bright paths, which a mean of few has met or has not, count in full for a sum.
    let [low, high] = spread.sum.interval();
    paper.sum_grey = Value::known(sum, sum + low, sum + high);
    if let Some(place) = centroid {
        let errors = spread.centroid.map(|error| error.half_width());
        let shifted = |sign: f64| [0, 1].map(|axis| place[axis] + sign * errors[axis]);
        paper.centroid_px = Value::Known { value: place, low: shifted(-1.0), high: shifted(1.0) };
    }
    if let Some(&h) = paper.h_grey.best() {
        paper.h_grey = match &spread.h {
            Some(error) => with_error(h, error),
            None => Value::undefined("few paths, or none, brought the light about the centroid: trace more"),
        };
    }
    if paper.lit_pixels > 0 {
        paper.diameter_px = diameter_of_count(paper.lit_pixels, &spread.lit);
    }
    paper.intervals = match (frame.groups().is_empty(), subtracted) {
        (true, _) => OF_THE_CAMERA,
        (false, Subtracted::Image(_)) => OF_THE_FRAME,
        (false, Subtracted::Nothing | Subtracted::Frame(_)) => OF_THE_FIGURE,
    };
    let Spread { lit_by_noise, lit_by_noise_error, .. } = spread;
    paper.warnings.extend(by_noise(paper.lit_pixels, lit_by_noise, lit_by_noise_error.variance));
    paper
}

/// The diameter of so many pixels, with the interval that the variance of their number leaves.
fn diameter_of_count(lit: usize, error: &MeanError) -> Value {
    let half = error.half_width();
    let diameter = |pixels: f64| 2.0 * (pixels.max(0.0) / PI).sqrt();
    let lit = lit as f64;
    Value::known(diameter(lit), diameter(lit - half), diameter(lit + half))
}

/// Applies the paper's estimators to an image (raw, or less a reference frame).
pub fn estimate(image: &GreyImage, settings: &Settings) -> PaperEstimate {
    let sum: f64 = image.grey().iter().sum();
    let sum_error = 2.0 * settings.noise_grey * (image.grey().len() as f64).sqrt();
    let centroid_px = centroid(image, sum, settings.noise_grey);
    let h_grey = match &centroid_px {
        Value::Known { value, .. } if image.is_saturated_at(*value) => Value::undefined(format!(
            "pixels about the centroid are saturated: h is {:.0} grey levels or more; expose less",
            image.at(*value)
        )),
        Value::Known { value, .. } => {
            let h = image.at(*value);
            Value::known(h, h - 2.0 * settings.noise_grey, h + 2.0 * settings.noise_grey)
        }
        Value::Undefined { reason } => Value::undefined(reason.clone()),
    };
    let saturated_pixels = image.saturated_pixels();
    let lit_pixels = image.brighter_than(settings.threshold_grey);
    let mut warnings = Vec::new();
    if saturated_pixels > 0 {
        warnings.push(format!(
            "{saturated_pixels} of {} pixels are saturated: the sum of grey values is a lower bound",
            image.grey().len()
        ));
    }
    warnings.extend(most_of_the_frame(lit_pixels, image.grey().len()));
    PaperEstimate {
        lit_pixels,
        diameter_px: diameter(image, settings),
        diameter_mm: Value::undefined("no calibration gives the millimetres per pixel"),
        centroid_px,
        h_grey,
        sum_grey: Value::known(sum, sum - sum_error, sum + sum_error),
        max_grey: image.grey().iter().copied().fold(f64::NEG_INFINITY, f64::max),
        saturated_pixels,
        intervals: OF_THE_IMAGE,
        warnings,
    }
}

/// Diameter in pixels of the disc of `pixels` pixels, and twice the rms error of counting its edge.
pub(super) fn equivalent_diameter(pixels: usize) -> (f64, f64) {
    let d = 2.0 * (pixels as f64 / PI).sqrt();
    // d d/dA = 2/(pi d) times sqrt(pi d / 12); a single pixel's disc bounds the error of small counts.
    let error = 2.0 * 2.0 / (PI * d.max(1.0)) * (PI * d / 12.0).sqrt();
    (d, error)
}

fn diameter(image: &GreyImage, settings: &Settings) -> Value {
    let k = settings.threshold_grey;
    let lit = image.brighter_than(k);
    if lit == 0 {
        return Value::undefined(format!("no pixel is brighter than the threshold of {k} grey levels"));
    }
    let (d, _) = equivalent_diameter(lit);
    let (least, least_error) = equivalent_diameter(image.brighter_than(k + settings.threshold_step()));
    let (most, most_error) = equivalent_diameter(image.brighter_than(k - settings.threshold_step()));
    Value::known(d, (least - least_error).max(0.0), most + most_error)
}

fn centroid(image: &GreyImage, sum: f64, noise_grey: f64) -> Value<[f64; 2]> {
    if image.grey().iter().all(|&v| v == 0.0) {
        return Value::undefined("the image is blank: it has no centroid");
    }
    if sum <= 0.0 {
        return Value::undefined(format!("the sum of grey values is {sum}: it must be above 0 for a centroid"));
    }
    // Moments about the middle of the image keep digits.
    let (width, height) = (image.width() as f64, image.height() as f64);
    let middle = [0.5 * width, 0.5 * height];
    let mut moment = [0.0; 2];
    for (row, values) in image.grey().chunks_exact(image.width()).enumerate() {
        let row_sum: f64 = values.iter().sum();
        let row_moment: f64 = values.iter().enumerate().map(|(c, v)| (c as f64 + 0.5 - middle[0]) * v).sum();
        moment[0] += row_moment;
        moment[1] += (row as f64 + 0.5 - middle[1]) * row_sum;
    }
    let value = [middle[0] + moment[0] / sum, middle[1] + moment[1] / sum];
    if !(0.0..=width).contains(&value[0]) || !(0.0..=height).contains(&value[1]) {
        return Value::undefined("negative differences push the centroid out of the image");
    }
    // sum over pixels of (x - Xc)^2 = N ((extent^2 - 1)/12 + (middle - Xc)^2).
    let pixels = width * height;
    let error = |axis: usize, extent: f64| {
        let spread = (extent * extent - 1.0) / 12.0 + (moment[axis] / sum).powi(2);
        2.0 * noise_grey * (pixels * spread).sqrt() / sum
    };
    let error = [error(0, width), error(1, height)];
    if !error.iter().all(|e| e.is_finite()) {
        return Value::undefined("the sum of grey values is too small for a centroid");
    }
    let shifted = |sign: f64| [value[0] + sign * error[0], value[1] + sign * error[1]];
    Value::Known { value, low: shifted(-1.0), high: shifted(1.0) }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
#[path = "paper_tests.rs"]
mod tests;
