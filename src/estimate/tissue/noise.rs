//! How exactly features are known: the noise that frames show themselves, and what it does to their features.
//!
//! A pressure's noise is independent from place to place, with variance a² + (b p)². Within the contact the pressure is
//! smooth over four neighbours, so their third difference, scaled to the variance of one, is noise: its mean square at
//! low and at high pressure tells a and b. Noise that neighbours share is not seen so; the fit's own residual is.

use super::TissueError;
use super::unknowns::force;
use crate::camera::noise::PixelRandom;
use crate::mechanics::frames::{Features, Frame, Frames, FramesError, Settings, of_frame};
use faer::Mat;
use serde::Serialize;

/// Features of a frame, in this order: peak, base, width, eccentricity.
pub(super) const KINDS: usize = 4;

/// Places at each end of a contact that are left out: the pressure's slope is infinite at the end.
const ENDS: usize = 3;
/// Fewest third differences that tell the noise.
const LEAST_DIFFERENCES: usize = 40;
/// An eccentricity counts where what the inclusion adds is this many times the noise, and this share of the highest
/// pressure: below, the integral of its absolute value is that of noise, or of the mesh.
const ABOVE_NOISE: f64 = 5.0;
const ABOVE_MESH: f64 = 0.005;
/// Step of the features' derivatives, as a share of the highest pressure.
const STEP: f64 = 1e-4;

/// Noise of one pressure.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Noise {
    /// The part that is the same everywhere, kPa rms.
    pub constant_kpa: f64,
    /// The part that is a share of the pressure.
    pub share: f64,
}

impl Noise {
    /// The noise that frames show; none where too few places are in contact.
    pub fn of(frames: &Frames, contact_above_kpa: f64) -> Option<Self> {
        // Squares of the scaled third difference, with the pressure.
        let mut squares: Vec<[f64; 2]> = Vec::new();
        for frame in frames.as_slice() {
            let touches = |p: &f64| *p > contact_above_kpa;
            let ends = frame.pressure_kpa.iter().position(touches).zip(frame.pressure_kpa.iter().rposition(touches));
            let Some((first, last)) = ends else { continue };
            for k in (first + ENDS)..(last.saturating_sub(ENDS + 2)) {
                let (x, p) = (&frame.x_mm[k..k + 4], &frame.pressure_kpa[k..k + 4]);
                squares.push([0.25 * p.iter().sum::<f64>(), third_difference(x, p).powi(2)]);
            }
        }
        if squares.len() < LEAST_DIFFERENCES {
            return None;
        }
        squares.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let mean = |part: &[[f64; 2]]| {
            let n = part.len().max(1) as f64;
            [part.iter().map(|s| s[0] * s[0]).sum::<f64>() / n, part.iter().map(|s| s[1]).sum::<f64>() / n]
        };
        let (low, high) = squares.split_at(squares.len() / 2);
        let ([p_low, e_low], [p_high, e_high], [p, e]) = (mean(low), mean(high), mean(&squares));
        let (square, constant) = match (e_high - e_low) / (p_high - p_low) {
            slope if !(slope > 0.0 && slope.is_finite()) => (0.0, e),
            slope if slope * p_low > e_low => (e / p, 0.0),
            slope => (slope, e_low - slope * p_low),
        };
        Some(Self { constant_kpa: constant.sqrt(), share: square.sqrt() })
    }

    fn variance(&self, pressure_kpa: f64) -> f64 {
        self.constant_kpa.powi(2) + (self.share * pressure_kpa).powi(2)
    }
}

/// Frames as a sensor would see them whose pressures each have independent normal noise, a share of themselves.
///
/// # Errors
/// Where a noisy pressure is not finite.
pub fn noisy(frames: &Frames, share: f64, seed: u32) -> Result<Frames, FramesError> {
    let noisy = |(k, frame): (u32, &Frame)| {
        let mut random = PixelRandom::new(seed, k);
        let pressure_kpa = frame.pressure_kpa.iter().map(|p| p * (1.0 + share * random.normal())).collect();
        Frame { pressure_kpa, ..frame.clone() }
    };
    Frames::new((0..).zip(frames.as_slice()).map(noisy).collect())
}

/// The third divided difference of four pressures, scaled so that independent noise keeps its variance.
fn third_difference(x: &[f64], p: &[f64]) -> f64 {
    let weight = |i: usize| 1.0 / (0..4).filter(|&j| j != i).map(|j| x[i] - x[j]).product::<f64>();
    let weights: Vec<f64> = (0..4).map(weight).collect();
    let size = weights.iter().map(|w| w * w).sum::<f64>().sqrt();
    weights.iter().zip(p).map(|(w, p)| w * p).sum::<f64>() / size
}

/// Features that can be fitted at once: their covariance has as many entries as the square of that.
const MOST_FEATURES: usize = 2_000;

/// The features of a frame, none where it has none.
pub(super) fn numbers(features: &Features) -> [Option<f64>; KINDS] {
    [&features.peak_kpa, &features.base_kpa, &features.fwhm_mm, &features.eccentricity].map(|figure| figure.value())
}

/// The features that can be fitted, and the covariance that the pressures' noise gives them.
pub(super) struct Seen {
    /// Number of each feature: four times that of its frame, and its kind.
    pub used: Vec<usize>,
    /// Their values.
    pub values: Vec<f64>,
    /// Their covariance.
    pub covariance: Mat<f64>,
}

