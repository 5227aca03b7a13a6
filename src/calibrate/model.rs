//! A calibration: what was learnt, what for, and what frames say by it.

use super::{Blocks, CalibrateError, Frames, Training};
use crate::estimate::{Detected, Estimates, Value};
use crate::infer::{Learnt, Nuisance, Posterior, Scored, Seen, TAILS, Told, Unknown};
use crate::scene::{Camera, DepthTo, Input, LoadedScene, parse};
use crate::vary::{KeyPath, Scalar, Vary};
use serde::{Deserialize, Serialize};
use statrs::distribution::{ChiSquared, ContinuousCDF as _, FisherSnedecor};
use std::path::Path;

/// Blocks are used where their light is nowhere below this share of the frame's brightest.
const LEAST_LIGHT: f64 = 0.03;
/// Relative standard deviation that LEDs' powers are allowed, each on its own (their drift, and the exposure's).
const LED_SPREAD: f64 = 0.03;
/// Level of the test whether there is an inclusion.
const LEVEL: f64 = 0.01;
/// Share of all power that one LED has where it is lit alone.
const LIT_ALONE: f64 = 0.999;
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

/// What an unknown is of an inclusion.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Role {
    Size,
    Depth,
    Youngs,
    Other,
}

/// A calibration of one sensor.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FrameModel {
    /// What made it.
    pub version: String,
    /// The sensor's scene.
    scene: String,
    /// Depths of the loads, mm.
    pub depths_mm: Vec<f64>,
    /// Columns and rows of blocks.
    blocks: [u32; 2],
    /// Load and block of each element.
    elements: Vec<[usize; 2]>,
    roles: Vec<Role>,
    /// Keys of each unknown.
    keys: Vec<Vec<String>>,
    learnt: Learnt,
    /// The same of phantoms without an inclusion.
    empty: Option<Scored>,
}

impl FrameModel {
    /// Learns from phantoms; `leds` are frames of one LED at a time, `empty` those of phantoms without an inclusion.
    ///
    /// # Errors
    /// Too few points, sweeps that do not fit together.
    pub fn learn(design: &Training, leds: Option<&Training>, empty: Option<&Training>) -> Result<Self, CalibrateError> {
        let total = design.blocks.total();
        let places = (0..design.depths_mm.len()).flat_map(|load| (0..total).map(move |block| [load, block]));
        let of = |light: &[f64], [load, block]: [usize; 2]| light.get(load * total + block).copied().unwrap_or(0.0);
        let brightest =
            |light: &[f64], load: usize| light.iter().skip(load * total).take(total).copied().fold(0.0, f64::max);
        let others = leds.into_iter().chain(empty);
        let all: Vec<&Vec<f64>> = design.light.iter().chain(others.clone().flat_map(|one| &one.light)).collect();
        let lit = |place: &[usize; 2]| all.iter().all(|light| of(light, *place) > 0.0);
        let bright = |place: &[usize; 2]| {
            design.light.iter().all(|light| of(light, *place) > LEAST_LIGHT * brightest(light, place[0]))
        };
        let elements: Vec<[usize; 2]> = places.filter(|place| lit(place) && bright(place)).collect();
        let unsuited = |training: &Training, why: &str| CalibrateError::Unsuited {
            folder: training.folder.clone(),
            why: why.to_owned(),
        };
        if others.clone().any(|other| other.sweep.base.text != design.sweep.base.text) {
            return Err(unsuited(design, "and the other sweeps are not of one scene"));
        }
        if let Some(other) = [Some(design), empty].into_iter().flatten().find(|one| one.unknowns.len() != one.free) {
            return Err(unsuited(other, "draws a variable that is neither uniform nor log_uniform"));
        }
        if elements.is_empty() {
            return Err(unsuited(design, "has no part of a frame that all phantoms light"));
        }
        let logs = |training: &Training| -> Vec<Vec<f64>> {
            let vector = |light: &Vec<f64>| elements.iter().map(|place| of(light, *place).ln()).collect();
            training.light.iter().map(vector).collect()
        };
        let weights: Vec<f64> =
            elements.iter().map(|[load, _]| 1.0 / design.errors.get(*load).copied().unwrap_or(1.0).max(1e-6)).collect();
        let mut learnt = Learnt::from(design.unknowns.clone(), &design.points, &logs(design), weights)?;
        if learnt.directions.is_empty() {
            return Err(unsuited(design, "has frames that do not follow what was drawn"));
        }
        if let Some(leds) = leds {
            let changes = nuisances(leds, &elements, &learnt.weights, of);
            learnt.nuisances = changes.ok_or_else(|| unsuited(leds, "does not light each LED alone"))?;
        }
        let beside = |empty: &Training| learnt.beside(empty.unknowns.clone(), &empty.points, &logs(empty));
        let empty = empty.map(beside).transpose()?;
        let inclusion = design.sweep.base.scene.phantom.as_ref().and_then(|phantom| phantom.inclusion.first());
        let is_of_top = inclusion.is_some_and(|inclusion| inclusion.depth_to == DepthTo::Top);
        let key = |unknown: &Unknown| {
            let named = |vary: &&Vary| match (&vary.name, &vary.key) {
                (Some(name), _) => *name == unknown.name,
                (None, keys) => keys.as_ref().is_some_and(|keys| keys.all() == [unknown.name.as_str()]),
            };
            let keys = design.sweep.file.vary.iter().find(named).and_then(|vary| vary.key.as_ref());
            keys.map(|keys| keys.all().to_vec()).unwrap_or_default()
        };
        let role = |keys: &Vec<String>| match keys.first().map(String::as_str) {
            Some("phantom.inclusion[0].shape.diameter_mm") => Role::Size,
            Some("phantom.inclusion[0].depth_mm") if is_of_top => Role::Depth,
            Some("phantom.inclusion[0].material.youngs_kpa") => Role::Youngs,
            _ => Role::Other,
        };
        let own: Vec<Vec<String>> = learnt.scored.unknowns.iter().map(key).collect();
        Ok(Self {
            version: env!("CARGO_PKG_VERSION").into(),
            scene: design.sweep.base.text.clone(),
            depths_mm: design.depths_mm.clone(),
            blocks: design.blocks.count,
            elements,
            roles: own.iter().map(role).collect(),
            keys: own,
            learnt,
            empty,
        })
    }

