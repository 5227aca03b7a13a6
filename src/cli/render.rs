//! `render`: the light of a scene, as radiance and as the camera sees it.

use super::command::{self, command_of_light};
use super::job::{Job, note_exposure};
use super::{Common, Failure, Outcome, print};
use crate::output::OutputFolder;
use crate::pages::facts::{columns, facts, ledger};
use crate::pipeline::Truth;
use clap::Args;
use serde_json::json;
use std::path::PathBuf;

/// Trace the light of a scene: radiance.exr, camera.png and pictures of them.
#[derive(Debug, Args)]
pub(super) struct Render {
    /// Scene file, or preset:NAME for a scene that comes with the program.
    scene: PathBuf,
    #[command(flatten)]
    common: Common,
}

impl Render {
    pub(super) fn run(&self) -> Result<Outcome, Failure> {
        let common = &self.common;
        let mut job = Job::read(&self.scene, common)?;
        let folder = OutputFolder::create(&common.destination(job.name()), common.force)?;
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
        if common.talk.json {
            print(&done.json)?;
        } else {
            let out = done.out;
            let mut rows = facts(&shot);
            rows.push(("light".into(), ledger(&shot)));
            rows.push(("folder".into(), format!("{out}: camera.png radiance.exr radiance.svg relief.svg side.svg")));
            print(&format!("{}\n{}", job.name(), columns(&rows)))?;
        }
        Ok(Outcome::Done)
    }
}
