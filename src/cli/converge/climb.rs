//! Climbs the ladders of a scene, rung by rung.

use super::Only;
use crate::cli::facts::figure;
use crate::cli::job::watched;
use crate::cli::pressing::PressFailure;
use crate::cli::{Failure, Progress, cancel};
use crate::converge::light::{Choice, LightError, Subject};
use crate::converge::mechanics::{self, Found as PressFound};
use crate::converge::{Rung, is_lit};
use crate::mechanics::from_scene::press_setup;
use crate::mechanics::press::{Load, PressError, PressSettings, Pressed, press};
use crate::output::Records;
use crate::progress::Stage;
use crate::scene::LoadedScene;
use crate::trace::{Devices, Settings};
use std::path::Path;

/// What is climbed, and how far.
pub(super) struct Climb<'a> {
    pub loaded: &'a LoadedScene,
    pub file: &'a Path,
    pub settings: Settings,
    pub devices: &'a Devices,
    pub most_spp: u32,
    pub quick: bool,
    pub only: Option<Only>,
    pub quiet: bool,
}

/// What was found.
pub(super) struct Found {
    pub rungs: Vec<Rung>,
    /// What the light was compared with, or why there is no error of the light.
    pub light: Result<String, String>,
    /// The same of the mechanics.
    pub mechanics: Result<String, String>,
}

impl From<LightError> for Failure {
    fn from(error: LightError) -> Self {
        match error {
            LightError::Surface(error) => error.into(),
            LightError::Trace(error) => error.into(),
            LightError::Size => Self::failed(error.to_string()),
        }
    }
}

impl Climb<'_> {
    /// Climbs all ladders, taking what the records already have.
    pub fn run(&self, records: &Records) -> Result<Found, Failure> {
        let mut rungs = Vec::new();
        let mechanics = match self.only {
            Some(Only::Light) => Err("not asked for".to_owned()),
            _ if self.loaded.scene.press.is_none() => Err("the scene presses nothing".to_owned()),
            _ => self.mechanics(records, &mut rungs)?,
        };
        let light = match self.only {
            Some(Only::Mechanics) => Err("not asked for".to_owned()),
            _ => self.light(records, &mut rungs)?,
        };
        Ok(Found { rungs, light, mechanics })
    }

    fn press_failure(&self, error: PressError) -> Failure {
        PressFailure::of(error, self.file).failure
    }

    fn mechanics(&self, records: &Records, rungs: &mut Vec<Rung>) -> Result<Result<String, String>, Failure> {
        let setup = press_setup(self.loaded).map_err(|error| self.press_failure(error))?;
        let choices = mechanics::choices(&setup, self.quick);
        // Work grows about with the cube of the divisions: that of a step is that of a mesh.
        let cost = |choice: &mechanics::Choice| (choice.setup.phantom.resolution.subdivision as f64).powi(3);
        let total: f64 = choices.iter().map(cost).sum();
        let progress = Progress::new(self.quiet);
        let (mut before, mut all) = (0.0, Vec::new());
        for choice in choices {
            let what = format!("pressing, {}", choice.setting);
            let name = format!("press-{}-{}", choice.family.replace(' ', "-"), choice.level);
            let found: PressFound = records.item_or(&name, || {
                let found = mechanics::run(&choice.setup, &mut |stage| {
                    progress.observe((before + stage.done * cost(&choice)) / total, &what);
                    !cancel::requested()
                });
                found.map_err(|error| self.press_failure(error))
            })?;
            before += cost(&choice);
            all.push((choice, found));
        }
        rungs.extend(mechanics::rungs(&all));
        let reference = all.iter().find(|(choice, _)| choice.family == mechanics::MESH && choice.is_reference);
        let unit = match setup.load {
            Load::Depths(_) => "mm",
            Load::Forces(_) => "N",
            Load::Path(_) => "steps",
        };
        Ok(match (reference, mechanics::common_load(&all, mechanics::MESH)) {
            (Some((choice, found)), Some(load)) => {
                Ok(format!("{}, {} unknowns, at {} {unit}", choice.setting, found.unknowns, figure(load)))
            }
            _ => Err("no load was reached on every mesh".to_owned()),
        })
    }

    fn light(&self, records: &Records, rungs: &mut Vec<Rung>) -> Result<Result<String, String>, Failure> {
        let pressed = self.pressed()?;
        let step = pressed.as_ref().and_then(|pressed| Some((pressed, pressed.steps.last()?)));
        let subject = Subject {
            loaded: self.loaded,
            press: step,
            settings: self.settings.clone(),
            devices: self.devices,
            most_spp: self.most_spp,
            repeats: if self.quick { 3 } else { 4 },
            quick: self.quick,
        };
        let (reference, why) = subject.reference()?;
        let choices = subject.choices()?;
        let cost = |choice: &Choice| f64::from(choice.spp) * f64::from(subject.repeats);
        let total = f64::from(reference.spp) + choices.iter().map(cost).sum::<f64>();
        let progress = Progress::new(self.quiet);
        let film = records.film_or("reference", || {
            let observe = &mut |stage: Stage| {
                progress.observe(f64::from(reference.spp) / total * stage.done, "reference");
                !cancel::requested()
            };
            Ok::<_, Failure>(subject.render_reference(&reference, observe)?)
        })?;
        if film.mean.iter().all(|&mean| mean == 0.0) || !is_lit(&film).contains(&true) {
            return Ok(Err("the image is dark: it has no relative error".to_owned()));
        }
        let mut before = f64::from(reference.spp);
        for choice in &choices {
            let name = format!("light-{}-{}-{}", choice.family, choice.series, choice.setting);
            let name: String =
                name.chars().map(|c| if c.is_ascii_alphanumeric() || c == '.' { c } else { '-' }).collect();
            let found: Vec<Rung> = records.item_or(&name, || {
                let observe = &mut |stage: Stage| {
                    progress.observe((before + stage.done * cost(choice)) / total, &choice.setting);
                    !cancel::requested()
                };
                Ok::<_, Failure>(subject.measure(choice, &film, observe)?)
            })?;
            rungs.extend(found);
            before += cost(choice);
        }
        Ok(Ok(why))
    }

    /// The scene's press, where it has one.
    fn pressed(&self) -> Result<Option<Pressed>, Failure> {
        if self.loaded.scene.press.is_none() {
            return Ok(None);
        }
        let setup = press_setup(self.loaded).map_err(|error| self.press_failure(error))?;
        let pressed = watched(self.quiet, |observe| press(&setup, PressSettings::default(), observe));
        pressed.map(Some).map_err(|error| self.press_failure(error))
    }
}