    /// Reads a calibration from a file.
    ///
    /// # Errors
    /// A file that cannot be read, or is no calibration.
    pub fn load(file: &Path) -> Result<Self, CalibrateError> {
        let wrong = |why: String| CalibrateError::File { file: file.to_path_buf(), why };
        let input = Input::read(file.to_path_buf()).map_err(|error| wrong(error.to_string()))?;
        let text = String::from_utf8(input.bytes.to_vec()).map_err(|_| wrong("it is not UTF-8".into()))?;
        Self::parse(&text, file)
    }

    /// The sensor's camera, read with so many pixels; none where they do not fill its sensor.
    pub fn camera(&self, pixels: [u32; 2]) -> Option<(Camera, f64)> {
        let scene = parse(&self.scene, Path::new("calibration")).ok()?.scene;
        let [columns, rows] = scene.camera.pixels;
        let even = u64::from(columns) * u64::from(pixels[1]) == u64::from(rows) * u64::from(pixels[0]);
        let pixel_pitch_um = scene.camera.pixel_pitch_um * f64::from(columns) / f64::from(pixels[0].max(1));
        even.then(|| (Camera { pixels, pixel_pitch_um, ..scene.camera.clone() }, scene.light.wavelength_nm))
    }

    /// Reads a calibration.
    ///
    /// # Errors
    /// A text that is none.
    pub fn parse(text: &str, file: &Path) -> Result<Self, CalibrateError> {
        let wrong = |why: String| CalibrateError::File { file: file.to_path_buf(), why };
        let model: Self = serde_json::from_str(text).map_err(|error| wrong(error.to_string()))?;
        let n = model.elements.len();
        let fits = model.learnt.is_whole(n)
            && model.empty.as_ref().is_none_or(|empty| empty.is_whole(model.learnt.directions.len()));
        let blocks = Blocks { count: model.blocks };
        let inside =
            model.elements.iter().all(|[load, block]| *load < model.depths_mm.len() && *block < blocks.total());
        let unknowns = model.learnt.scored.unknowns.len();
        match fits && inside && [model.roles.len(), model.keys.len()] == [unknowns; 2] && n > 0 {
            true => Ok(model),
            false => Err(wrong("its parts do not fit together".into())),
        }
    }

    /// Numbers by which frames are told apart.
    pub fn scores(&self) -> usize {
        self.learnt.directions.len()
    }

