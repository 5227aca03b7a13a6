//! What frames say of an inclusion by a calibration, and where it says nothing.

use super::model::{LED_SPREAD, Role};
use super::{Blocks, FrameModel, Frames};
use crate::estimate::{Detected, Estimates, Value};
use crate::infer::{Nuisance, Posterior, Seen, TAILS, Told, Unknown};
use serde::Serialize;
use statrs::distribution::{ChiSquared, ContinuousCDF as _, FisherSnedecor};

/// Level of the test whether there is an inclusion.
const LEVEL: f64 = 0.01;
/// Unknowns that an inclusion adds.
const OF_AN_INCLUSION: f64 = 3.0;
/// The interval's share.
const SHARE: f64 = 0.95;
/// An interval wider than this share of the prior's tells nothing.
const WIDEST: f64 = 0.8;
/// Share of the range at each end, and of the draws in it beyond which the truth may lie outside.
pub(super) const EDGE: f64 = 0.05;
const AT_EDGE: f64 = 0.2;
/// Standard deviations that a nuisance may be off.
const MOST_OFF: f64 = 5.0;
/// Light that is so many times as noisy as that of the training images (variances) is of another kind.
const NOISIEST: f64 = 30.0;
/// Chance below which the frames are not those of any phantom that was learnt.
const LEAST_CHANCE: f64 = 1e-4;
/// Independent draws that an interval needs: the chance beyond one of its ends is then known to 1 %.
const LEAST_DRAWS: f64 = 200.0;
/// Seed of the draws.
const SEED: u32 = 1;

/// All that frames tell by a calibration.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Inferred {
    /// Every unknown of the calibration, those among them that are of no interest in themselves.
    pub unknowns: Vec<InferredUnknown>,
    /// Correlation of each pair, as they are drawn (logarithms where these are even beforehand).
    pub correlations: Vec<Vec<f64>>,
    /// Powers of the LEDs at the best place; how well they are known is not said.
    pub leds: Vec<LedPower>,
    /// Scores of the frames, and forces.
    pub scores: usize,
    /// Sum of their squared misfits at the best place, in units of their errors. With no fewer unknowns than scores it
    /// is near 0, whatever the frames; what tells a bad fit is `noise`.
    pub misfit: f64,
    /// What is not explained, over the noise of the light of the training images.
    pub noise: f64,
    /// How many independent draws of the unknowns the intervals are made of.
    pub draws: f64,
    /// Draws of the unknowns.
    #[serde(skip)]
    pub posterior: Posterior,
    /// What the frames tell of the scores.
    #[serde(skip)]
    pub told: Told,
}

/// What is known of an unknown.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct InferredUnknown {
    /// Its name in the sweep that the calibration was learnt from.
    pub name: String,
    /// Keys of the scene that it stands for; none where other keys follow from it.
    pub keys: Vec<String>,
    /// Whether it is the inclusion's size, depth or modulus.
    pub is_of_inclusion: bool,
    /// Its value, in the unit of the key.
    pub value: Value,
}

/// An LED's power.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LedPower {
    /// The LED.
    pub name: String,
    /// Share by which its power would be off the scene's.
    pub off: f64,
}

/// Pearson's correlations of draws; 0 where one does not vary.
fn correlations(draws: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let unknowns = draws.first().map_or(0, Vec::len);
    let mean = |k: usize| draws.iter().map(|draw| draw[k]).sum::<f64>() / draws.len() as f64;
    let means: Vec<f64> = (0..unknowns).map(mean).collect();
    let product = |i: usize, j: usize| draws.iter().map(|d| (d[i] - means[i]) * (d[j] - means[j])).sum::<f64>();
    let sizes: Vec<f64> = (0..unknowns).map(|k| product(k, k).sqrt()).collect();
    let of = |i: usize, j: usize| match sizes[i] * sizes[j] {
        size if size > 0.0 => product(i, j) / size,
        _ => 0.0,
    };
    (0..unknowns).map(|i| (0..unknowns).map(|j| of(i, j)).collect()).collect()
}

impl FrameModel {
    /// What frames say of the inclusion.
    pub fn estimates(&self, frames: &Frames) -> Estimates {
        self.inverted(frames).0
    }

    /// The same, and all that is inferred; why nothing is, where the frames are not those of a phantom.
    pub fn inverted(&self, frames: &Frames) -> (Estimates, Result<Inferred, String>) {
        match self.posterior(frames) {
            Err(why) => (Self::nothing(why.clone()), Err(why)),
            Ok((told, posterior, leds)) => {
                let estimates = self.said(&told, &posterior);
                let is_there = estimates.detected != Detected::Known(false);
                (estimates, Ok(self.inferred(told, posterior, &leds, is_there)))
            }
        }
    }

