//! What is measured at each point, and how far it is known.
//!
//! Intervals are of 95 %. Figures of an image take theirs from groups of replicates, each left out in turn (the
//! jackknife): how neighbouring pixels move together is in it. Shares of the ledger take that of counted photons, which
//! weights between 0 and 1 do not exceed. Figures of the press take the error that it estimates of itself.

use crate::camera::{Saturation, expected_electrons};
use crate::estimate::Value;
use crate::figure::Figure;
use crate::film::{Film, MeanError, quantile_95};
use crate::mechanics::press::{PressStep, Pressed};
use crate::pipeline::{ReadAs, Reference, Shot, StepSummary, view_of};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A figure: an entry of `[[measure]]`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields, tag = "kind")]
pub enum Measure {
    /// Mean radiance of the image, W/(m^2 sr).
    MeanRadiance {},
    /// Difference of the mean radiances of a disc and of the ring about it, over their sum.
    Contrast {
        /// Centre on the touched face, mm. Default: the middle.
        #[serde(default)]
        center_mm: [f64; 2],
        /// Radius of the disc, mm. Default: 3.
        #[serde(default = "radius")]
        radius_mm: f64,
        /// Inner and outer radius of the ring, mm. Default: 5 and 7.
        #[serde(default = "ring")]
        around_mm: [f64; 2],
    },
    /// What the inclusions add to the electrons of a pixel in a disc, over the noise of the camera in the difference of
    /// two frames. It takes a second image, of the phantom without inclusions. Undefined where over a hundredth of the
    /// disc's pixels is at the top grey level in either.
    Snr {
        /// Centre on the touched face, mm. Default: the middle.
        #[serde(default)]
        center_mm: [f64; 2],
        /// Radius of the disc, mm. Default: 3.
        #[serde(default = "radius")]
        radius_mm: f64,
    },
    /// Spread of the radiance over a disc over its mean, without the noise.
    Unevenness {
        /// Centre on the touched face, mm. Default: the middle.
        #[serde(default)]
        center_mm: [f64; 2],
        /// Radius of the disc, mm. Default: 3.
        #[serde(default = "radius")]
        radius_mm: f64,
    },
    /// Share of the emitted light that leaves through neither face.
    Trapped {},
    /// Shares of the emitted light that leave through the touched side, the camera's side and the side walls.
    Escaped {},
    /// Share of the emitted light that layers, tissue and walls absorb.
    Absorbed {},
    /// Share of pixels that are expected at the top grey level, over the noise of the camera.
    Saturated {},
    /// Mean grey level of the frame.
    MeanGrey {},
    /// Force of the press, N.
    Force {},
    /// Largest contact pressure over 0.8 of the footprint's radius, kPa.
    PeakPressure {},
    /// The paper's figures of the frame: diameter of the lit area, depth indicator, sum of grey values.
    Paper {
        /// Less the frame of the phantom without inclusions. It takes a second image.
        #[serde(default)]
        less_baseline: bool,
        /// Pixels above this are lit, grey levels. Default: 5.
        #[serde(default = "paper_threshold")]
        threshold_grey: f64,
    },
}

fn radius() -> f64 {
    3.0
}

fn ring() -> [f64; 2] {
    [5.0, 7.0]
}

fn paper_threshold() -> f64 {
    crate::estimate::Settings::default().threshold_grey
}

/// A figure of a point: a value with its 95 % interval, a value whose error is not known, or none; with the reason.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Told {
    /// The value.
    pub value: Option<f64>,
    /// Lower end of its interval.
    pub low: Option<f64>,
    /// Upper end of its interval.
    pub high: Option<f64>,
    /// Why there is no value, or no interval.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub note: Option<String>,
}

impl Told {
    fn undefined(reason: impl Into<String>) -> Self {
        Self { note: Some(reason.into()), ..Self::default() }
    }
}

impl From<Value> for Told {
    fn from(value: Value) -> Self {
        match value {
            Value::Known { value, low, high } => {
                Self { value: Some(value), low: Some(low), high: Some(high), note: None }
            }
            Value::Undefined { reason } => Self::undefined(reason),
        }
    }
}

/// What a point was found to be.
pub(super) struct Found<'a> {
    /// The press and its load.
    pub pressed: Option<(&'a Pressed, &'a PressStep)>,
    /// The image.
    pub shot: Option<&'a Shot<'a>>,
    /// The image without inclusions.
    pub baseline: Option<&'a Shot<'a>>,
}

