//! What frames say of an inclusion by a calibration, and where it says nothing.

use super::model::{LED_SPREAD, Role};
use super::{Blocks, FrameModel, Frames};
use crate::estimate::{Detected, Estimates, Value};
use crate::infer::{Posterior, Seen, TAILS, Told};
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
const EDGE: f64 = 0.05;
const AT_EDGE: f64 = 0.2;
/// Standard deviations that a nuisance may be off.
const MOST_OFF: f64 = 5.0;
/// Light that is so many times as noisy as that of the training images (variances) is of another kind.
const NOISIEST: f64 = 30.0;
/// Chance below which the frames are not those of any phantom that was learnt.
const LEAST_CHANCE: f64 = 1e-4;
/// Seed of the draws.
const SEED: u32 = 1;

impl FrameModel {
    /// What frames say of the inclusion.
    pub fn estimates(&self, frames: &Frames) -> Estimates {
        self.inverted(frames).0
    }

    /// The same, and what is known of all unknowns where the frames are those of a phantom.
    pub fn inverted(&self, frames: &Frames) -> (Estimates, Option<Posterior>) {
        match self.posterior(frames) {
            Err(why) => (Self::nothing(why), None),
            Ok((told, posterior)) => (self.said(&told, &posterior), Some(posterior)),
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

    /// What frames tell of the scores, and of the unknowns.
    ///
    /// # Errors
    /// Says why the frames are not those of a phantom that the calibration knows.
    fn posterior(&self, frames: &Frames) -> Result<(Told, Posterior), String> {
        let seen = self.seen(frames)?;
        let told = self.learnt.told(&seen);
        let told = told.ok_or("too few parts of the frames can be read: they are saturated or dark")?;
        if told.noise_factor > NOISIEST {
            return Err(format!(
                "the frames are not like those that the calibration knows: what it does not explain is {:.0} times \
                 as strong as noise",
                told.noise_factor.sqrt()
            ));
        }
        let posterior = self.learnt.scored.posterior(&told, SEED);
        let posterior = posterior.map_err(|_| "the calibration cannot be inverted")?;
        let nuisances = self.learnt.off(&seen, &posterior.scores).unwrap_or_default();
        let off = self.learnt.nuisances.iter().zip(&nuisances).find(|(_, off)| off.abs() > MOST_OFF);
        if let Some((nuisance, off)) = off {
            return Err(format!(
                "the frames differ from what the calibration allows: {} would be {} % off; compare power, exposure, \
                 black level and bits",
                nuisance.name,
                short(100.0 * LED_SPREAD * off)
            ));
        }
        // As many degrees of freedom as scores: on the safe side, for the unknowns take some.
        if chance(posterior.misfit, self.scores() as f64) < LEAST_CHANCE {
            return Err(format!(
                "no phantom that the calibration knows gives these frames (sum of squares {} for {} scores)",
                short(posterior.misfit),
                self.scores()
            ));
        }
        Ok((told, posterior))
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

    /// Frames as the calibration reads them.
    fn seen(&self, frames: &Frames) -> Result<Seen, String> {
        let blocks = Blocks { count: self.blocks };
        let loads = self.depths_mm.iter().map(|depth_mm| match frames.at(*depth_mm) {
            Some(frame) => frames.blocks(frame, blocks).map(Some),
            None => Ok(None),
        });
        let loads = loads.collect::<Result<Vec<_>, String>>()?;
        if loads.iter().all(Option::is_none) {
            let depths: Vec<String> = self.depths_mm.iter().map(f64::to_string).collect();
            return Err(format!("no frame is of a press that the calibration knows, {} mm deep", depths.join(", ")));
        }
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
    fn value(&self, posterior: &Posterior, k: usize) -> Value {
        let Some(unknown) = self.learnt.scored.unknowns.get(k) else { return Value::undefined("is not an unknown") };
        let tail = 0.5 * (1.0 - SHARE);
        let [low, middle, high] = [tail, 0.5, 1.0 - tail].map(|share| posterior.quantile(k, share));
        if ![low, middle, high].iter().all(|v| v.is_finite()) {
            return Value::undefined("the calibration cannot be inverted");
        }
        let coordinate = |value: f64| unknown.prior.coordinate(value);
        let [first, last] = unknown.prior.bounds();
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