    /// All that is inferred.
    fn inferred(&self, told: Told, posterior: Posterior, leds: &[f64], is_there: bool) -> Inferred {
        let unknowns = &self.learnt.scored.unknowns;
        let value = |k: usize| match self.roles.get(k) {
            Some(Role::Other) => self.value(&posterior, k),
            _ if is_there => self.value(&posterior, k),
            _ => Value::undefined("no inclusion is told from none"),
        };
        let of = |(k, unknown): (usize, &Unknown)| {
            let keys = self.keys.get(k).cloned().unwrap_or_default();
            let is_of_inclusion = self.roles.get(k).is_some_and(|role| *role != Role::Other);
            InferredUnknown { name: unknown.name.clone(), keys, is_of_inclusion, value: value(k) }
        };
        let coordinates = |draw: &Vec<f64>| -> Vec<f64> {
            unknowns.iter().zip(draw).map(|(unknown, value)| unknown.prior.coordinate(*value)).collect()
        };
        let led = |(nuisance, off): (&Nuisance, &f64)| LedPower { name: nuisance.name.clone(), off: LED_SPREAD * off };
        Inferred {
            unknowns: unknowns.iter().enumerate().map(of).collect(),
            correlations: correlations(&posterior.draws.iter().map(coordinates).collect::<Vec<_>>()),
            leds: self.learnt.nuisances.iter().zip(leds).map(led).collect(),
            scores: told.scores.len(),
            misfit: posterior.misfit,
            noise: told.noise_factor.sqrt(),
            draws: posterior.worth,
            posterior,
            told,
        }
    }

    fn nothing(why: String) -> Estimates {
        Estimates {
            size_mm: Value::undefined(why.clone()),
            depth_mm: Value::undefined(why.clone()),
            youngs_kpa: Value::undefined(why.clone()),
            detected: Detected::Undefined { undefined: why },
        }
    }

    /// What frames tell of the scores, of the unknowns, and of LEDs' powers in their standard deviations.
    ///
    /// # Errors
    /// Says why the frames are not those of a phantom that the calibration knows.
    fn posterior(&self, frames: &Frames) -> Result<(Told, Posterior, Vec<f64>), String> {
        self.posterior_of(&self.seen(frames)?, |told| self.with_forces(told, frames))
    }

    /// The same of frames that were read, and of what else was measured, which `beside` adds.
    ///
    /// # Errors
    /// As [`Self::posterior`].
    pub(super) fn posterior_of(
        &self,
        seen: &Seen,
        beside: impl Fn(Told) -> Result<Told, String>,
    ) -> Result<(Told, Posterior, Vec<f64>), String> {
        let told = self.learnt.told(seen);
        let told = told.ok_or("too few parts of the frames can be read: they are saturated or dark")?;
        if told.noise_factor > NOISIEST {
            return Err(format!(
                "the frames are not like those that the calibration knows: what it does not explain is {:.0} times \
                 as strong as noise",
                told.noise_factor.sqrt()
            ));
        }
        let told = beside(told)?;
        let posterior = self.learnt.scored.posterior(&told, SEED);
        let posterior = posterior.map_err(|_| "the calibration cannot be inverted")?;
        let nuisances = self.learnt.off(seen, &posterior.scores).unwrap_or_default();
        let off = self.learnt.nuisances.iter().zip(&nuisances).find(|(_, off)| off.abs() > MOST_OFF);
        if let Some((nuisance, off)) = off {
            return Err(format!(
                "the frames differ from what the calibration allows: {} would be {} % off; compare {}power, exposure, \
                 black level and bits",
                nuisance.name,
                short(100.0 * LED_SPREAD * off),
                if told.has_more { "forces, " } else { "" }
            ));
        }
        // As many degrees of freedom as scores: on the safe side, for the unknowns take some.
        if chance(posterior.misfit, told.scores.len() as f64) < LEAST_CHANCE {
            return Err(format!(
                "no phantom that the calibration knows gives these {} (sum of squares {} for {} numbers)",
                if told.scores.len() > self.scores() { "frames and forces" } else { "frames" },
                short(posterior.misfit),
                told.scores.len()
            ));
        }
        Ok((told, posterior, nuisances))
    }

    /// What is said of the inclusion.
    fn said(&self, told: &Told, posterior: &Posterior) -> Estimates {
        let detected = self.detected(told, posterior);
        if detected == Detected::Known(false) {
            let none = || Value::undefined("no inclusion is told from none");
            return Estimates { size_mm: none(), depth_mm: none(), youngs_kpa: none(), detected };
        }
        let of = |role: Role| match self.roles.iter().position(|one| *one == role) {
            Some(k) => self.value(posterior, k),
            None => Value::undefined("the calibration does not vary it"),
        };
        Estimates { size_mm: of(Role::Size), depth_mm: of(Role::Depth), youngs_kpa: of(Role::Youngs), detected }
    }

