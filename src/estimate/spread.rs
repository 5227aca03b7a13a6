//! How far the figures of a simulated image vary from seed to seed: what their intervals are made of.
//!
//! A figure T follows its pixels: dT = sum_i a_i df_i, where f_i is what pixel i gives to it (its grey value, or
//! whether it is lit) and a_i says how much that counts. The signal of a pixel before rounding is normal, of variance c
//! + l by camera and light; f_i' is the slope of the mean of f_i against the signal's. Then
//!
//! ```text
//! var T = sum_ij a_i a_j f_i' f_j' L_ij  +  sum_i a_i^2 (var f_i - f_i'^2 l_i)
//! ```
//!
//! with L the covariance of the light between pixels. The first sum needs no model of it: it is the variance of the
//! mean of one number a group of replicates, the sum of a_i f_i' over the group's deviation. Freedom: groups less one.
//! The second is known: cameras' noise is independent from pixel to pixel, and it makes the light's own share right
//! where f is a step and the light's noise crosses it (a jackknife of a count is wrong there: Miller 1974). It is never
//! negative (Cacoullos 1982: var f >= f'^2 var). What is neglected is of second order in the correlation of pairs of
//! pixels. Parts of different freedom are joined by Satterthwaite's rule (1946); that the light of few paths is skewed
//! is told by the third moment over the groups.
//!
//! Where few paths brought a pixel's light it is not normal: there f_i' and var f_i are those of leaving out one group
//! at a time (`exposed.rs`).

use super::exposed::{Exposed, of_few_paths};
use super::image::GreyImage;
use super::value::Value;
use crate::camera::{Response, Signal};
use crate::film::{Group, MeanError};
use rayon::prelude::*;

/// What is subtracted from a frame.
#[derive(Debug, Clone, Copy)]
pub enum Subtracted<'a> {
    /// Nothing.
    Nothing,
    /// An image, taken as it is.
    Image(&'a GreyImage),
    /// A frame of other random numbers.
    Frame(&'a Exposed<'a>),
}

/// Errors of the figures of one image.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Spread {
    pub sum: MeanError,
    pub lit: MeanError,
    /// Column and row.
    pub centroid: [MeanError; 2],
    /// None where few paths, or no path, brought the light about the centroid.
    pub h: Option<MeanError>,
    /// Pixels that would be lit by noise alone, and the error of their number.
    pub lit_by_noise: f64,
    pub lit_by_noise_error: MeanError,
}

/// Figures that are sums over pixels: M, both moments about the centroid over M, lit pixels, pixels lit by noise alone.
const SUMS: usize = 5;
/// Half the window in which the slope of the image at the centroid is fitted, pixels: at least, and in standard errors
/// of the centroid.
const SLOPE_WINDOW: (f64, f64) = (2.0, 2.0);
/// Terms of the series for bilinear weights at a place that is not known well; what is left out is below 0.004.
const SERIES: u32 = 50;

/// A frame, what is subtracted, and how it is read.
pub(super) struct Reader<'a> {
    pub frame: &'a Exposed<'a>,
    pub subtracted: Subtracted<'a>,
    pub threshold_grey: f64,
}

/// Response of one pixel for the figures that count: with the light as it is, and with nothing to be seen.
struct Lit {
    found: Response,
    by_noise: Response,
    /// Slopes of both by the frame's signal and the reference's.
    slopes: [[f64; 2]; 2],
}

