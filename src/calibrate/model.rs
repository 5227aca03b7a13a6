//! A calibration: what was learnt, and of what.

use super::{Blocks, CalibrateError, LeftOut, Training};
use crate::infer::{Followed, Learnt, Nuisance, Scored, Unknown};
use crate::output::write_whole;
use crate::progress::{Observer, Stage};
use crate::scene::{Camera, DepthTo, Input, LoadedScene, SceneError, parse};
use crate::vary::Vary;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Blocks are used where their light is nowhere below this share of the frame's brightest.
const LEAST_LIGHT: f64 = 0.03;
/// Relative standard deviation that LEDs' powers are allowed, each on its own (their drift, and the exposure's).
pub(super) const LED_SPREAD: f64 = 0.03;
/// Share of all power that one LED has where it is lit alone.
const LIT_ALONE: f64 = 0.999;

/// Standard deviations by which a phantom's worst score may be off where it is left out: of 500 phantoms and 12 scores
/// one of 290 designs has such a one by noise, were it normal. A hint where to look, and no verdict.
const ODD: f64 = 5.0;

/// A phantom that does not go with the others.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Odd {
    /// Its row in the sweep.
    pub row: usize,
    /// Standard deviations by which its worst score is off.
    pub off: f64,
}

/// What is said of them, after how many were learnt from.
pub fn odd_text(odd: &[Odd]) -> String {
    if odd.is_empty() {
        return String::new();
    }
    let rows: Vec<String> = odd.iter().map(|one| format!("{} ({:.0})", one.row, one.off)).collect();
    format!("\nnot like the others, by standard deviations: rows {}; look at their images", rows.join(", "))
}

/// What an unknown is of an inclusion.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Role {
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
    pub(super) scene: String,
    /// Depths of the loads, mm.
    pub depths_mm: Vec<f64>,
    /// Columns and rows of blocks.
    pub(super) blocks: [u32; 2],
    /// Load and block of each element.
    pub(super) elements: Vec<[usize; 2]>,
    pub(super) roles: Vec<Role>,
    /// Keys of each unknown.
    pub(super) keys: Vec<Vec<String>>,
    pub(super) learnt: Learnt,
    /// The same of phantoms without an inclusion.
    pub(super) empty: Option<Scored>,
    /// What came of phantoms that were left out; none where they were too few.
    pub left_out: Option<LeftOut>,
}