    /// What frames tell, and the forces that were measured with them.
    fn with_forces(&self, told: Told, frames: &Frames) -> Result<Told, String> {
        let mut told = told;
        for (load, depth_mm) in self.depths_mm.iter().enumerate() {
            let Some(force_n) = frames.at(*depth_mm).and_then(|frame| frame.force_n) else { continue };
            let (place, variance) = self.force(load, frames.force_error)?;
            told = told.and(place, force_n.ln(), variance);
        }
        Ok(told)
    }

    /// Whether each frame is that of a press which the calibration knows, and of another than the rest.
    fn knows_presses(&self, frames: &Frames) -> Result<(), String> {
        let depths: Vec<String> = self.depths_mm.iter().map(f64::to_string).collect();
        let known = format!("that the calibration knows, {} mm deep", depths.join(", "));
        let mut loads = Vec::new();
        for frame in &frames.frames {
            let depth_mm = frame.depth_mm;
            let load = self.depths_mm.iter().position(|depth_mm| frame.is_of(*depth_mm));
            let load = load.ok_or_else(|| format!("the frame of {depth_mm} mm is of no press {known}"))?;
            if loads.contains(&load) {
                return Err(format!("the frame of {depth_mm} mm is the second of one press"));
            }
            loads.push(load);
        }
        if loads.is_empty() { Err(format!("no frame is of a press {known}")) } else { Ok(()) }
    }

    /// Frames as the calibration reads them.
    fn seen(&self, frames: &Frames) -> Result<Seen, String> {
        self.knows_presses(frames)?;
        let blocks = Blocks { count: self.blocks };
        let loads = self.depths_mm.iter().map(|depth_mm| match frames.at(*depth_mm) {
            Some(frame) => frames.blocks(frame.image, blocks).map(Some),
            None => Ok(None),
        });
        let loads = loads.collect::<Result<Vec<_>, String>>()?;
        let read = |[load, block]: &[usize; 2]| loads.get(*load)?.as_ref()?.get(*block).copied().flatten();
        let read: Vec<_> = self.elements.iter().map(read).collect();
        Ok(Seen {
            values: read.iter().map(|read| read.map(|read| read.log_light)).collect(),
            variances: read.iter().map(|read| read.map_or(0.0, |read| read.variance)).collect(),
        })
    }

    /// Whether an inclusion is told from none: by how much a phantom with one fits better than one without, against
    /// F's distribution: a chi-square number of as many degrees of freedom as an inclusion has unknowns (Wilks 1938),
    /// over the spread that the scores' tails have.
    fn detected(&self, told: &Told, posterior: &Posterior) -> Detected {
        let none = self.empty.as_ref().map(|empty| empty.posterior(told, SEED));
        match none {
            Some(Ok(none)) => {
                let gain = none.misfit - posterior.misfit;
                Detected::Known(chance_in_tails(gain.max(0.0)) < LEVEL)
            }
            Some(Err(error)) => Detected::Undefined { undefined: error.to_string() },
            None => Detected::Undefined { undefined: "the calibration knows no frames without an inclusion".into() },
        }
    }

    /// An unknown with its interval; undefined where the frames do not tell it.
    pub(super) fn value(&self, posterior: &Posterior, k: usize) -> Value {
        let Some(unknown) = self.learnt.scored.unknowns.get(k) else { return Value::undefined("is not an unknown") };
        let tail = 0.5 * (1.0 - SHARE);
        let [low, middle, high] = [tail, 0.5, 1.0 - tail].map(|share| posterior.quantile(k, share));
        if ![low, middle, high].iter().all(|v| v.is_finite()) {
            return Value::undefined("the calibration cannot be inverted");
        }
        if posterior.worth < LEAST_DRAWS {
            return Value::undefined(format!("only {:.0} draws tell it: too few for an interval", posterior.worth));
        }
        let coordinate = |value: f64| unknown.prior.coordinate(value);
        let [first, last] = unknown.prior.bounds();
        let widened = self.left_out.as_ref().map_or(1.0, |left_out| left_out.widened(k));
        let [low, high] = [low, high].map(|end| {
            let end = coordinate(middle) + widened * (coordinate(end) - coordinate(middle));
            unknown.prior.value(end.clamp(first, last))
        });
        let range = format!("{} to {}", short(unknown.prior.value(first)), short(unknown.prior.value(last)));
        let within = |from: f64, to: f64| {
            let there = |draw: &&Vec<f64>| draw.get(k).is_some_and(|v| (from..=to).contains(&coordinate(*v)));
            posterior.draws.iter().filter(there).count() as f64 / posterior.draws.len().max(1) as f64
        };
        let width = last - first;
        if coordinate(high) - coordinate(low) > WIDEST * SHARE * width {
            return Value::undefined(format!(
                "the frames do not tell it: anything from {} to {} may be",
                short(low),
                short(high)
            ));
        }
        if within(first, first + EDGE * width) > AT_EDGE || within(last - EDGE * width, last) > AT_EDGE {
            return Value::undefined(format!("it lies at or beyond the end of what the calibration knows, {range}"));
        }
        Value::known(middle, low, high)
    }
}

