//! Climbs the ladders of a scene, rung by rung.

use super::light::{Choice, LightError, Subject};
use super::mechanics::{self, Found as PressFound};
use super::{Ladders, Rung, is_lit};
use crate::mechanics::from_scene::press_setup;
use crate::mechanics::press::{Load, Pressed};
use crate::output::{OutputError, Records};
use crate::pipeline::{Order, PipelineError, Session};
use crate::progress::{Observer, Stage};
use crate::scene::LoadedScene;
use crate::trace::Settings;
use serde_json::{Value, json};
use std::str::FromStr;
use std::sync::Arc;
use thiserror::Error;

/// Why ladders were not climbed to their end.
#[derive(Debug, Error)]
#[allow(missing_docs)] // each variant is the error of one part
pub enum ClimbError {
    #[error(transparent)]
    Light(#[from] LightError),
    #[error(transparent)]
    Pipeline(#[from] PipelineError),
    #[error(transparent)]
    Output(#[from] OutputError),
}

/// Which ladders.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// Light alone; a press is run once.
    Light,
    /// Mechanics alone.
    Mechanics,
}

/// What is climbed, and how far.
pub struct Climb<'a> {
    /// The scene, its camera as wanted.
    pub loaded: &'a LoadedScene,
    /// What is asked of the light.
    pub settings: Settings,
    /// What presses and traces it.
    pub session: &'a mut Session,
    /// Highest samples a pixel.
    pub most_spp: u32,
    /// Few and low rungs.
    pub quick: bool,
    /// Part of them alone.
    pub only: Option<Part>,
}

impl FromStr for Part {
    type Err = &'static str;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        match text {
            "light" => Ok(Self::Light),
            "mechanics" => Ok(Self::Mechanics),
            _ => Err("it must be light or mechanics"),
        }
    }
}

impl Climb<'_> {
    /// Highest samples a pixel where none are asked for: four times the scene's.
    pub fn usual_spp(loaded: &LoadedScene, quick: bool) -> u32 {
        if quick { 64 } else { loaded.scene.render.spp.saturating_mul(4).clamp(64, 16_384) }
    }

    /// What its rungs depend on; the camera's pixels were divided by `shrink`.
    pub fn order(&self, shrink: u32) -> Value {
        json!({
            "scene_sha256": self.loaded.sha256,
            "inputs": self.loaded.inputs(),
            "quick": self.quick,
            "most_spp": self.most_spp,
            "shrink": shrink,
            "seed": self.settings.seed,
            "backend": if self.session.devices().is_gpu() { "Gpu" } else { "Cpu" },
            "version": crate::version::VERSION,
            "sources": crate::version::SOURCES,
        })
    }

    /// Climbs all ladders, taking what the records already have.
    ///
    /// # Errors
    /// Those of a stage, of the records, and a stop.
    pub fn run(&mut self, records: &Records, observe: &mut Observer) -> Result<Ladders, ClimbError> {
        let mut rungs = Vec::new();
        let mechanics = match self.only {
            Some(Part::Light) => Err("not asked for".to_owned()),
            _ if self.loaded.scene.press.is_none() => Err("the scene presses nothing".to_owned()),
            _ => self.mechanics(records, &mut rungs, observe)?,
        };
        let light = match self.only {
            Some(Part::Mechanics) => Err("not asked for".to_owned()),
            _ => self.light(records, &mut rungs, observe)?,
        };
        Ok(Ladders { rungs, light, mechanics })
    }

    fn mechanics(
        &self,
        records: &Records,
        rungs: &mut Vec<Rung>,
        observe: &mut Observer,
    ) -> Result<Result<String, String>, ClimbError> {
        let setup = press_setup(self.loaded).map_err(PipelineError::from)?;
        let choices = mechanics::choices(&setup, self.quick);
        // Work grows about with the cube of the divisions: that of a step is that of a mesh.
        let cost = |choice: &mechanics::Choice| (choice.setup.phantom.resolution.subdivision as f64).powi(3);
        let total: f64 = choices.iter().map(cost).sum();
        let (mut before, mut all) = (0.0, Vec::new());
        for choice in choices {
            let what = format!("pressing, {}", choice.setting);
            let name = format!("press-{}-{}", choice.family.replace(' ', "-"), choice.level);
            let found: PressFound = records.item_or(&name, || {
                let done = |stage: Stage| (before + stage.done * cost(&choice)) / total;
                let found =
                    mechanics::run(&choice.setup, &mut |stage| observe(Stage { done: done(stage), what: &what }));
                found.map_err(|error| ClimbError::from(PipelineError::from(error)))
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
                Ok(format!("{}, {} unknowns, at {} {unit}", choice.setting, found.unknowns, load))
            }
            _ => Err("no load was reached on every mesh".to_owned()),
        })
    }

    fn light(
        &mut self,
        records: &Records,
        rungs: &mut Vec<Rung>,
        observe: &mut Observer,
    ) -> Result<Result<String, String>, ClimbError> {
        let pressed = self.pressed(observe)?;
        let step = pressed.as_deref().and_then(|pressed| Some((pressed, pressed.steps.last()?)));
        let subject = Subject {
            loaded: self.loaded,
            press: step,
            settings: self.settings.clone(),
            devices: self.session.devices(),
            most_spp: self.most_spp,
            repeats: if self.quick { 3 } else { 4 },
            quick: self.quick,
        };
        let (reference, why) = subject.reference()?;
        let choices = subject.choices()?;
        let cost = |choice: &Choice| f64::from(choice.spp) * f64::from(subject.repeats);
        let total = f64::from(reference.spp) + choices.iter().map(cost).sum::<f64>();
        let film = records.film_or("reference", || {
            let share = f64::from(reference.spp) / total;
            let observe = &mut |stage: Stage| observe(Stage { done: share * stage.done, what: "reference" });
            Ok::<_, ClimbError>(subject.render_reference(&reference, observe)?)
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
                let done = |stage: Stage| (before + stage.done * cost(choice)) / total;
                let observe = &mut |stage: Stage| observe(Stage { done: done(stage), what: &choice.setting });
                Ok::<_, ClimbError>(subject.measure(choice, &film, observe)?)
            })?;
            rungs.extend(found);
            before += cost(choice);
        }
        Ok(Ok(why))
    }

    /// The scene's press, where it has one.
    fn pressed(&mut self, observe: &mut Observer) -> Result<Option<Arc<Pressed>>, PipelineError> {
        let Some(_) = self.loaded.scene.press else { return Ok(None) };
        let order = Order::of(&self.loaded.scene);
        self.session.press(self.loaded, &order, observe).map(Some)
    }
}