impl Measure {
    /// Whether it needs an image.
    pub fn needs_light(&self) -> bool {
        !self.needs_press()
    }

    /// Whether it is of the press alone.
    pub fn needs_press(&self) -> bool {
        matches!(self, Self::Force {} | Self::PeakPressure {})
    }

    /// Whether it needs an image without inclusions too.
    pub fn needs_baseline(&self) -> bool {
        matches!(self, Self::Snr { .. } | Self::Paper { less_baseline: true, .. })
    }

    /// Names of its figures, with their units.
    pub fn columns(&self) -> &'static [&'static str] {
        match self {
            Self::MeanRadiance {} => &["mean_radiance_w_m2_sr"],
            Self::Contrast { .. } => &["contrast"],
            Self::Snr { .. } => &["snr"],
            Self::Unevenness { .. } => &["unevenness"],
            Self::Trapped {} => &["trapped"],
            Self::Escaped {} => &["escaped_top", "escaped_bottom", "escaped_sides"],
            Self::Absorbed {} => &["absorbed"],
            Self::Saturated {} => &["saturated"],
            Self::MeanGrey {} => &["mean_grey"],
            Self::Force {} => &["force_n"],
            Self::PeakPressure {} => &["peak_pressure_kpa"],
            Self::Paper { .. } => &["diameter_mm", "h_grey", "sum_grey"],
        }
    }

    /// Its figures of a point, in the order of [`Self::columns`].
    pub(super) fn of(&self, found: &Found) -> Vec<Told> {
        match (self, found.shot) {
            (Self::Force {} | Self::PeakPressure {}, _) => vec![self.of_press(found.pressed)],
            (_, Some(shot)) => self.of_shot(shot, found.baseline).into_iter().map(Told::from).collect(),
            (_, None) => self.columns().iter().map(|_| Told::undefined("no image was traced")).collect(),
        }
    }

    fn of_press(&self, pressed: Option<(&Pressed, &PressStep)>) -> Told {
        let Some((pressed, step)) = pressed else { return Told::undefined("the scene presses nothing") };
        let summary = StepSummary::of(pressed, step);
        let (value, error) = match self {
            Self::Force {} => (summary.force_n, &summary.force_error),
            _ => (summary.peak_pressure_kpa, &summary.peak_error),
        };
        match error {
            Figure::Known(error) => {
                let half = error * value.abs();
                Value::known(value, value - half, value + half).into()
            }
            // A force is known as well as its mesh; what is missing is how well.
            Figure::Undefined { reason } => {
                Told { value: Some(value), note: Some(format!("of unknown error: {reason}")), ..Told::default() }
            }
        }
    }

    fn of_shot(&self, shot: &Shot, baseline: Option<&Shot>) -> Vec<Value> {
        let film = &shot.outcome.film;
        let share = |share: f64| of_counted(share, shot.outcome.ledger_photons);
        let ledger = &shot.outcome.ledger;
        match *self {
            Self::MeanRadiance {} => match shot.outcome.unseen.mean_below {
                Some(bound) => vec![Value::known(0.0, 0.0, bound)],
                None => vec![jackknife(&[film], |means| mean(means[0].iter().copied()))],
            },
            Self::Contrast { center_mm, radius_mm, around_mm } => {
                let disc = self.pixels(shot, center_mm, [0.0, radius_mm]);
                let ring = self.pixels(shot, center_mm, around_mm);
                if disc.is_empty() || ring.is_empty() {
                    return vec![Value::undefined("the camera sees no pixel of the disc, or none of the ring")];
                }
                let of = |values: &[f64]| {
                    let [inside, outside] =
                        [&disc, &ring].map(|pixels| mean(pixels.iter().map(|&pixel| values[pixel])));
                    (inside - outside) / (inside + outside)
                };
                vec![jackknife(&[film], |means| of(means[0]))]
            }
            Self::Snr { center_mm, radius_mm } => {
                let pixels = self.pixels(shot, center_mm, [0.0, radius_mm]);
                vec![baseline.map_or_else(
                    || Value::undefined("there is no image without inclusions"),
                    |baseline| signal_to_noise(shot, baseline, &pixels),
                )]
            }
            Self::Unevenness { center_mm, radius_mm } => {
                vec![unevenness(film, &self.pixels(shot, center_mm, [0.0, radius_mm]))]
            }
            Self::Trapped {} => vec![share(1.0 - ledger.escaped_top - ledger.escaped_bottom)],
            Self::Escaped {} => [ledger.escaped_top, ledger.escaped_bottom, ledger.escaped_sides].map(share).to_vec(),
            Self::Absorbed {} => vec![share(ledger.absorbed)],
            Self::Saturated {} => vec![saturated(shot)],
            Self::MeanGrey {} => {
                let reading = shot.read(&ReadAs::default());
                let pixels = shot.frame.grey.len().max(1) as f64;
                vec![reading.map_or_else(
                    |error| Value::undefined(error.to_string()),
                    |reading| reading.paper.sum_grey.scaled(1.0 / pixels),
                )]
            }
            Self::Paper { less_baseline, threshold_grey } => {
                let reference: Option<Reference> =
                    baseline.filter(|_| less_baseline).and_then(|baseline| baseline.as_reference().ok());
                if less_baseline && reference.is_none() {
                    return vec![Value::undefined("there is no image without inclusions"); 3];
                }
                let read_as = ReadAs { threshold_grey, reference: reference.as_ref(), calibration: None };
                match shot.read(&read_as) {
                    Ok(reading) => {
                        let paper = reading.paper;
                        vec![paper.diameter_mm, paper.h_grey, paper.sum_grey]
                    }
                    Err(error) => vec![Value::undefined(error.to_string()); 3],
                }
            }
            Self::Force {} | Self::PeakPressure {} => Vec::new(),
        }
    }

    /// Pixels whose middles see the touched face between two distances from a point of it, mm.
    fn pixels(&self, shot: &Shot, center_mm: [f64; 2], between_mm: [f64; 2]) -> Vec<usize> {
        let Ok(view) = view_of(shot.prepared.scene()) else { return Vec::new() };
        let film = &shot.outcome.film;
        let width = film.width.max(1) as usize;
        let is_inside = |pixel: &usize| {
            let middle = [(pixel % width) as f64 + 0.5, (pixel / width) as f64 + 0.5];
            view.touched_from_pixel(middle).is_some_and(|[x, y]| {
                let away = (x - center_mm[0]).hypot(y - center_mm[1]);
                (between_mm[0]..=between_mm[1]).contains(&away)
            })
        };
        (0..film.mean.len()).filter(is_inside).collect()
    }
}