/// A number in three digits.
pub(super) fn short(value: f64) -> String {
    let digits = 2.0 - value.abs().max(1e-3).log10().floor();
    format!("{value:.*}", digits.clamp(0.0, 5.0) as usize)
}

/// Chance of as large a gain where there is no inclusion: of F's distribution, as scores have Student's tails.
fn chance_in_tails(gain: f64) -> f64 {
    FisherSnedecor::new(OF_AN_INCLUSION, TAILS).map_or(1.0, |distribution| distribution.sf(gain / OF_AN_INCLUSION))
}

/// Chance of a chi-square number as large.
fn chance(square: f64, freedom: f64) -> f64 {
    ChiSquared::new(freedom).map_or(1.0, |distribution| distribution.sf(square))
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::calibrate::{Held, LeftOut};

    /// The same draws tell a size where they are worth enough, and say so where they are not.
    #[test]
    fn few_draws_tell_nothing() {
        let model = crate::calibrate::ready().unwrap();
        let size = model.unknown(0).unwrap();
        let draw = |k: u32| -> Vec<f64> {
            let middle = |[low, high]: [f64; 2]| 0.5 * (low + high);
            let values = model.learnt.scored.unknowns.iter().map(|one| one.prior.value(middle(one.prior.bounds())));
            values.map(|value| value * (1.0 + 1e-3 * f64::from(k % 10))).collect()
        };
        let posterior =
            |worth: f64| Posterior { draws: (0..100).map(draw).collect(), misfit: 1.0, scores: vec![], worth };
        let told = |worth: f64| model.value(&posterior(worth), size);
        assert!(matches!(told(250.0), Value::Known { .. }), "{:?}", told(250.0));
        let Value::Undefined { reason } = told(150.0) else { panic!("150 draws") };
        assert_eq!(reason, "only 150 draws tell it: too few for an interval");
    }

    /// Intervals are as much wider as phantoms that were left out ask for, in the unknown's coordinate.
    #[test]
    fn intervals_are_widened_about_their_best_value() {
        let mut model = crate::calibrate::ready().unwrap().clone();
        let size = model.unknown(0).unwrap();
        let priors: Vec<_> = model.learnt.scored.unknowns.iter().map(|one| one.prior).collect();
        let draw = |k: u32| {
            let at = |bounds: [f64; 2]| bounds[0] + (0.5 + 2e-4 * f64::from(k)) * (bounds[1] - bounds[0]);
            priors.iter().map(|prior| prior.value(at(prior.bounds()))).collect::<Vec<f64>>()
        };
        let draws = (0..1000).map(draw).collect();
        let posterior = Posterior { draws, misfit: 1.0, scores: vec![], worth: 1000.0 };
        let mut ends = |widened: Option<f64>| {
            let one = Held { name: String::new(), known: 100, held: 90, widened };
            model.left_out = Some(LeftOut { phantoms: 100, refused: 0, unknowns: vec![one; size + 1] });
            let Value::Known { value, low, high } = model.value(&posterior, size) else { panic!("{widened:?}") };
            [low, value, high].map(|value| priors[size].coordinate(value))
        };
        let [narrow, wide] = [ends(None), ends(Some(1.5))];
        assert_eq!(narrow[1], wide[1]);
        for end in [0, 2] {
            assert!(((wide[end] - wide[1]) / (narrow[end] - narrow[1]) - 1.5).abs() < 1e-9, "{narrow:?} {wide:?}");
        }
    }

    /// y = -2 x, z = x + an independent number of the same size, and one that does not vary.
    #[test]
    fn correlations_are_those_of_the_draws() {
        let draw = |k: u32| {
            let (x, own) = (f64::from(k % 10), f64::from(k / 10));
            vec![x, -2.0 * x, x + own, 3.0]
        };
        let found = correlations(&(0..100).map(draw).collect::<Vec<_>>());
        let half = 0.5f64.sqrt();
        let wanted = [[1.0, -1.0, half, 0.0], [-1.0, 1.0, -half, 0.0], [half, -half, 1.0, 0.0], [0.0, 0.0, 0.0, 0.0]];
        for (found, wanted) in found.iter().flatten().zip(wanted.iter().flatten()) {
            assert!((found - wanted).abs() < 1e-12, "{found} {wanted}");
        }
        assert!(correlations(&[]).is_empty());
    }
}