    /// Whether frames of a scene are those of this sensor, with phantoms of this kind.
    ///
    /// # Errors
    /// Says what differs.
    pub fn suits(&self, loaded: &LoadedScene) -> Result<(), String> {
        let (ours, theirs) = (self.bare(&self.scene)?, self.bare(&loaded.text)?);
        if let Some(key) = difference(&ours, &theirs, "") {
            return Err(format!("it was learnt of a scene with another {key}"));
        }
        // What an inclusion is like is what is asked; all else that varied must be within what was learnt.
        let scene = serde_json::to_value(&loaded.scene).map_err(|error| error.to_string())?;
        let at = |key: &str| scene.pointer(&format!("/{}", key.replace(['.', '['], "/").replace(']', "")))?.as_f64();
        let others = self.learnt.scored.unknowns.iter().zip(&self.keys).zip(&self.roles);
        let others = others.filter(|(_, role)| **role == Role::Other);
        let mut outside =
            others.flat_map(|((one, keys), _)| keys.iter().map(move |key| (one, key))).filter_map(|(one, key)| {
                let [low, high] = one.prior.bounds().map(|end| one.prior.value(end));
                let value = at(key).filter(|value| !(low..=high).contains(value))?;
                Some(format!("it was learnt of {key} from {} to {}, the scene has {value}", short(low), short(high)))
            });
        outside.next().map_or(Ok(()), Err)
    }

    /// A scene's text without what may differ.
    fn bare(&self, text: &str) -> Result<toml::Value, String> {
        let document = text.parse::<toml_edit::DocumentMut>();
        let mut document = document.map_err(|error| error.to_string())?;
        for key in self.keys.iter().flatten() {
            let path = key.parse::<KeyPath>()?;
            path.set(document.as_item_mut(), &Scalar::Number(1.0))?;
        }
        let table = document.to_string().parse::<toml::Table>().map_err(|error| error.to_string())?;
        let mut value = toml::Value::Table(table);
        let sensor_mm = sensor_mm(&value);
        for key in ["name", "description", "render"] {
            remove(&mut value, &[key]);
        }
        for key in ["depths_mm", "estimate_error", "resolution"] {
            remove(&mut value, &["press", key]);
        }
        for key in ["pixels", "pixel_pitch_um", "sensor"] {
            remove(&mut value, &["camera", key]);
        }
        if let Some(camera) = value.get_mut("camera").and_then(toml::Value::as_table_mut) {
            camera.insert("pixels times pixel_pitch_um".into(), toml::Value::Array(sensor_mm));
        }
        Ok(value)
    }

