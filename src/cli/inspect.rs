//! `inspect`: what was understood of a scene, and what a render of it would do.

use super::job::{Job, check_light, open_with, watched};
use super::pressing::PressFailure;
use super::{Failure, Outcome, Talk, print};
use crate::mechanics::from_scene::press_cost;
use crate::pages::facts::columns;
use crate::pages::inspection::{Device, Seen, cost_json, cost_text};
use crate::pages::regimes::layers;
use crate::pages::truth::{loads, phantom_rows};
use crate::pipeline::{Prepared, Truth};
use crate::scene::LoadedScene;
use crate::streams::{Role, Streams};
use crate::trace::gains::{Gain, gains, small};
use crate::trace::{BackendChoice, Devices, Kernel, Plan, Precision};
use crate::vary::Set;
use clap::Args;
use serde_json::json;
use std::path::{Path, PathBuf};

/// Show what was understood of a scene: angles, regimes, kernel pieces, adapter.
#[derive(Debug, Args)]
pub(super) struct Inspect {
    /// Scene file, or preset:NAME for a scene that comes with the program.
    scene: PathBuf,
    /// Measure what it gains to leave out what the scene does not need: small images with each piece and without, in
    /// turn.
    #[arg(long)]
    gains: bool,
    /// Rounds of that.
    #[arg(long, value_name = "N", default_value_t = 5, requires = "gains", value_parser = clap::value_parser!(u32).range(2..=100), allow_negative_numbers = true)]
    rounds: u32,
    /// Set a key of the scene, as in `stack.layer[0].n=1.42`; may be given again.
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<Set>,
    #[command(flatten)]
    talk: Talk,
}

impl Inspect {
    pub(super) fn run(&self) -> Result<Outcome, Failure> {
        let (loaded, file) = open_with(&self.scene, &self.set)?;
        if check_light(&loaded, &file).is_err() && !self.gains {
            return self.mechanics(&loaded, &file).map(|()| Outcome::Done);
        }
        check_light(&loaded, &file)?;
        let prepared = Job::sketch(&self.scene, &self.set)?;
        let model = &prepared.model;
        let devices = Devices::open(BackendChoice::Auto, Precision::F32);
        let kernel = Kernel::of(model);
        let plan = Plan::choose(prepared.settings.integrator, &kernel)?;
        let device = Device::of(&devices, model);
        let press = press_cost(&loaded).map_err(|error| PressFailure::of(error, &file).failure)?;
        let gains = if self.gains { Some(self.measure(&devices?, &prepared)?) } else { None };
        let truth = truth_of(&loaded)?;
        let seen = Seen { layers: layers(&prepared), prepared: &prepared, kernel, plan, device, press, truth, gains };
        match self.talk.json {
            true => print(&seen.json()?.to_string())?,
            false => print(&seen.text()?)?,
        }
        let same = seen.gains.iter().flatten().all(|gain| gain.same_image);
        Ok(if same { Outcome::Done } else { Outcome::CheckFailed })
    }

    /// What a scene without light does: its press.
    fn mechanics(&self, loaded: &LoadedScene, file: &Path) -> Result<(), Failure> {
        let (scene, press) =
            (&loaded.scene, press_cost(loaded).map_err(|error| PressFailure::of(error, file).failure)?);
        if self.talk.json {
            let light = json!({"undefined": "an indenter guides no light"});
            let press = press.map(|cost| cost_json(&cost));
            let (truth, description) = (truth_of(loaded)?, &scene.description);
            let said = json!({
                "scene": scene.name, "description": description, "light": light, "truth": truth, "press": press
            });
            return print(&said.to_string());
        }
        let light = ("light".to_owned(), "none: an indenter presses in the sensor's place".to_owned());
        let press = press.map(|cost| ("press".to_owned(), cost_text(&cost)));
        let loads = scene.press.as_ref().map(|press| ("loads".to_owned(), loads(press)));
        let rows: Vec<_> =
            std::iter::once(light).chain(phantom_rows(&truth_of(loaded)?)).chain(loads).chain(press).collect();
        print(&format!("{}: {}\n\n{}", scene.name, scene.description, columns(&rows)))
    }

    fn measure(&self, devices: &Devices, prepared: &Prepared) -> Result<Vec<Gain>, Failure> {
        let (model, settings) = small(&prepared.model, &prepared.settings);
        let other = Streams { role: Role::Timing, ..prepared.streams.clone() };
        Ok(watched(self.talk.quiet, |observe| gains(devices, &model, &settings, other.light(), self.rounds, observe))?)
    }
}

fn truth_of(loaded: &LoadedScene) -> Result<Truth, Failure> {
    Ok(Truth::of(loaded.scene.phantom.as_ref(), &loaded.files, false)?)
}