impl FrameModel {
    /// Learns from phantoms; `leds` are frames of one LED at a time, `empty` those of phantoms without an inclusion.
    /// None where `observe` says no.
    ///
    /// # Errors
    /// Too few points, sweeps that do not fit together.
    pub fn learn(
        design: &Training,
        leds: Option<&Training>,
        empty: Option<&Training>,
        observe: &mut Observer,
    ) -> Result<Option<Self>, CalibrateError> {
        let mut stopped = false;
        let mut asked = |stage: Stage<'_>| {
            stopped |= !observe(stage);
            !stopped
        };
        if !asked(Stage { done: 0.0, what: "learning" }) {
            return Ok(None);
        }
        let mut model = Self::once(design, leds, empty)?;
        model.left_out = LeftOut::of(design, leds, empty, &mut asked)?;
        Ok((!stopped).then_some(model))
    }

    /// Learns from phantoms, whatever becomes of those that are left out.
    pub(super) fn once(
        design: &Training,
        leds: Option<&Training>,
        empty: Option<&Training>,
    ) -> Result<Self, CalibrateError> {
        let total = design.blocks.total();
        let places = (0..design.depths_mm.len()).flat_map(|load| (0..total).map(move |block| [load, block]));
        let of = |light: &[f64], place: [usize; 2]| at(light, place, total);
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
        let logs = |training: &Training| vectors(training, &elements);
        let weights = weights(&elements, &design.errors, total);
        let alike = elements.iter().map(|[load, block]| load * total + design.blocks.first_image(*block)).collect();
        let keys: Vec<Vec<String>> = design.unknowns.iter().map(|unknown| keys(design, unknown)).collect();
        let roles = roles(design, &keys);
        let unknowns = followed(&design.unknowns, &keys, &roles);
        let mut learnt = Learnt::from(unknowns, &design.points, &logs(design), weights, alike)?;
        if learnt.directions.is_empty() {
            return Err(unsuited(design, "has frames that do not follow what was drawn"));
        }
        if let Some(leds) = leds {
            let changes = nuisances(leds, &elements, &learnt.weights, of);
            learnt.nuisances = changes.ok_or_else(|| unsuited(leds, "does not light each LED alone"))?;
        }
        let beside = |empty: &Training| learnt.beside(empty.unknowns.clone(), &empty.points, &logs(empty));
        let mut without = empty.map(beside).transpose()?;
        let all = |one: &Training| one.forces.iter().all(|forces| forces.len() == design.depths_mm.len());
        if all(design) && empty.is_none_or(all) {
            learnt.scored = learnt.scored.and(&design.points, &design.forces)?;
            let also = without.zip(empty).map(|(without, empty)| without.and(&empty.points, &empty.forces));
            without = also.transpose()?;
        }
        Ok(Self {
            version: env!("CARGO_PKG_VERSION").into(),
            scene: design.sweep.base.text.clone(),
            depths_mm: design.depths_mm.clone(),
            blocks: design.blocks.count,
            elements,
            roles,
            keys,
            learnt,
            empty: without,
            left_out: None,
        })
    }

    /// Logarithms of the light of each element, of each point of a training.
    pub(super) fn vectors(&self, training: &Training) -> Vec<Vec<f64>> {
        vectors(training, &self.elements)
    }

    /// Phantoms that it was learnt from and that do not go with the others: where they are left out a score is farther
    /// off than noise that is normal would be.
    ///
    /// # Errors
    /// A calibration that was learnt from others.
    pub fn odd(&self, design: &Training) -> Result<Vec<Odd>, CalibrateError> {
        let off = self.learnt.left_out(&self.vectors(design))?;
        let all = design.rows.iter().zip(off).map(|(&row, off)| Odd { row, off });
        Ok(all.filter(|one| one.off > ODD).collect())
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

    /// Writes the calibration to a file, whole or not at all; its folder is made.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn write(&self, file: &Path) -> Result<(), CalibrateError> {
        let wrong = |why: String| CalibrateError::File { file: file.to_path_buf(), why };
        let text = serde_json::to_string(self).map_err(|error| wrong(error.to_string()))?;
        Self::parse(&text, file)?;
        Ok(write_whole(file, &format!("{text}\n"))?)
    }

    /// The scene of the sensor that it is of.
    ///
    /// # Errors
    /// A scene that is none.
    pub fn own_scene(&self) -> Result<LoadedScene, SceneError> {
        parse(&self.scene, Path::new("calibration.toml"))
    }

    /// All unknowns, each with the keys of the scene that it stands for.
    pub fn unknowns(&self) -> impl Iterator<Item = (&Unknown, &[String])> {
        self.learnt.scored.unknowns.iter().zip(self.keys.iter().map(Vec::as_slice))
    }

    /// Whether it tells of frames that there is no inclusion.
    pub fn knows_empty(&self) -> bool {
        self.empty.is_some()
    }

    /// The sensor's camera, as its scene has it, and the wavelength of its light, nm.
    ///
    /// # Errors
    /// A scene that is none.
    pub fn own_camera(&self) -> Result<(Camera, f64), SceneError> {
        let scene = parse(&self.scene, Path::new("calibration"))?.scene;
        Ok((scene.camera, scene.light.wavelength_nm))
    }

    /// The sensor's camera, read with so many pixels; none where they do not fill its sensor.
    pub fn camera(&self, pixels: [u32; 2]) -> Option<(Camera, f64)> {
        let (camera, wavelength_nm) = self.own_camera().ok()?;
        let [columns, rows] = camera.pixels;
        let even = u64::from(columns) * u64::from(pixels[1]) == u64::from(rows) * u64::from(pixels[0]);
        let pixel_pitch_um = camera.pixel_pitch_um * f64::from(columns) / f64::from(pixels[0].max(1));
        // As a scene would have it: without what the division leaves beyond a femtometre.
        let pixel_pitch_um = (1e9 * pixel_pitch_um).round() / 1e9;
        even.then_some((Camera { pixels, pixel_pitch_um, ..camera }, wavelength_nm))
    }

    /// Reads a calibration.
    ///
    /// # Errors
    /// A text that is none.
    pub fn parse(text: &str, file: &Path) -> Result<Self, CalibrateError> {
        let wrong = |why: String| CalibrateError::File { file: file.to_path_buf(), why };
        let model: Self = serde_json::from_str(text).map_err(|error| wrong(error.to_string()))?;
        let n = model.elements.len();
        let forces = if model.knows_forces() { model.depths_mm.len() } else { 0 };
        let numbers = model.scores() + forces;
        let fits = model.learnt.is_whole(n)
            && model.learnt.scored.is_whole(numbers)
            && model.empty.as_ref().is_none_or(|empty| empty.is_whole(numbers));
        let blocks = Blocks { count: model.blocks };
        let inside =
            model.elements.iter().all(|[load, block]| *load < model.depths_mm.len() && *block < blocks.total());
        let unknowns = model.learnt.scored.unknowns.len();
        let left_out = model.left_out.as_ref().is_none_or(|left_out| left_out.is_whole(unknowns));
        match fits && inside && left_out && [model.roles.len(), model.keys.len()] == [unknowns; 2] && n > 0 {
            true => Ok(model),
            false => Err(wrong("its parts do not fit together".into())),
        }
    }

    /// Which unknown is the size (0), the depth (1) or the modulus (2) of the inclusion.
    pub fn unknown(&self, figure: usize) -> Option<usize> {
        let role = [Role::Size, Role::Depth, Role::Youngs].get(figure)?;
        self.roles.iter().position(|one| one == role)
    }

    /// The name of that unknown.
    pub fn name(&self, figure: usize) -> Option<&str> {
        Some(&self.learnt.scored.unknowns.get(self.unknown(figure)?)?.name)
    }

    /// Numbers by which frames are told apart.
    pub fn scores(&self) -> usize {
        self.learnt.directions.len()
    }

    /// Whether it knows how the force of each load follows the unknowns.
    pub fn knows_forces(&self) -> bool {
        self.learnt.scored.processes.len() > self.scores()
    }

    /// Among the numbers that follow the unknowns the logarithm of a load's force, with the variance of one that is
    /// measured to a relative error: of the sensor, and of the mesh that it was learnt on.
    ///
    /// # Errors
    /// Says that no forces were learnt.
    pub(super) fn force(&self, load: usize, error: f64) -> Result<(usize, f64), String> {
        let place = self.scores() + load;
        let process = self.learnt.scored.processes.get(place);
        let process = process.ok_or("the calibration knows no forces: learn it anew")?;
        Ok((place, error.powi(2) + process.noise().powi(2)))
    }
}