    /// What frames say of the inclusion.
    pub fn estimates(&self, frames: &Frames) -> Estimates {
        let undefined = |why: String| Estimates {
            size_mm: Value::undefined(why.clone()),
            depth_mm: Value::undefined(why.clone()),
            youngs_kpa: Value::undefined(why.clone()),
            detected: Detected::Undefined { undefined: why },
        };
        let seen = match self.seen(frames) {
            Ok(seen) => seen,
            Err(why) => return undefined(why),
        };
        let Some(told) = self.learnt.told(&seen) else {
            return undefined("too few parts of the frames can be read: they are saturated or dark".into());
        };
        if told.noise_factor > NOISIEST {
            return undefined(format!(
                "the frames are not like those that the calibration knows: what it does not explain is {:.0} times \
                 as strong as noise",
                told.noise_factor.sqrt()
            ));
        }
        let Ok(posterior) = self.learnt.scored.posterior(&told, SEED) else {
            return undefined("the calibration cannot be inverted".into());
        };
        let nuisances = self.learnt.off(&seen, &posterior.scores).unwrap_or_default();
        let off = self.learnt.nuisances.iter().zip(&nuisances).find(|(_, off)| off.abs() > MOST_OFF);
        if let Some((nuisance, off)) = off {
            return undefined(format!(
                "the frames differ from what the calibration allows: {} would be {} % off; compare power, exposure, black \
                 level and bits",
                nuisance.name,
                short(100.0 * LED_SPREAD * off)
            ));
        }
        // As many degrees of freedom as scores: on the safe side, for the unknowns take some.
        if chance(posterior.misfit, self.scores() as f64) < LEAST_CHANCE {
            return undefined(format!(
                "no phantom that the calibration knows gives these frames (sum of squares {} for {} scores)",
                short(posterior.misfit),
                self.scores()
            ));
        }
        let detected = self.detected(&told, &posterior);
        if detected == Detected::Known(false) {
            let none = || Value::undefined("no inclusion is told from none");
            return Estimates { size_mm: none(), depth_mm: none(), youngs_kpa: none(), detected };
        }
        let of = |role: Role| match self.roles.iter().position(|one| *one == role) {
            Some(k) => self.value(&posterior, k),
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
fn short(value: f64) -> String {
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

/// Changes of the frames by the power of each LED; none where an LED is never lit alone.
fn nuisances(
    leds: &Training,
    elements: &[[usize; 2]],
    weights: &[f64],
    of: impl Fn(&[f64], [usize; 2]) -> f64,
) -> Option<Vec<Nuisance>> {
    let powers = |scene: &LoadedScene| -> Option<Vec<f64>> { scene.scene.led.iter().map(|led| led.power_mw).collect() };
    let own = powers(&leds.sweep.base)?;
    // Mean light of each LED alone, at its power in the base scene.
    let mut alone = vec![(0.0, vec![0.0; elements.len()]); own.len()];
    for (row, light) in leds.rows.iter().zip(&leds.light) {
        let powers = powers(&leds.sweep.scene(&leds.sweep.plan.point(*row).ok()?).ok()?)?;
        let (lit, power) = powers.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1))?;
        if *power < LIT_ALONE * powers.iter().sum::<f64>() {
            return None;
        }
        let (count, sums) = alone.get_mut(lit)?;
        *count += 1.0;
        sums.iter_mut().zip(elements).for_each(|(sum, place)| *sum += of(light, *place) * own[lit] / power);
    }
    let means: Option<Vec<Vec<f64>>> = (alone.into_iter())
        .map(|(count, sums)| (count > 0.0).then(|| sums.into_iter().map(|sum| sum / count).collect()))
        .collect();
    let means = means?;
    let whole: Vec<f64> = (0..elements.len()).map(|i| means.iter().map(|mean| mean[i]).sum()).collect();
    let change = |mean: &Vec<f64>| -> Vec<f64> {
        let shares = mean.iter().zip(&whole).map(|(mean, whole)| if *whole > 0.0 { mean / whole } else { 0.0 });
        shares.zip(weights).map(|(share, weight)| LED_SPREAD * share * weight).collect()
    };
    let named = |(k, mean): (usize, &Vec<f64>)| Nuisance { name: format!("led[{k}].power_mw"), change: change(mean) };
    Some(means.iter().enumerate().map(named).collect())
}

/// Extent of the sensor, mm, to a thousandth.
fn sensor_mm(scene: &toml::Value) -> Vec<toml::Value> {
    let camera = scene.get("camera");
    let pitch = camera.and_then(|camera| camera.get("pixel_pitch_um")).and_then(number).unwrap_or(0.0);
    let pixels = camera.and_then(|camera| camera.get("pixels")).and_then(toml::Value::as_array);
    let extent = |pixels: &toml::Value| (number(pixels).unwrap_or(0.0) * pitch).round() * 1e-3;
    pixels.into_iter().flatten().map(|pixels| toml::Value::Float(extent(pixels))).collect()
}

fn number(value: &toml::Value) -> Option<f64> {
    value.as_float().or_else(|| value.as_integer().map(|v| v as f64))
}

fn remove(value: &mut toml::Value, path: &[&str]) {
    if let ([last], Some(table)) = (path, value.as_table_mut()) {
        table.remove(*last);
    } else if let [first, rest @ ..] = path
        && let Some(inner) = value.get_mut(*first)
    {
        remove(inner, rest);
    }
}

/// The first key that differs.
fn difference(a: &toml::Value, b: &toml::Value, at: &str) -> Option<String> {
    match (a, b) {
        (toml::Value::Table(a), toml::Value::Table(b)) => {
            let keys = a.keys().chain(b.keys().filter(|key| !a.contains_key(*key)));
            let inner = |key: &String| if at.is_empty() { key.clone() } else { format!("{at}.{key}") };
            let mut keys = keys.filter_map(|key| match (a.get(key), b.get(key)) {
                (Some(a), Some(b)) => difference(a, b, &inner(key)),
                _ => Some(inner(key)),
            });
            keys.next()
        }
        (toml::Value::Array(a), toml::Value::Array(b)) if a.len() == b.len() => {
            let mut inner = a.iter().zip(b).enumerate();
            inner.find_map(|(k, (a, b))| difference(a, b, &format!("{at}[{k}]")))
        }
        (a, b) if number(a).is_some() && number(a) == number(b) => None,
        (a, b) => (a != b).then(|| at.to_owned()),
    }
}