impl Reader<'_> {
    /// Variances of the figures of an image with the sum M and the centroid.
    pub fn spread(&self, sum: f64, centroid: Option<[f64; 2]>) -> Spread {
        let place = centroid.unwrap_or_default();
        let per_sum = if centroid.is_some() { 1.0 / sum } else { 0.0 };
        let counts = |pixel: usize| {
            let width = self.frame.width();
            let [column, row] = [pixel % width, pixel / width].map(|n| n as f64 + 0.5);
            [1.0, (column - place[0]) * per_sum, (row - place[1]) * per_sum]
        };
        let lit: Vec<Lit> = (0..self.pixels()).into_par_iter().map(|pixel| self.lit(pixel)).collect();
        let mut known = [0.0; SUMS];
        let mut lit_by_noise = 0.0;
        for (pixel, lit) in lit.iter().enumerate() {
            let rest = self.beyond_light(pixel);
            for (known, count) in known.iter_mut().zip(counts(pixel)) {
                *known += count * count * rest;
            }
            let [frame, reference] = self.light_variances(pixel);
            let count = |found: &Response, [a, b]: [f64; 2]| found.variance - a * a * frame - b * b * reference;
            known[3] += count(&lit.found, lit.slopes[0]);
            known[4] += count(&lit.by_noise, lit.slopes[1]);
            lit_by_noise += lit.by_noise.mean;
        }
        let projected = [0, 1].map(|which| {
            self.exposed(which).map_or_else(Vec::new, |exposed| {
                let one = |group: &Group| sums_of_group(exposed, group, &lit, which, &counts);
                exposed.groups().par_iter().map(one).collect::<Vec<_>>()
            })
        });
        let known = known.map(|known| known.max(0.0));
        let error = |figure: usize| {
            let of_light = |which: usize| self.of_groups(which, projected[which].iter().map(|sums| sums[figure]));
            MeanError::known(known[figure]).plus(of_light(0)).plus(of_light(1))
        };
        let centroid_error = [error(1), error(2)];
        let h = centroid.and_then(|place| self.h(place, centroid_error, [known[1], known[2]], &projected));
        Spread { sum: error(0), centroid: centroid_error, lit: error(3), h, lit_by_noise, lit_by_noise_error: error(4) }
    }

    fn pixels(&self) -> usize {
        self.frame.pixels()
    }

    fn reference(&self) -> Option<&Exposed<'_>> {
        match self.subtracted {
            Subtracted::Frame(reference) => Some(reference),
            Subtracted::Nothing | Subtracted::Image(_) => None,
        }
    }

    /// The frame, or the reference where that has a film.
    fn exposed(&self, which: usize) -> Option<&Exposed<'_>> {
        if which == 0 { Some(self.frame) } else { self.reference() }
    }

    fn light_variances(&self, pixel: usize) -> [f64; 2] {
        [self.frame.light_variance(pixel), self.reference().map_or(0.0, |one| one.light_variance(pixel))]
    }

    /// Variance of a pixel's grey value beyond what the light adds in proportion.
    fn beyond_light(&self, pixel: usize) -> f64 {
        let one = |exposed: &Exposed| {
            let read = exposed.read(pixel);
            read.variance - read.slope * read.slope * exposed.light_variance(pixel)
        };
        one(self.frame) + self.reference().map_or(0.0, one)
    }

    /// Expected grey value of a pixel, less the reference.
    fn expected(&self, pixel: usize) -> f64 {
        let read = self.frame.read(pixel).mean;
        match self.subtracted {
            Subtracted::Nothing => read,
            Subtracted::Image(image) => read - image.grey().get(pixel).copied().unwrap_or(0.0),
            Subtracted::Frame(reference) => read - reference.read(pixel).mean,
        }
    }

    fn lit(&self, pixel: usize) -> Lit {
        let k = self.threshold_grey;
        // Whole levels: more than k means floor(k) + 1 and more, which is read from half a level below on.
        let level = k.floor() + 0.5;
        let read = self.frame.read(pixel);
        // Sheppard: the difference of rounded values is itself rounded once.
        let difference = |mean: f64, variance: f64| Signal { mean, sd: (variance - 1.0 / 12.0).max(0.0).sqrt() };
        let of_frame = |base: f64| match base + k >= self.frame.top() {
            true => Response { mean: 0.0, variance: 0.0, slope: 0.0 },
            false => self.frame.signal(pixel).exceeds((base + k).floor() + 0.5),
        };
        let by_frame = |found: Response| (found, [found.slope, 0.0]);
        match self.subtracted {
            Subtracted::Nothing => {
                let (found, slopes) = self.of_few_paths(pixel, level).unwrap_or_else(|| by_frame(of_frame(0.0)));
                let by_noise = self.frame.dark().exceeds(level);
                Lit { found, by_noise, slopes: [slopes, [0.0, 0.0]] }
            }
            Subtracted::Image(image) => {
                let base = image.grey().get(pixel).copied().unwrap_or(0.0);
                let few = self.of_few_paths(pixel, (base + k).floor() + 0.5);
                let (found, slopes) = few.unwrap_or_else(|| by_frame(of_frame(base)));
                let by_noise = difference(0.0, 2.0 * read.variance).exceeds(level);
                Lit { found, by_noise, slopes: [slopes, [by_noise.slope * read.slope, 0.0]] }
            }
            Subtracted::Frame(reference) => {
                let other = reference.read(pixel);
                let variance = read.variance + other.variance;
                let both = |found: Response| (found, [found.slope * read.slope, found.slope * other.slope]);
                let few = self.of_few_paths(pixel, level);
                let (found, slopes) =
                    few.unwrap_or_else(|| both(difference(read.mean - other.mean, variance).exceeds(level)));
                let (by_noise, by_noise_slopes) = both(difference(0.0, variance).exceeds(level));
                Lit { found, by_noise, slopes: [slopes, by_noise_slopes] }
            }
        }
    }

    /// Whether a pixel is lit whose light few paths brought, in the frame or in the reference, with the slopes by the
    /// signals of both; `None` where many did in both.
    fn of_few_paths(&self, pixel: usize, level: f64) -> Option<(Response, [f64; 2])> {
        let few = [0, 1].map(|which| self.exposed(which).filter(|one| one.is_of_few_paths(pixel)));
        if few.iter().all(Option::is_none) {
            return None;
        }
        let signals = [0, 1].map(|which| self.exposed(which).map(|one| one.signal(pixel)));
        let variance: f64 = signals.iter().flatten().map(|signal| signal.sd * signal.sd).sum();
        let of_few: f64 = few.iter().flatten().map(|one| one.light_variance(pixel)).sum();
        let mean = signals[0].map_or(0.0, |signal| signal.mean) - signals[1].map_or(0.0, |signal| signal.mean);
        let signal = Signal { mean, sd: (variance - of_few).max(0.0).sqrt() };
        let mut found = signal.exceeds(level);
        let by_camera = found.variance;
        let slopes = [(few[0], 1.0), (few[1], -1.0)].map(|(one, sign)| {
            one.map_or(0.0, |one| {
                let moved = |shift: f64| Signal { mean: mean + sign * shift, ..signal }.exceeds(level);
                let by_light = one.of_few_paths(pixel, moved);
                found.variance += by_light.variance - by_camera;
                sign * by_light.slope
            })
        });
        Some((found, slopes))
    }

    /// Of the mean over groups of replicates of one number each.
    fn of_groups(&self, which: usize, numbers: impl Iterator<Item = f64> + Clone) -> MeanError {
        let groups = self.exposed(which).map_or(&[][..], |exposed| exposed.groups());
        let all: f64 = groups.iter().map(|group| f64::from(group.replicates)).sum();
        let shares = groups.iter().map(|group| f64::from(group.replicates) / all);
        let mean: f64 = shares.clone().zip(numbers.clone()).map(|(share, x)| share * x).sum();
        MeanError::of_groups(shares.zip(numbers).map(|(share, x)| (share, x - mean)))
    }

    /// Error of h: of the four pixels about the centroid, and of the centroid on the slope of the image. None where
    /// these pixels' light is not known well enough for one; a reference may be dark there.
    fn h(
        &self,
        place: [f64; 2],
        centroid: [MeanError; 2],
        known_of_centroid: [f64; 2],
        projected: &[Vec<[f64; SUMS]>; 2],
    ) -> Option<MeanError> {
        let errors = centroid.map(|error| error.variance.sqrt());
        let slope = self.slope_at(place, errors);
        let around = GreyImage::around(place, [self.frame.width(), self.pixels() / self.frame.width().max(1)]);
        for which in [0, 1] {
            let Some(exposed) = self.exposed(which).filter(|exposed| !exposed.groups().is_empty()) else { continue };
            let mean: f64 = around.iter().map(|&(pixel, weight)| weight * exposed.light(pixel)).sum();
            let of_group =
                |group| around.iter().map(|&(pixel, weight)| weight * exposed.deviation(group, pixel)).sum::<f64>();
            let variance = self.of_groups(which, exposed.groups().iter().map(of_group)).variance;
            if of_few_paths(mean, variance) || (which == 0 && mean == 0.0) {
                return None;
            }
        }
        let light = [0, 1].map(|which| {
            let numbers: Vec<f64> = self.exposed(which).map_or_else(Vec::new, |exposed| {
                let one = |(group, sums): (&Group, &[f64; SUMS])| {
                    let pixel = |&(pixel, weight): &(usize, f64)| {
                        weight * exposed.read(pixel).slope * exposed.deviation(group, pixel)
                    };
                    around.iter().map(pixel).sum::<f64>() + slope[0] * sums[1] + slope[1] * sums[2]
                };
                exposed.groups().iter().zip(&projected[which]).map(one).collect()
            });
            self.of_groups(which, numbers.iter().copied())
        });
        // Between pixels the weights of a centroid that wanders are not those of the one that was found.
        let squares = bilinear_square(place[0], errors[0]) * bilinear_square(place[1], errors[1]);
        let four: f64 = around.iter().map(|&(pixel, weight)| weight * self.beyond_light(pixel)).sum();
        let known = squares * four + slope[0].powi(2) * known_of_centroid[0] + slope[1].powi(2) * known_of_centroid[1];
        Some(MeanError::known(known).plus(light[0]).plus(light[1]))
    }

    /// Slope of the expected image along columns and rows: a plane fitted about a place.
    fn slope_at(&self, place: [f64; 2], errors: [f64; 2]) -> [f64; 2] {
        let width = self.frame.width();
        let size = [width, self.pixels() / width.max(1)];
        let span = [0, 1].map(|axis| {
            let half = SLOPE_WINDOW.0.max(SLOPE_WINDOW.1 * errors[axis]);
            let last = size[axis].saturating_sub(1);
            let first = ((place[axis] - half).max(0.0) as usize).min(last);
            first..=((place[axis] + half) as usize).min(last)
        });
        let middle = span.clone().map(|range| 0.5 * (range.start() + range.end()) as f64);
        let (mut along, mut squares) = ([0.0; 2], [0.0; 2]);
        for row in span[1].clone() {
            for column in span[0].clone() {
                let value = self.expected(row * width + column);
                let offset = [column as f64 - middle[0], row as f64 - middle[1]];
                for axis in 0..2 {
                    along[axis] += offset[axis] * value;
                    squares[axis] += offset[axis] * offset[axis];
                }
            }
        }
        [0, 1].map(|axis| if squares[axis] > 0.0 { along[axis] / squares[axis] } else { 0.0 })
    }
}