/// Keys of an unknown.
fn keys(design: &Training, unknown: &Unknown) -> Vec<String> {
    let named = |vary: &&Vary| match (&vary.name, &vary.key) {
        (Some(name), _) => *name == unknown.name,
        (None, keys) => keys.as_ref().is_some_and(|keys| keys.all() == [unknown.name.as_str()]),
    };
    let keys = design.sweep.file.vary.iter().find(named).and_then(|vary| vary.key.as_ref());
    keys.map(|keys| keys.all().to_vec()).unwrap_or_default()
}

/// What unknowns of these keys are of an inclusion.
fn roles(design: &Training, keys: &[Vec<String>]) -> Vec<Role> {
    let inclusion = design.sweep.base.scene.phantom.as_ref().and_then(|phantom| phantom.inclusion.first());
    let is_of_top = inclusion.is_some_and(|inclusion| inclusion.depth_to == DepthTo::Top);
    let role = |keys: &Vec<String>| match keys.first().map(String::as_str) {
        Some("phantom.inclusion[0].shape.diameter_mm") => Role::Size,
        Some("phantom.inclusion[0].depth_mm") if is_of_top => Role::Depth,
        Some("phantom.inclusion[0].material.youngs_kpa") => Role::Youngs,
        _ => Role::Other,
    };
    keys.iter().map(role).collect()
}

/// Unknowns by what frames follow most evenly (docs/decisions/inference.md).
fn followed(unknowns: &[Unknown], keys: &[Vec<String>], roles: &[Role]) -> Vec<Unknown> {
    let matrix = keys.iter().position(|keys| *keys == ["phantom.material.youngs_kpa"]);
    let by = |(unknown, role): (&Unknown, &Role)| {
        let followed = match (role, matrix) {
            (Role::Size, _) => Followed::Value,
            (Role::Depth, _) => Followed::Logarithm,
            (Role::Youngs, Some(matrix)) => Followed::Contrast { matrix },
            _ => Followed::Coordinate,
        };
        Unknown { followed, ..unknown.clone() }
    };
    unknowns.iter().zip(roles).map(by).collect()
}

/// Light of a block at a load, of frames of so many blocks a load.
fn at(light: &[f64], [load, block]: [usize; 2], total: usize) -> f64 {
    light.get(load * total + block).copied().unwrap_or(0.0)
}

/// Logarithms of the light of each element, of each point.
fn vectors(training: &Training, elements: &[[usize; 2]]) -> Vec<Vec<f64>> {
    let total = training.blocks.total();
    let vector = |light: &Vec<f64>| elements.iter().map(|place| at(light, *place, total).ln()).collect();
    training.light.iter().map(vector).collect()
}

/// One over the error of each element's own block at its load, which has so many blocks.
fn weights(elements: &[[usize; 2]], errors: &[f64], total: usize) -> Vec<f64> {
    let error = |[load, block]: &[usize; 2]| errors.get(load * total + block).copied().unwrap_or(1.0);
    elements.iter().map(|place| 1.0 / error(place).max(1e-6)).collect()
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_element_is_weighted_by_its_own_blocks_error() {
        let errors = [0.01, 0.5, 0.02, 0.1, 0.2, 0.04];
        assert_eq!(weights(&[[0, 0], [0, 2], [1, 1], [1, 2]], &errors, 3), [100.0, 50.0, 5.0, 25.0]);
    }
}