impl Seen {
    pub fn of(frames: &Frames, noise: Noise, settings: &Settings) -> Result<Self, TissueError> {
        let (all, far) = (frames.as_slice(), frames.farthest());
        let highest = all.iter().flat_map(|frame| &frame.pressure_kpa).fold(0.0, |most: f64, p| most.max(*p));
        let felt = |frame: &Frame| {
            let places = frame.pressure_kpa.iter().zip(&far.pressure_kpa).filter(|(p, q)| **p > 0.0 || **q > 0.0);
            let (mut added, mut noisy, mut count) = (0.0, 0.0, 0.0);
            for (p, q) in places {
                added += (p - q).abs();
                noisy += noise.variance(*p) + noise.variance(*q);
                count += 1.0;
            }
            added > ABOVE_NOISE * (count * noisy).sqrt() && added > ABOVE_MESH * highest * count
        };
        let (mut used, mut values) = (Vec::new(), Vec::new());
        for (k, frame) in all.iter().enumerate() {
            for (kind, value) in numbers(&of_frame(frame, far, settings)).into_iter().enumerate() {
                if let Some(value) = value.filter(|_| kind < 3 || felt(frame)) {
                    used.push(KINDS * k + kind);
                    values.push(value);
                }
            }
        }
        if used.len() > MOST_FEATURES {
            return Err(TissueError::TooMany { features: used.len(), most: MOST_FEATURES });
        }
        let covariance = covariance(frames, noise, settings, &used, (STEP * highest, &[]));
        Ok(Self { used, values, covariance })
    }

    /// The same where frames are compared with those of the same forces: a force has the noise of its pressures, and
    /// `by_force` are the derivatives of the compared features by its logarithm.
    pub fn hold_forces(&mut self, frames: &Frames, noise: Noise, settings: &Settings, by_force: &[f64]) {
        let highest =
            frames.as_slice().iter().flat_map(|frame| &frame.pressure_kpa).fold(0.0, |most: f64, p| most.max(*p));
        self.covariance = covariance(frames, noise, settings, &self.used, (STEP * highest, by_force));
    }

    /// Those features of other frames at the same positions; NaN where one is undefined.
    pub fn pick(&self, features: &[Features]) -> Vec<f64> {
        let all: Vec<[Option<f64>; KINDS]> = features.iter().map(numbers).collect();
        let value = |place: usize| all.get(place / KINDS).and_then(|frame| frame[place % KINDS]).unwrap_or(f64::NAN);
        self.used.iter().map(|&place| value(place)).collect()
    }
}

/// Derivative of the logarithm of a frame's force by one of its pressures, per kPa.
fn part_of_force(frame: &Frame, place: usize) -> f64 {
    let x = &frame.x_mm;
    let width = |pair: Option<&[f64]>| pair.map_or(0.0, |pair| 0.5 * (pair[1] - pair[0]));
    let before = place.checked_sub(1).and_then(|first| x.get(first..first + 2));
    1e-3 * (width(before) + width(x.get(place..place + 2))) / force(frame)
}

/// J S J' with the variances S of all pressures and the derivatives J by them of what is compared: the used features,
/// less what those of the same force change by the pressures' part in it, where forces are held.
fn covariance(
    frames: &Frames,
    noise: Noise,
    settings: &Settings,
    used: &[usize],
    (step, by_force): (f64, &[f64]),
) -> Mat<f64> {
    let all = frames.as_slice();
    let far = all.iter().position(|frame| frame == frames.farthest()).unwrap_or(0);
    let places = all.first().map_or(0, |frame| frame.x_mm.len());
    let mut row = vec![None; KINDS * all.len()];
    used.iter().enumerate().for_each(|(row_of, &place)| row[place] = Some(row_of));
    let mut whole = Mat::<f64>::zeros(used.len(), used.len());
    for (k, frame) in all.iter().enumerate() {
        // What this frame's pressures change: its own features, and as the reference all eccentricities.
        let touched: Vec<usize> = if k == far { (0..all.len()).collect() } else { vec![k] };
        let mut slopes = Mat::<f64>::zeros(used.len(), places);
        for i in 0..places {
            let variance = noise.variance(frame.pressure_kpa[i]);
            if frame.pressure_kpa[i] <= settings.contact_above_kpa || variance == 0.0 {
                continue;
            }
            let moved = |by: f64| {
                let mut moved = frame.clone();
                moved.pressure_kpa[i] += by;
                moved
            };
            let sides = [moved(step), moved(-step)];
            for &other in &touched {
                let both = [0, 1].map(|side| {
                    let reference = if k == far { &sides[side] } else { &all[far] };
                    let seen = if other == k { &sides[side] } else { &all[other] };
                    numbers(&of_frame(seen, reference, settings))
                });
                for kind in 0..KINDS {
                    if let (Some(row), Some(up), Some(down)) = (row[KINDS * other + kind], both[0][kind], both[1][kind])
                    {
                        slopes[(row, i)] = (up - down) / (2.0 * step) * variance.sqrt();
                    }
                }
            }
        }
        for own in row[KINDS * k..KINDS * (k + 1)].iter().copied().flatten() {
            let Some(by_force) = by_force.get(own) else { continue };
            for i in 0..places {
                let pressure = frame.pressure_kpa[i];
                if pressure > settings.contact_above_kpa {
                    slopes[(own, i)] -= by_force * part_of_force(frame, i) * noise.variance(pressure).sqrt();
                }
            }
        }
        whole += &slopes * slopes.transpose();
    }
    whole
}