fn mean(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = values.len().max(1) as f64;
    values.sum::<f64>() / count
}

/// A share of so many photons.
fn of_counted(share: f64, photons: u64) -> Value {
    if photons == 0 {
        return Value::undefined("no photons were counted");
    }
    let (n, z) = (photons as f64, quantile_95(f64::INFINITY));
    // Wilson, Journal of the American Statistical Association 22, 1927: holds near 0 and 1 too.
    let p = share.clamp(0.0, 1.0);
    let middle = (p + z * z / (2.0 * n)) / (1.0 + z * z / n);
    let half = z / (1.0 + z * z / n) * (p * (1.0 - p) / n + z * z / (4.0 * n * n)).sqrt();
    Value::known(share, (middle - half).min(share), (middle + half).max(share))
}

/// A figure of the mean images of films that are independent of each other.
fn jackknife(films: &[&Film], figure: impl Fn(&[&[f64]]) -> f64) -> Value {
    let wide = |values: &[f32]| values.iter().map(|&v| f64::from(v)).collect::<Vec<f64>>();
    let whole: Vec<Vec<f64>> = films.iter().map(|film| wide(&film.mean)).collect();
    let of = |means: &[Vec<f64>]| figure(&means.iter().map(Vec::as_slice).collect::<Vec<_>>());
    let value = of(&whole);
    let mut error = MeanError::default();
    for (k, film) in films.iter().enumerate() {
        let groups = &film.groups;
        if groups.len() < 2 {
            return Value::undefined("the image has too few replicates to know its error");
        }
        let all: f64 = groups.iter().map(|group| f64::from(group.replicates)).sum();
        // Groups may differ in size (the last one): each is left out by its own weight, and were the figure a mean, it
        // would depart by this from that of all (pseudo-values: Tukey 1958).
        let left_out = groups.iter().map(|group| {
            let share = f64::from(group.replicates) / all;
            let without = whole[k].iter().zip(&group.mean).map(|(m, g)| (m - share * f64::from(*g)) / (1.0 - share));
            let mut means = whole.clone();
            means[k] = without.collect();
            (share, (1.0 - share) / share * (value - of(&means)))
        });
        error = error.plus(MeanError::of_groups(left_out.collect::<Vec<_>>().into_iter()));
    }
    let half = error.half_width();
    Value::known(value, value - half, value + half)
}