/// One number of a group of replicates for each sum: how far it moves that sum.
fn sums_of_group(
    exposed: &Exposed,
    group: &Group,
    lit: &[Lit],
    which: usize,
    counts: &impl Fn(usize) -> [f64; 3],
) -> [f64; SUMS] {
    let mut sums = [0.0; SUMS];
    for (pixel, lit) in lit.iter().enumerate() {
        let deviation = exposed.deviation(group, pixel);
        let grey = exposed.read(pixel).slope * deviation;
        for (sum, count) in sums.iter_mut().zip(counts(pixel)) {
            *sum += count * grey;
        }
        sums[3] += lit.slopes[0][which] * deviation;
        sums[4] += lit.slopes[1][which] * deviation;
    }
    sums
}

/// Mean of w^2 + (1 - w)^2, w the share of a place between two pixel centres, over places of a normal error: from 1 on
/// a centre to 1/2 between two, and 2/3 for a place that is not known to a pixel (its Fourier series).
fn bilinear_square(place: f64, error: f64) -> f64 {
    use std::f64::consts::{PI, TAU};
    let term = |k: u32| {
        let k = f64::from(k);
        (TAU * k * (place - 0.5)).cos() * (-0.5 * (TAU * k * error).powi(2)).exp() / (k * k)
    };
    2.0 / 3.0 + 2.0 / (PI * PI) * (1..=SERIES).map(term).sum::<f64>()
}

/// A value with half of its interval on either side.
pub(super) fn with_error(value: f64, error: &MeanError) -> Value {
    let half = error.half_width();
    Value::known(value, value - half, value + half)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
#[path = "spread_tests.rs"]
mod tests;
