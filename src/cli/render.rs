//! `render`: the light of a scene, as radiance and as the camera sees it.

use super::command::{self, command_of_light};
use super::flags::SceneFile;
use super::job::{Job, note_exposure};
use super::{Common, Failure, Outcome};
use crate::pages::facts::{columns, facts, ledger};
use crate::pipeline::Truth;
use clap::Args;
use serde_json::json;

/// Trace the light of a scene: radiance.exr, camera.png and pictures of them.
#[derive(Debug, Args)]
pub(super) struct Render {
    #[command(flatten)]
    scene: SceneFile,
    #[command(flatten)]
    common: Common,
}

impl Render {
    pub(super) fn run(&self) -> Result<Outcome, Failure> {
        let common = &self.common;
        let mut job = Job::read(&self.scene, common)?;
        let folder = common.place.take(&job.loaded.scene.name)?;
        let prepared = job.prepare()?;
        let shot = job.shoot(&prepared)?;
        note_exposure(&shot.suited, prepared.scene().camera.sensor.exposure_ms, common.talk.quiet);
        let pictures = shot.write_pictured(&folder, &command_of_light())?;
        let truth = Truth::of(prepared.scene().phantom.as_ref(), &job.loaded.files, common.without_inclusions)?;
        let mut summary = shot.summary();
        summary.stages_seconds.files = pictures.files_seconds;
        let mut result = json!(summary);
        result["truth"] = json!(truth);
        let done = command::commit(folder, Some(&job.loaded.text), result)?;
        let mut rows = facts(&shot);
        rows.push(("light".into(), ledger(&shot)));
        let written = "camera.png radiance.exr radiance.svg relief.svg side.svg";
        rows.push(("folder".into(), format!("{}: {written}", done.out)));
        common.talk.tell(&done.json, format!("{}\n{}", job.loaded.scene.name, columns(&rows)))
    }
}