/// Share of the pixels at the top grey level above which a signal is not that of the light.
const MOST_FULL: f64 = 0.01;

/// Expected electrons of a shot's pixels for a mean image.
fn electrons(shot: &Shot, mean: &[f64]) -> Option<Vec<f64>> {
    let (scene, like) = (shot.prepared.scene(), &shot.outcome.film);
    // Where a pixel has its light from one group alone, the mean of the others may round to below 0.
    let mean = mean.iter().map(|&v| v.max(0.0) as f32).collect();
    let film = Film { width: like.width, height: like.height, mean, ..Film::default() };
    expected_electrons(&film, &scene.camera, scene.light.wavelength_nm).ok()
}

/// The expected share of pixels at the top grey level. Noise that pixels share, and what it adds where most of them are
/// on one side of that level, lie between the shares of an image with each pixel at the lower and at the upper end of
/// its own interval. A pixel's few paths may not know those ends; by how much pixels cross, groups of replicates tell.
fn saturated(shot: &Shot) -> Value {
    let film = &shot.outcome.film;
    if shot.outcome.unseen.mean_below.is_some_and(|bound| bound > 0.0) {
        return Value::undefined("no path found light");
    }
    let saturation = Saturation::of(&shot.prepared.scene().camera.sensor);
    let share = |mean: &[f64]| electrons(shot, mean).map_or(f64::NAN, |electrons| saturation.share(&electrons));
    let by_groups = jackknife(&[film], |means| share(means[0]));
    let Value::Known { value, low, high } = by_groups else { return by_groups };
    let wide = quantile_95(f64::from(film.replicates) - 1.0);
    let [least, most] = [-wide, wide].map(|off| {
        let pixels = film.mean.iter().zip(&film.variance);
        share(&pixels.map(|(&mean, &v)| f64::from(mean) + off * f64::from(v).sqrt()).collect::<Vec<_>>())
    });
    Value::known(value, low.min(least).max(0.0), high.max(most).min(1.0))
}

/// What inclusions add to a pixel over the camera's noise; undefined where pixels are full, and hold no more.
fn signal_to_noise(shot: &Shot, baseline: &Shot, pixels: &[usize]) -> Value {
    if pixels.is_empty() {
        return Value::undefined("the camera sees no pixel of the disc");
    }
    let sensor = &shot.prepared.scene().camera.sensor;
    let saturation = Saturation::of(sensor);
    let full = |shot: &Shot| {
        let mean: Vec<f64> = shot.outcome.film.mean.iter().map(|&v| f64::from(v)).collect();
        let of_disc = |all: Vec<f64>| pixels.iter().map(|&pixel| all[pixel]).collect::<Vec<_>>();
        electrons(shot, &mean).map_or(0.0, |all| saturation.share(&of_disc(all)))
    };
    if full(shot).max(full(baseline)) > MOST_FULL {
        return Value::undefined("pixels of the disc are at the top grey level: expose for less");
    }
    let gain = f64::from((1u32 << sensor.bit_depth) - 1) / sensor.full_well_e;
    // Two read-outs and two roundings.
    let fixed = 2.0 * (sensor.read_noise_e.powi(2) + 1.0 / (12.0 * gain * gain));
    let (film, other) = (&shot.outcome.film, &baseline.outcome.film);
    jackknife(&[film, other], |means| match (electrons(shot, means[0]), electrons(baseline, means[1])) {
        (Some(with), Some(without)) => {
            let signal = mean(pixels.iter().map(|&pixel| with[pixel] - without[pixel]));
            let noise = mean(pixels.iter().map(|&pixel| with[pixel] + without[pixel])) + fixed;
            signal / noise.sqrt()
        }
        _ => f64::NAN,
    })
}

/// Spread of the radiance over its mean, without noise: from products of different groups, in which noise averages to
/// nothing.
fn unevenness(film: &Film, pixels: &[usize]) -> Value {
    let groups = film.groups.len();
    if pixels.is_empty() {
        return Value::undefined("the camera sees no pixel of the disc");
    }
    if groups < 3 {
        return Value::undefined("the image has too few replicates to part its shape from its noise");
    }
    // Deviations of every group from its mean over the disc.
    let deviations: Vec<(f64, Vec<f64>)> = (film.groups.iter())
        .map(|group| {
            let values = || pixels.iter().map(|&pixel| f64::from(group.mean[pixel]));
            let average = mean(values());
            (average, values().map(|value| value - average).collect())
        })
        .collect();
    let of = |left_out: usize| {
        let kept: Vec<_> = (0..groups).filter(|&k| k != left_out).map(|k| &deviations[k]).collect();
        let (mut products, mut pairs) = (0.0, 0.0);
        for (k, (_, a)) in kept.iter().enumerate() {
            for (_, b) in &kept[..k] {
                products += a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>() / pixels.len() as f64;
                pairs += 1.0;
            }
        }
        let average = mean(kept.iter().map(|(average, _)| *average));
        (products / pairs, average)
    };
    let spread = |(variance, average): (f64, f64)| variance.max(0.0).sqrt() / average;
    let value = spread(of(usize::MAX));
    let changes: f64 = (0..groups).map(|k| (spread(of(k)) - value).powi(2)).sum();
    let n = groups as f64;
    let half = quantile_95(n - 1.0) * ((n - 1.0) / n * changes).sqrt();
    Value::known(value, (value - half).max(0.0), value + half)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::camera::noise::PixelRandom;
    use crate::film::BlockAccumulator;

    /// A film of a given shape, with noise that neighbours share.
    fn film(seed: u32, shape: impl Fn(usize) -> f64, noise: f64, replicates: u32) -> Film {
        let mut sums = BlockAccumulator::new(16, 12);
        for replicate in 0..replicates {
            let mut random = PixelRandom::new(seed, replicate);
            let common = noise * random.normal();
            let pixel = |k| shape(k) + common + noise * random.normal();
            sums.add(&(0..192).map(pixel).collect::<Vec<_>>()).unwrap();
        }
        sums.finish()
    }

    fn holds(value: &Value, truth: f64) -> bool {
        matches!(value, Value::Known { low, high, .. } if (*low..=*high).contains(&truth))
    }

    #[test]
    fn a_mean_of_pixels_that_move_together_is_held_by_its_interval() {
        for replicates in [16, 31, 67] {
            let held = (0..400).filter(|&seed| {
                let film = film(seed, |_| 5.0, 0.5, replicates);
                holds(&jackknife(&[&film], |means| mean(means[0].iter().copied())), 5.0)
            });
            let held = held.count();
            // 380 of 400 and three standard deviations of 4.4.
            assert!((366..=394).contains(&held), "{replicates}: {held}");
        }
    }

    #[test]
    fn a_ratio_of_two_regions_is_held_by_its_interval() {
        let shape = |k: usize| if k < 96 { 6.0 } else { 4.0 };
        let contrast = |means: &[&[f64]]| {
            let [a, b] = [mean(means[0][..96].iter().copied()), mean(means[0][96..].iter().copied())];
            (a - b) / (a + b)
        };
        let held = (0..400).filter(|&seed| holds(&jackknife(&[&film(seed, shape, 0.5, 16)], contrast), 0.2)).count();
        assert!((366..=394).contains(&held), "{held}");
        // Two films that are independent of each other.
        let difference = |means: &[&[f64]]| mean(means[0].iter().copied()) - mean(means[1].iter().copied());
        let held = (0..400).filter(|&seed| {
            let (a, b) = (film(2 * seed, |_| 5.0, 0.5, 16), film(2 * seed + 1, |_| 4.0, 0.5, 16));
            holds(&jackknife(&[&a, &b], difference), 1.0)
        });
        assert!(held.count() >= 366);
    }

    #[test]
    fn unevenness_is_of_the_shape_and_not_of_the_noise() {
        let shape = |k: usize| if k.is_multiple_of(2) { 5.5 } else { 4.5 };
        let all: Vec<usize> = (0..192).collect();
        let of = |seed, shape: &dyn Fn(usize) -> f64| unevenness(&film(seed, shape, 1.0, 16), &all);
        let held = (0..200).filter(|&seed| holds(&of(seed, &shape), 0.1)).count();
        assert!(held >= 180, "{held}");
        // Of an even face little is found, though each group's own spread is 0.2.
        let most = (0..200).filter_map(|seed| of(seed, &|_| 5.0).best().copied()).fold(0.0, f64::max);
        assert!(most < 0.05, "{most}");
    }

    #[test]
    fn counted_shares_hold_at_their_ends() {
        assert!(holds(&of_counted(0.0, 1000), 0.002) && !holds(&of_counted(0.0, 1000), 0.005));
        assert!(holds(&of_counted(1.0, 1000), 0.998));
        assert!(matches!(of_counted(0.3, 0), Value::Undefined { .. }));
    }
}
